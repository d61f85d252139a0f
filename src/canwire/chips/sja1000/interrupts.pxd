# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython

cdef int _RI, _EI

@cython.final
cdef class Interrupts:
    cdef public int latched, enabled
    cdef public bint active
    cdef public object handler
    cdef bint _running, _edge

    cdef void request(self, int bits) noexcept
    cdef void level(self, bint stored) noexcept
    @cython.locals(value=int)
    cdef int take(self, int kept) noexcept
    cdef void released(self, bint more) noexcept
    cdef void reset(self) noexcept
    cdef int settle(self) except -1
    cdef int _call(self) except -1
