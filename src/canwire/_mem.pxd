# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
from cpython.buffer cimport PyBUF_WRITABLE, PyBuffer_Release, PyObject_GetBuffer
from libc.string cimport memcmp, memcpy, memset

cdef extern from *:
    """
    #if defined(_MSC_VER)
    #include <intrin.h>
    static __inline unsigned long long cw_load(unsigned long long *p) {
        return (unsigned long long)_InterlockedOr64((volatile __int64 *)p, 0); }
    static __inline void cw_store(unsigned long long *p, unsigned long long v) {
        _InterlockedExchange64((volatile __int64 *)p, (__int64)v); }
    static __inline void cw_fence(void) { volatile long x = 0; _InterlockedExchange(&x, 1); }
    #else
    static inline unsigned long long cw_load(unsigned long long *p) {
        return __atomic_load_n(p, __ATOMIC_ACQUIRE); }
    static inline void cw_store(unsigned long long *p, unsigned long long v) {
        __atomic_store_n(p, v, __ATOMIC_RELEASE); }
    static inline void cw_fence(void) { __atomic_thread_fence(__ATOMIC_SEQ_CST); }
    #endif
    """
    unsigned long long cw_load(unsigned long long *p) noexcept nogil
    void cw_store(unsigned long long *p, unsigned long long v) noexcept nogil
    void cw_fence() noexcept nogil

cdef extern from "Python.h":
    long long PyLong_AsLongLongAndOverflow(object number, int *overflow) except? -1


# A typed memoryview would do the same, at the price of 20,000 lines of C in each extension.
cdef inline void *bytes_of(object buffer) except NULL:
    cdef Py_buffer view
    PyObject_GetBuffer(buffer, &view, PyBUF_WRITABLE)
    PyBuffer_Release(&view)
    return view.buf


cdef inline unsigned long long *words_of(object buffer) except NULL:
    return <unsigned long long *> bytes_of(buffer)


cdef inline void copy_record(unsigned long long *target, Py_ssize_t at,
                             unsigned long long *source, Py_ssize_t source_at) noexcept nogil:
    memcpy(target + at, source + source_at, 80)


cdef inline bytes data_of(unsigned long long *words, Py_ssize_t at, Py_ssize_t length):
    return (<char *> (words + at))[:length]


cdef inline bint same_data(unsigned long long *words, Py_ssize_t at, bytes data) noexcept:
    return memcmp(words + at, <char *> data, len(data)) == 0


cdef inline void store_data(unsigned long long *words, Py_ssize_t at, bytes data) noexcept:
    memset(words + at, 0, 64)
    memcpy(words + at, <char *> data, len(data))


cdef inline void clear_tail(unsigned long long *words, Py_ssize_t at, Py_ssize_t length) noexcept nogil:
    memset(<char *> (words + at) + length, 0, 64 - length)


cdef inline unsigned long long load_acquire(unsigned long long *words, Py_ssize_t at) noexcept nogil:
    if words == NULL:  # of a thing that was never initialised
        return 0
    return cw_load(words + at)


cdef inline void store_release(unsigned long long *words, Py_ssize_t at, unsigned long long value) noexcept nogil:
    if words != NULL:
        cw_store(words + at, value)


cdef inline void fence() noexcept nogil:
    cw_fence()


cdef inline long long whole(object number) except? -1:
    cdef int overflow = 0
    if not isinstance(number, int):
        return -1
    cdef long long value = PyLong_AsLongLongAndOverflow(number, &overflow)
    return -1 if overflow or value < 0 else value


cdef inline unsigned short *shorts_of(object buffer) except NULL:
    return <unsigned short *> bytes_of(buffer)
