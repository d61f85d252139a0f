# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Node

cdef int _SOF, _BASE, _RTR, _IDE, _EXT, _RTR2, _FDF, _R0, _RES, _BRS, _ESI, _DLC, _DATA
cdef int _FD_CRC, _CRC, _CRC_DELIMITER
cdef int _TAKEN, _STUFF_ERROR, _FORM_ERROR, _PROTOCOL_EXCEPTION, _FAST_FROM_HERE
cdef bytes _PARTS

@cython.final
cdef class FrameReader:
    cdef public int fd_mode, field, left, same, last, stuff_count, dlc, crc_width, crc_position
    cdef public object value
    cdef public bytes data
    cdef public bint stuffing, extended, remote, fd, switch, esi, crc_ok, protocol_exception
    cdef public unsigned int crc15, crc17, crc21, identifier

    cpdef int begin_for(self, Node node) except -1
    cpdef int begin(self) except -1
    @cython.locals(field=int, left=int)
    cpdef int part(self) except -1
    cpdef bint expects_stuff_bit(self) noexcept
    cpdef int go_on(self, int field, int bits) except -1
    @cython.locals(previous=int)
    cpdef int take(self, int level) except -1
    cdef int _cover(self, unsigned int level) noexcept
    cdef int _stuff_bit(self, int level) except -1
    @cython.locals(field=int)
    cdef int _field_done(self, object value) except -1
    cdef int _control_done(self, int field, object value) except -1
    cdef int _body_done(self, int field, object value) except -1
    cdef int _begin_crc(self) except -1
    cdef int _fd_crc_bit(self, int level, int previous) except -1

@cython.locals(fed_back="unsigned int")
cdef unsigned int _shift(unsigned int register, unsigned int bit, int width, unsigned int poly) noexcept nogil
