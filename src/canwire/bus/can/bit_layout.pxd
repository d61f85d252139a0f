# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython

@cython.final
cdef class BitLayout:
    cdef readonly bytearray levels, fields, stuffed
    cdef readonly int stuff_bits, data_bits
    cdef readonly unsigned int crc
    cdef int _run, _last
    cdef list _plain, _wired

    @cython.locals(k=int, level=int)
    cdef int _put(self, field, unsigned int value, int width) except -1
    @cython.locals(level=int)
    cdef int _stuff(self, field) except -1
    cdef int _append(self, field, int level, int stuffed) except -1
