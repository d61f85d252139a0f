# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can cimport bits as can_bits
from canwire.bus.can.bit_layout cimport KeptLayout
from canwire.bus.can.frame_reader cimport FrameReader
from canwire.bus.can.node cimport Mailbox, Node
from canwire.bus.can cimport reader_state
from canwire.bus.can.tally cimport Tally

cdef int _IDLE, _FRAME, _ACTIVE_FLAG, _PASSIVE_FLAG, _FLAG_WAIT
cdef int _DELIMITER, _OVERLOAD_FLAG, _INTERMISSION, _SUSPEND, _WAITING
cdef int _BASE, _RTR, _IDE, _EXT, _RTR2, _CRC_DELIMITER, _ACK, _ACK_DELIMITER, _EOF
cdef int _TAKEN, _STUFF_ERROR, _FORM_ERROR, _PROTOCOL_EXCEPTION, _FAST_FROM_HERE
cdef int _STUFF, _FORM, _ACK_ERROR, _BIT, _FAST_DATA_BIT, _CRC_ERROR
cdef int _NO_RULE, _RECEIVED, _TRANSMIT_ERROR, _RECEIVE_ERROR, _DOMINANT_AFTER_FLAG
cdef int _FLAG_TRANSMITTER, _FLAG_RECEIVER, _LONG_TRANSMITTER, _LONG_RECEIVER
cdef int _QUIET, _RECEIVED_LAST, _SENT, _RECEIVING, _SENDING, _FAILED
cdef unsigned int _FD
cdef int _TO_DATA_RATE, _TO_NOMINAL_RATE, _FLAG_PART, _DELIMITER_PART, _OVERLOAD_PART

@cython.final
cdef class Station:
    cdef readonly Node node
    cdef readonly Tally tally
    cdef public unsigned long long now_ns, sof_ns
    cdef public int state, out, last_sample, rate_change, index, run, left, dominant_run, flag_level
    cdef readonly FrameReader reader
    cdef public bint fast, sof_seen, transmitting, finished, rejoined, overload, tec_due, just_free, flagged, counted, stored
    cdef readonly Mailbox box, sent
    cdef public Mailbox contending
    cdef readonly bytes levels
    cdef readonly KeptLayout layout
    cdef public bint acknowledging, acknowledged, second_ack

    cdef int _take_parts(self, Node node, Tally tally) except -1
    @cython.locals(node=Node)
    cpdef int begin(self) except -1
    cpdef int begin_bit(self) except -1
    @cython.locals(state=int)
    cpdef int sample(self, int level) except -1
    @cython.locals(node=Node, offer=Mailbox)
    cpdef bint ready_to_send(self) except -1
    cpdef bint transmits(self) noexcept
    cpdef int activity(self) except -1
    cpdef bint resting(self) except -1
    cpdef int wait_for_bus(self) except -1
    @cython.locals(box=Mailbox)
    cdef int offer(self) except -1
    cdef int _transmit(self, Mailbox box) except -1
    cdef int _begin_frame(self) except -1
    cdef int begin_receiving(self) except -1
    cdef void _idle_bit(self, int level) except *
    cdef int _intermission_bit(self, int level) except -1
    @cython.locals(node=Node)
    cdef void _waiting_bit(self, int level) except *
    cdef int deliver(self) except -1
    cdef int _hand_over(self) except -1
    @cython.locals(early=bint)
    cdef int bits_till_valid(self, int left) noexcept
    @cython.locals(stuff_bit=bint)
    cdef int _frame_bit(self, int level) except -1
    @cython.locals(reader=FrameReader, tail=bint, outcome=int)
    cdef int _take_bit(self, int level, bint stuff_bit) except -1
    cdef int _react(self, int outcome) except -1
    @cython.locals(field=int)
    cdef bint _tolerated(self, int level, bint stuff_bit) except -1
    cdef int _lose(self) except -1
    cdef int lose_silently(self) except -1
    cdef void _tail_bit(self, int level) except *
    cdef int _ack_bit(self, int level) except -1
    @cython.locals(node=Node)
    cdef int _count_reception(self) except -1
    cdef int _ack_delimiter_bit(self, int level) except -1
    cdef int _eof_bit(self, int level) except -1
    cdef int end_frame(self) noexcept
    @cython.locals(node=Node, passive=bint, rule=int)
    cdef int _error(self, int kind, int bit, bint exempt=*) except -1
    cdef int _begin_error_flag(self, bint passive) except -1
    cdef int _overload(self) except -1
    cdef int _begin_flag(self, int state) except -1
    cdef int _count(self, int rule) except -1
    cdef int _leave_if_off(self) except -1
    @cython.locals(passive=bint)
    cdef int _dominant_flag_bit(self, int level) except -1
    cdef int _passive_flag_bit(self, int level) except -1
    cdef void _after_flag_bit(self, int level) except *
    cdef int _delimiter_bit(self, int level) except -1
