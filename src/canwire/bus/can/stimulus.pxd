# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Node

cdef long long _NEVER
cdef int _FREE

@cython.final
cdef class Stimulus:
    cdef public list times_ps, levels, nodes
    cdef public int level
    cdef public Py_ssize_t position
    cdef public long long next_ps

    @cython.locals(more=bint)
    cpdef int advance(self, long long at_ps) except -1
    cpdef bint over(self) except -1
