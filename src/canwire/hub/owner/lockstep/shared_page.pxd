# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
from canwire.hub.protocol.turn_page cimport TurnPage

cdef class SharedPage:
    cdef public object thread
    cdef public TurnPage words
    cdef object _event
    cdef tuple _for_program

    cpdef give(self, unsigned long long now_ns)
