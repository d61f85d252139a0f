# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can.frame_reader cimport FrameReader

cdef int _DATA, _WORDS, _DLC_SHIFT
cdef unsigned int _EXTENDED, _REMOTE, _FD, _SWITCH, _ESI

@cython.locals(head="unsigned long long", k=int, used=int)
cdef int store(FrameReader reader, unsigned long long *words) noexcept

@cython.locals(same=bint)
cpdef bint alike(FrameReader one, FrameReader other, bint classic) noexcept

@cython.locals(same=bint, k=int)
cdef bint _have_read_the_same(FrameReader one, FrameReader other) noexcept

cdef int _whole_bytes(FrameReader reader) noexcept

@cython.locals(k=int)
cpdef int copy(FrameReader target, FrameReader source) noexcept

cdef int double(FrameReader target, FrameReader source) noexcept
