# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can cimport bits as can_bits
from canwire.bus.can.bit_level cimport BitLevel
from canwire.bus.can.bus_state cimport BusState
from canwire.bus.can.node cimport Mailbox, Node
from canwire.bus.can.stepped cimport SteppedFrame
from canwire.timeline cimport Timeline

cdef unsigned long long _NEVER
cdef const unsigned long long _NOBODY
cdef const int _ACK_ERROR, _ACK_SLOT
cdef int _NO_RULE, _TRANSMIT_ERROR, _REST, _SENDING, _BITWISE, _ERRING
cdef const unsigned int _FD
cdef const long long _INTERMISSION, _EOF_END_TO_ACK, _ACK_DELIMITER_TO_EOF_END, _ERROR_FRAME, _ACK_SLOT_TO_FREE

@cython.final
cdef class CanBus(BusState):
    cdef public object name
    cdef public unsigned long long collisions
    cdef public long long delay_ps
    cdef public bint bitwise
    cdef public long long noise_left
    cdef public object scripted
    cdef int _acknowledgers, _listeners
    cdef unsigned long long _next_ns
    cdef long long _noise_taken, _early_ps
    cdef int _slot
    cdef bint _acknowledged, _in_step, _in_step_fd, _in_step_switching, _waiting, _sleeping, _flag_passive
    cdef list _members, _stations

    @cython.locals(free="unsigned long long", soonest="unsigned long long", ready="unsigned long long", node=Node, box=Mailbox)
    cdef unsigned long long _next_start(self) except? 0

    @cython.locals(sender=Node, lowest="unsigned long long", rivals=int, collision=bint, keen=bint, tainted=bint, joins=bint,
                   node=Node, box=Mailbox, key="unsigned long long")
    cdef inline bint _start(self, unsigned long long start_ns, unsigned long long limit_ns) except -1

    @cython.locals(box=Mailbox, bits="long long", alone=bint)
    cdef inline bint _skippable(self) except -1

    @cython.locals(node=Node, box=Mailbox, bits="long long", length_ps="long long")
    cdef inline int _time_frame(self) except -1

    @cython.locals(sender=Node, box=Mailbox, end_ns="unsigned long long", bit_ps="long long", free_ps="long long", node=Node)
    cdef inline int _succeed(self) except -1

    @cython.locals(free="unsigned long long", now="unsigned long long")
    cdef inline bint _go_on(self, unsigned long long limit_ns) except -1

    @cython.locals(inside=SteppedFrame, soonest="unsigned long long")
    cdef int _happen(self) except -1

    @cython.locals(sender=Node, node=Node)
    cdef inline int _count_losers(self) except -1

    @cython.locals(rule=int, extra=int)
    cdef int _fail_unacknowledged(self, Node sender, Mailbox box) except -1

    @cython.locals(sender=Node)
    cdef int _end_error_frame(self) except -1

    cdef int _replay(self) except -1

    cdef int _rest_if_over(self) except -1

    @cython.locals(bits=BitLevel, timeline=Timeline, at_ns="unsigned long long", at_ps="long long")
    cdef bint _run_bits(self, unsigned long long limit_ns) except -1

    cdef int _enter_bitwise(self) except -1

    @cython.locals(bits=BitLevel)
    cdef int _leave_bitwise(self) except -1

    cdef bint _anything_left(self) except -1

    @cython.locals(sender=Node, bit_ps="long long", now_ns="unsigned long long")
    cdef void _leave_rest(self) except *

    @cython.locals(origin_ps="long long")
    cdef int _enter_at(self, long long at_ps) except -1
