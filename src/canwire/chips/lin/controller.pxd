# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.lin.node cimport LinNode, LinOffer, LinResponse

@cython.final
cdef class LinController(LinNode):
    cdef public object host, ear
    cdef public bint running
    cdef public unsigned long long frames_sent, frames_received, wake_ups
    cdef public list errors
    cdef public object table
    cdef bint _bus_off, _driven, _silence_is_fine
    cdef unsigned long long _start_up_ns
    cdef object _outcome
    cdef dict _headers

    cdef _put(self, LinOffer offer)
    cdef _wake(self, unsigned long long at_ns)
    cdef _count(self, int kind, int id, bint transmitting, unsigned long long at_ns, int before=*)
    cdef bint _is_mine(self, int id, bint transmitting) except -1
    cdef _interrupt(self)
    cdef _changed(self)
