# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem

cdef int _BY_PATTERN, _BY_LIST, _NOT_EXCLUDED, _ALWAYS, _LOCK, _PASS, _INCLUSIVE, _EXCLUSIVE, _STANDARD_BITS
cdef unsigned int _REMOTE, _EXTENDED

@cython.final
cdef class FormatFilter:
    cdef public int mode, width
    cdef public long long size
    cdef public unsigned long long code, mask
    cdef public set listed
    cdef object _block
    cdef unsigned long long *_bits

    @cython.locals(matched=int)
    cpdef int judge(self, unsigned long long value) except -1

    cdef bint _is_listed(self, unsigned long long value) except -1

@cython.final
cdef class MessageFilter:
    cdef readonly FormatFilter standard, extended

    @cython.locals(info="unsigned int", value="unsigned long long")
    cpdef int judge(self, unsigned long long head) except -1
