# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython

cdef long long _BUCKET_NS, _LONG_NS

@cython.final
cdef class BusLoad:
    cdef public long long busy_ns
    cdef long long _bucket_end_ns, _bucket_ns, _fullest_ns
    cdef list _past

    cpdef int add(self, long long start_ns, long long end_ns) except -1
    cdef int _roll(self, long long start_ns, long long end_ns) except -1
    cpdef int _advance(self, long long now_ns) except -1
