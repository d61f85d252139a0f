# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython

cdef long long _BUCKET_NS

cdef class BusLoad:
    cdef public long long busy_ns
    cdef long long _bucket_end_ns, _bucket_ns, _fullest_ns
    cdef list _past

    cpdef void add(self, long long start_ns, long long end_ns) except *
    cdef void _roll(self, long long start_ns, long long end_ns) except *
    cpdef void _advance(self, long long now_ns) except *
