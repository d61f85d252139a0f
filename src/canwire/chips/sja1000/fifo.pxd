# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem

cdef int _BASE, _SIZE
cdef unsigned int _EXTENDED, _REMOTE

@cython.final
cdef class ReceiveFifo:
    cdef public int start, count, used
    cdef bytearray _cells, _sizes
    cdef int _first, _lead, _size
    cdef unsigned long long _first_bytes, _data

    @cython.locals(head="unsigned long long", info="unsigned int", identifier="unsigned int", dlc="unsigned int",
                   remote="unsigned int", first="unsigned long long", rest="unsigned long long")
    cdef int compose(self, unsigned long long *words, bint pelican) except -1
    @cython.locals(size=int)
    cdef bint store(self) except -1
    @cython.locals(free=int)
    cdef int show(self) except -1
    @cython.locals(size=int)
    cdef int release(self) except -1
    cdef int clear(self, int start) except -1
    @cython.locals(cells="unsigned char *", base=int, lead=int, at=int, k=int, bytes_left="unsigned long long")
    cdef int _write(self, int size) except -1
