# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can cimport bits as can_bits
from canwire.bus.can.bit_level cimport BitLevel
from canwire.bus.can.joining cimport Joining
from canwire.bus.can.node cimport Bus, Mailbox, Node
from canwire.bus.can.station cimport Tally
from canwire.bus.load cimport BusLoad
from canwire.timeline cimport Timeline

cdef unsigned long long _NEVER, _TOP_BIT, _NOBODY
cdef int _ACK_ERROR, _NO_RULE, _RECEIVED, _TRANSMIT_ERROR, _REST, _SENDING, _BITWISE
cdef unsigned int _FD
cdef long long _INTERMISSION, _EOF_END_TO_ACK, _ACK_DELIMITER_TO_EOF_END, _ERROR_FRAME
cdef int _ACK_SLOT

cdef class CanBus(Bus):
    cdef public object name
    cdef public list nodes
    cdef public BusLoad load
    cdef public unsigned long long collisions
    cdef public long long delay_ps
    cdef public bint bitwise
    cdef public long long noise_left
    cdef public object scripted
    cdef public BitLevel bits
    cdef public Tally tally
    cdef int _state, _acknowledgers, _listeners, _rivals
    cdef unsigned long long _free_ns, _start_ns, _busy_since_ns, _busy_from_ns, _pause_ns, _end_ns
    cdef long long _free_ps, _end_ps, _noise_taken
    cdef bint _acknowledged, _alike, _alike_fd, _waiting, _sleeping
    cdef Joining _joining
    cdef Node _sender, _nobody
    cdef Mailbox _box
    cdef list _members
    cdef Node _first

    @cython.locals(busy_ns="long long", ahead_ns="long long")
    cpdef long long busy_ns(self) noexcept

    @cython.locals(start="unsigned long long", joining="unsigned long long")
    cpdef unsigned long long next_ns(self) except? 0

    @cython.locals(timeline=Timeline, start="unsigned long long", joining="unsigned long long")
    cpdef run(self, unsigned long long limit_ns)

    @cython.final
    @cython.locals(free="unsigned long long", soonest="unsigned long long", ready="unsigned long long", node=Node, box=Mailbox)
    cdef unsigned long long _next_start(self) except? 0

    @cython.final
    @cython.locals(sender=Node, lowest="unsigned long long", rivals=int, collision=bint, node=Node, box=Mailbox,
                   key="unsigned long long")
    cdef bint _start(self, unsigned long long start_ns) except -1

    @cython.final
    @cython.locals(box=Mailbox, bits="long long")
    cdef bint _skippable(self) except -1

    @cython.final
    @cython.locals(node=Node, box=Mailbox, bits="long long", length_ps="long long")
    cdef int _time_frame(self) except -1

    @cython.final
    @cython.locals(sender=Node, box=Mailbox)
    cdef int _complete(self) except -1

    @cython.final
    @cython.locals(end_ns="unsigned long long", bit_ps="long long", free_ps="long long", node=Node)
    cdef int _succeed(self, Node sender, Mailbox box) except -1

    @cython.final
    @cython.locals(free="unsigned long long", now="unsigned long long")
    cdef bint _go_on(self, unsigned long long limit_ns) except -1

    @cython.final
    @cython.locals(node=Node, box=Mailbox)
    cdef int _tell_losers(self) except -1

    @cython.final
    @cython.locals(differing="unsigned long long", bit=int)
    cdef int _differing_bit(self, unsigned long long key) except -1

    @cython.locals(sampled_ps="long long")
    cdef int _count_reception(self, Node node, long long bit_ps) except -1

    @cython.final
    @cython.locals(bit_ps="long long", sampled_ps="long long", rule=int, extra=int)
    cdef int _fail_unacknowledged(self, Node sender, Mailbox box) except -1

    @cython.final
    cdef void _begin_at(self, unsigned long long start_ns) noexcept
