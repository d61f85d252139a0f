# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem

cdef const int _ASKED, _UNTIL, _STIRS, _GIVEN, _NOW, _CALLS
cdef long long _M63

cdef class TurnPage:
    cdef object _memory
    cdef unsigned long long *_words
    cdef public unsigned long long seen
    cdef unsigned long long _stirs_seen, _calls_seen

    @cython.locals(asked="unsigned long long")
    cpdef unsigned long long ask(self, unsigned long long until_ns)
    cpdef bint given(self, unsigned long long asked)
    cpdef unsigned long long now_ns(self)
    cpdef stir(self)
    cpdef call(self)
    @cython.locals(asked="unsigned long long", new=bint)
    cpdef bint asked(self)
    cpdef long long until_ns(self)
    @cython.locals(stirs="unsigned long long", new=bint)
    cpdef bint stirred(self)
    @cython.locals(calls="unsigned long long", new=bint)
    cpdef bint called(self)
    cpdef give(self, unsigned long long now_ns)
