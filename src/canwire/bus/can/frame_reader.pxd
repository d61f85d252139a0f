# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can.node cimport Node

cdef int _SOF, _BASE, _RTR, _IDE, _EXT, _RTR2, _FDF, _R0, _RES, _BRS, _ESI, _DLC, _DATA
cdef int _FD_CRC, _CRC, _CRC_DELIMITER
cdef int _TAKEN, _STUFF_ERROR, _FORM_ERROR, _PROTOCOL_EXCEPTION, _FAST_FROM_HERE
cdef int _NON_ISO, _CODES, _WORDS
cdef unsigned int _CRC15_POLY, _CRC17_POLY, _CRC21_POLY, _CRC17_START, _CRC21_START
cdef unsigned short *_LENGTHS

@cython.final
cdef class FrameReader:
    cdef readonly int fd_mode, field, left, same, last, stuff_count, dlc, length, crc_width, crc_position
    cdef readonly unsigned int value
    cdef readonly bint stuffing, extended, remote, fd, switch, esi, crc_ok, protocol_exception
    cdef readonly unsigned int crc15, crc17, crc21, identifier
    cdef object _block
    cdef unsigned long long *payload

    cdef int _take_memory(self) except -1
    cpdef int begin_for(self, Node node) noexcept
    cpdef int begin(self) noexcept
    cpdef bint expects_stuff_bit(self) noexcept
    cpdef int go_on(self, int field, int bits) noexcept
    @cython.locals(field=int, previous=int)
    cpdef int take(self, int level) noexcept
    @cython.locals(k=int)
    cdef int take_run(self, bytes levels, int first, int most) except -1
    @cython.locals(k=int)
    cdef int take_steady(self, int level, int most) noexcept
    cdef int _cover(self, unsigned int level) noexcept
    @cython.locals(at=int, byte="unsigned long long")
    cdef void _data_bit(self) noexcept
    cdef int _stuff_bit(self, int level) noexcept
    @cython.locals(field=int)
    cdef int _field_done(self, unsigned int value) noexcept
    cdef int _control_done(self, int field, unsigned int value) noexcept
    @cython.locals(length=int)
    cdef int _body_done(self, int field, unsigned int value) noexcept
    cdef int _end_crc(self, bint ok) noexcept
    cdef int _begin_crc(self) noexcept
    @cython.locals(received="unsigned int", code="unsigned int", counted=bint)
    cdef int _fd_crc_bit(self, int level, int previous) noexcept

@cython.locals(fed_back="unsigned int")
cdef unsigned int _shift(unsigned int register, unsigned int bit, int width, unsigned int poly) noexcept nogil
