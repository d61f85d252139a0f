# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython

cdef long long _NEVER

cdef class Participant:
    cdef public object name, place
    cdef public long long thread, until_ns
    cdef public bint waits, woken, deaf

cdef class Turns:
    cdef public Participant running
    cdef public long long given
    cdef object _names
    cdef long long _expected, _instant_ns
    cdef bint _begun
    cdef list _everybody
    cdef Participant _last
    cdef tuple _after

    cpdef Participant next(self, long long now_ns)

    @cython.locals(one=Participant, soonest="long long")
    cpdef long long until_ns(self)

    @cython.locals(one=Participant, k=Py_ssize_t, begin=Py_ssize_t, count=Py_ssize_t)
    cdef Participant _first_due(self, long long now_ns)

    @cython.locals(k=Py_ssize_t)
    cdef Py_ssize_t _begin(self) except -1
