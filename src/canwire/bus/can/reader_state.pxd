# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can.bit_layout cimport KeptLayout
from canwire.bus.can.frame_reader cimport FrameReader

cdef int _BASE, _EXT, _FDF, _DATA, _CRC_DELIMITER, _EOF, _ACK_SLOT, _EOF_FROM, _EOF_BITS, _WORDS, _DLC_SHIFT
cdef bytes _PARTS
cdef unsigned int _IDENTIFIER, _EXTENDED, _REMOTE, _FD, _SWITCH, _ESI

@cython.locals(head="unsigned long long", k=int, used=int)
cdef int store(FrameReader reader, unsigned long long *words) noexcept

@cython.locals(words="unsigned long long *", head="unsigned long long", one="unsigned long long", whole=int, rest=int, k=int)
cdef int finish(FrameReader reader, KeptLayout layout) noexcept

cdef int pass_tail(FrameReader reader, int bits) noexcept

@cython.locals(same=bint)
cpdef bint alike(FrameReader one, FrameReader other, bint classic) noexcept

@cython.locals(same=bint, k=int)
cdef bint _have_read_the_same(FrameReader one, FrameReader other) noexcept

cdef int _whole_bytes(FrameReader reader) noexcept

@cython.locals(k=int)
cpdef int copy(FrameReader target, FrameReader source) noexcept

cdef int double(FrameReader target, FrameReader source) noexcept

@cython.locals(field=int, left=int)
cdef int part(FrameReader reader) except -1
