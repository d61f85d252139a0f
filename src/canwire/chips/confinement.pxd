# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython

cdef int _ACTIVE, _WARNING, _PASSIVE, _BUS_OFF, _WARNING_LIMIT, _PASSIVE_LIMIT, _BUS_OFF_LIMIT
cdef int _RECEIVED_RULE, _REC_AFTER_PASSIVE, _RULES
cdef tuple _TEC_STEP, _REC_STEP

@cython.final
cdef class Confinement:
    cdef public int tec, rec, state, warning_limit

    cpdef bint apply(self, int rule) except -1
    cpdef bint transmitted(self) except -1
    cpdef bint received(self) except -1
    cpdef void reset(self) noexcept

    @cython.locals(before=int, worst=int)
    cdef bint _settle(self) noexcept
