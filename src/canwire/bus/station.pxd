# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.node cimport Mailbox, Node
from canwire.values cimport frame as codec
from canwire.values.frame cimport Frame

cdef int _IDLE, _FRAME, _ACTIVE_FLAG, _PASSIVE_FLAG, _FLAG_WAIT
cdef int _DELIMITER, _OVERLOAD_FLAG, _INTERMISSION, _SUSPEND, _WAITING
cdef int _SOF, _BASE, _RTR, _IDE, _EXT, _RTR2, _FDF, _R0, _RES, _BRS, _ESI, _DLC, _DATA
cdef int _FD_CRC, _CRC, _CRC_DELIMITER, _ACK, _ACK_DELIMITER, _EOF
cdef int _STUFF, _FORM, _ACK_ERROR, _BIT, _FAST_DATA_BIT, _CRC_ERROR
cdef int _TO_DATA_RATE, _TO_NOMINAL_RATE

cdef class Tap:
    cpdef void transmitted(self, Node node, Mailbox box, unsigned long long at_ns) except *

cdef class Tally:
    cdef public unsigned long long frames, error_frames, last_success_ns
    cdef public int erring
    cdef public Tap tap

cdef class Station:
    cdef public Node node
    cdef public Tally tally
    cdef public unsigned long long now_ns, sof_ns
    cdef public int state, out, last_sample, rate_change, index, run, left, dominant_run, field, left_in_field
    cdef public bint erring, fast, sof_seen, transmitting, finished, rejoined, overload, tec_due
    cdef public Mailbox box, sent, contending
    cdef public bytes levels
    cdef public object value
    cdef public int same, last, stuff_count, dlc, crc_width, crc_position
    cdef public bint stuffing, extended, remote, fd, switch, esi, crc_ok, acknowledging, acknowledged, second_ack
    cdef public unsigned int crc15, crc17, crc21, identifier
    cdef public object data

    cpdef void begin_bit(self) except *
    @cython.locals(state=int)
    cpdef void sample(self, int level) except *
    @cython.locals(node=Node, offer=Mailbox)
    cpdef bint ready_to_send(self) except -1
    cpdef bint resting(self) except -1
    cpdef void wait_for_bus(self) except *
    @cython.locals(node=Node, box=Mailbox)
    cdef void _offer(self) except *
    cdef void _transmit(self, Mailbox box) except *
    cdef void _begin_parse(self) except *
    cdef void _start_receiving(self) except *
    cdef void _idle_bit(self, int level) except *
    cdef void _intermission_bit(self, int level) except *
    @cython.locals(node=Node)
    cdef void _waiting_bit(self, int level) except *
    cdef void _deliver(self) except *
    @cython.locals(stuff_bit=bint, previous=int)
    cdef void _frame_bit(self, int level) except *
    cdef void _cover(self, unsigned int level) noexcept
    cdef void _stuff_bit(self, int level) except *
    @cython.locals(field=int)
    cdef bint _tolerated(self, int level, bint stuff_bit) except -1
    cdef void _lose(self) except *
    cdef void _next(self, int field, int bits) except *
    cdef void _field_done(self, object value) except *
    cdef void _control_done(self, int field, object value) except *
    cdef void _body_done(self, int field, object value) except *
    cdef void _begin_crc(self) except *
    cdef void _fd_crc_bit(self, int level, int previous) except *
    cdef void _tail_bit(self, int level) except *
    cdef void _ack_bit(self, int level) except *
    cdef void _ack_delimiter_bit(self, int level) except *
    cdef void _eof_bit(self, int level) except *
    @cython.locals(node=Node, passive=bint, rule=int)
    cdef void _error(self, int kind, int bit, bint exempt=*) except *
    cdef void _overload(self) except *
    cdef void _count(self, int rule) except *
    cdef void _leave_if_off(self) except *
    cdef void _flag_bit(self, int level) except *
    cdef void _passive_flag_bit(self, int level) except *
    cdef void _after_flag_bit(self, int level) except *
    cdef void _delimiter_bit(self, int level) except *
    cdef void _recovered(self) noexcept

@cython.locals(fed_back="unsigned int")
cdef unsigned int _shift(unsigned int register, unsigned int bit, int width, unsigned int poly) noexcept nogil
