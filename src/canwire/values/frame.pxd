# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem

cdef const unsigned int _EXTENDED, _REMOTE, _SELF_RECEPTION, _FD, _BIT_RATE_SWITCH, _ERROR_STATE
cdef unsigned int _IDENTITY
cdef const int _DLC_SHIFT, _LAST_KEPT
cdef list _KEPT
cdef tuple _DLC_OF_LENGTH

@cython.final
cdef class Frame:
    cdef unsigned int _id, _info
    cdef bytes _data
    cdef unsigned long long _timestamp_ns

@cython.locals(length=int, expected=int)
cdef int _checked_dlc(bytes data, bint remote, bint fd, object dlc) except -1

@cython.locals(info="unsigned int")
cdef unsigned int _flags(bint extended, bint remote, bint fd, bint switch, bint error_state, bint own) noexcept

@cython.locals(kept=Frame, frame=Frame, place=Py_ssize_t)
cdef Frame frame_at(unsigned long long *words, Py_ssize_t at)

@cython.locals(head="unsigned long long")
cdef bint _is_at(Frame frame, unsigned long long *words, Py_ssize_t at) noexcept

@cython.locals(frame=Frame, head="unsigned long long", info="unsigned int", dlc=int, length=int)
cdef Frame _made(unsigned long long *words, Py_ssize_t at)

@cython.locals(info="unsigned long long")
cdef void store_frame(Frame frame, unsigned long long *words, Py_ssize_t at, unsigned int flags,
                      unsigned long long time_ns) noexcept

cdef bint _same(Frame one, Frame other) except -1

@cython.locals(frame=Frame)
cpdef Frame _restore(unsigned int id, unsigned int info, bytes data, unsigned long long timestamp_ns)

cpdef Frame frame_of_record(object record)

cpdef bytes record_of_frame(Frame frame)
