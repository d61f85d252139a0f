cimport cython


@cython.final
cdef class Hold:
    cdef object _lock, _asked, _entered, _leaving
