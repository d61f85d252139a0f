# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can.node cimport Mailbox
from canwire.values cimport frame as codec

cdef int _SOF, _ID, _RTR, _IDE, _EXT, _RTR2, _FDF, _R0, _RES, _BRS, _ESI, _DLC, _DATA
cdef int _STUFF_COUNT, _CRC, _CRC_DEL, _ACK, _ACK_DEL, _EOF, _EOF_BITS, _TAIL_BITS, _RECORD_WORDS, _MOST_BITS

@cython.final
cdef class BitLayout:
    cdef readonly bytearray levels, fields, stuffed
    cdef readonly int stuff_bits, data_bits
    cdef readonly unsigned int crc
    cdef int _run, _last, _width, _length
    cdef unsigned int _poly
    cdef bint _wide, _covering

    cdef int _choose_crc(self, frame, bint non_iso) except -1
    @cython.locals(id="unsigned int", remote=int)
    cdef int _header(self, frame, bint error_passive) except -1
    @cython.locals(data=bytes, k=int)
    cdef int _data(self, frame) except -1
    cdef int _classic_crc(self) except -1
    cdef int _fd_crc(self, bint non_iso) except -1
    @cython.locals(k=int, level=int)
    cdef int _put_fixed(self, int field, unsigned int value, int width, int before) except -1
    cdef int _tail(self) except -1
    @cython.locals(k=int, level=int)
    cdef int _put(self, int field, unsigned int value, int width) except -1
    @cython.locals(level=int)
    cdef int _stuff(self, int field) except -1
    cdef int _cover(self, unsigned int level) noexcept
    cdef int _append(self, int field, int level, int stuffed) except -1

@cython.final
cdef class KeptLayout:
    cdef readonly bytes levels, heard
    cdef readonly int fast_bit, tail_bit, stuff_bits, length
    cdef readonly bint classic
    cdef readonly Mailbox box
    cdef int _fd_mode

    @cython.locals(layout=BitLayout)
    cdef int take(self, Mailbox box, int fd_mode) except -1
    @cython.locals(k=int, ours="unsigned long long *", theirs="unsigned long long *")
    cdef bint _holds(self, Mailbox box) noexcept

@cython.locals(fed_back="unsigned int")
cdef unsigned int _shifted(unsigned int register, unsigned int bit, int width, unsigned int poly) noexcept nogil
