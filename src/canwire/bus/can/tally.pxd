# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Mailbox, Node

cdef class Tap:
    cpdef transmitted(self, Node node, Mailbox box, unsigned long long at_ns)

@cython.final
cdef class Tally:
    cdef public unsigned long long frames, error_frames, last_success_ns
    cdef public bint erring
    cdef public Tap tap
