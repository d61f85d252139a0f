# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.values cimport frame as codec
from canwire.values.frame cimport Frame

cdef unsigned long long _M64
cdef const int _CAPACITY, _RECORD_BYTES, _LIMIT, _HEAD, _LOST, _TAIL, _WANTED, _FREE_WANTED, _RECORDS, _WORDS
cdef const unsigned long long _LARGEST_CAPACITY
cdef int _RECORD_SIZE

@cython.final
cdef class Ring:
    cdef readonly long long capacity, record_size
    cdef long long _mask
    cdef object _buffer
    cdef unsigned long long *_words
    cdef unsigned long long _seen_head, _seen_tail, _start
    cdef bint _shared
    cdef public object event, free_event, listener, free_listener
    cdef public long long threshold, free_threshold

    @cython.locals(count="unsigned long long")
    cpdef long long fill(self) noexcept

    @cython.locals(count="unsigned long long")
    cpdef long long free(self) noexcept

    @cython.locals(words="unsigned long long *", head="unsigned long long", fill="unsigned long long", slot=Py_ssize_t)
    cdef bint put(self, unsigned long long *source, Py_ssize_t at, unsigned long long time_ns,
                  unsigned long long head_word) except -1

    @cython.locals(source="unsigned long long *")
    cpdef bint put_bytes(self, record) except -1

    @cython.locals(source="unsigned long long *", word="unsigned long long")
    cpdef bint put_at(self, bytearray record, unsigned long long time_ns, unsigned long long last) except -1

    @cython.locals(words="unsigned long long *", tail="unsigned long long",
                   count="unsigned long long")
    cpdef Py_ssize_t front(self) noexcept

    @cython.locals(words="unsigned long long *", tail="unsigned long long", free="long long")
    cpdef int release(self, long long count) except -1

    @cython.locals(at=Py_ssize_t, frame=Frame)
    cpdef Frame take_frame(self)

    @cython.locals(first="unsigned long long", count="long long", k="long long")
    cpdef list take_frames(self, long long limit)

    @cython.locals(head="unsigned long long")
    cdef long long _next_slot(self, long long free) noexcept

    @cython.locals(waiting="unsigned long long", missing="long long")
    cpdef int arm(self) except -1

    cpdef int arm_once(self) except -1

    @cython.locals(waiting="unsigned long long", missing="long long")
    cpdef int arm_free(self) except -1

    @cython.locals(goal="unsigned long long")
    cdef int _arm(self, int wanted, int counter, unsigned long long seen, long long missing) except -1

    cdef int _told(self, unsigned long long head, long long before, long long count) except -1

    cdef int _signal(self, int wanted) except -1

    @cython.locals(wanted="unsigned long long")
    cdef int _wake_consumer(self, unsigned long long head) except -1

    @cython.locals(wanted="unsigned long long")
    cdef int _wake_producer(self, unsigned long long tail) except -1
