# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem

cdef unsigned int _EXTENDED, _REMOTE
cdef int _BASIC, _SINGLE
cdef unsigned int _SINGLE_STANDARD, _SINGLE_EXTENDED, _FIRST_STANDARD, _FIRST_EXTENDED, _ONE_BYTE, _NO_BYTE

@cython.final
cdef class AcceptanceFilter:
    cdef public int mode
    cdef public unsigned int code, care

    @cython.locals(head="unsigned long long", info="unsigned int", identifier="unsigned int", remote="unsigned int",
                   key="unsigned int", half="unsigned int", first="unsigned int", length="unsigned int")
    cdef bint accepts(self, unsigned long long *words) noexcept
    @cython.locals(byte="unsigned int", care="unsigned int", key="unsigned int")
    cdef bint _standard(self, unsigned int identifier, unsigned int remote, unsigned int length,
                        unsigned int data) noexcept
