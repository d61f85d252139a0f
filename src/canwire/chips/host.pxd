# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
from canwire.bus.can.node cimport Mailbox

cdef class Host:
    cpdef received(self, Mailbox box, unsigned long long at_ns)
    cpdef transmitted(self, Mailbox box, unsigned long long at_ns)
    cpdef aborted(self, Mailbox box, unsigned long long at_ns)
    cpdef fill(self, unsigned long long at_ns)
    cpdef event(self, int kind, int error, int bit, bint transmitting, unsigned long long at_ns, int code)
