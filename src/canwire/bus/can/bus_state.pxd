# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.bit_level cimport BitLevel
from canwire.bus.can.joining cimport Joining
from canwire.bus.can.node cimport Bus, Mailbox, Node
from canwire.bus.can.stepped cimport SteppedFrame
from canwire.bus.can.tally cimport Tally
from canwire.bus.load cimport BusLoad

cdef int _REST, _SENDING, _BITWISE, _ERRING, _FAILED, _QUIET
cdef long long _INTERMISSION

cdef class BusState(Bus):
    cdef public list nodes
    cdef public BusLoad load
    cdef public BitLevel bits
    cdef public Tally tally
    cdef int _state, _rivals
    cdef unsigned long long _free_ns, _start_ns, _busy_since_ns, _busy_from_ns, _pause_ns, _end_ns
    cdef long long _free_ps, _end_ps
    cdef SteppedFrame _inside
    cdef Joining _joining
    cdef Node _nobody, _sender, _first
    cdef Mailbox _box

    @cython.locals(busy_ns="long long", counted_ns="long long", ahead_ns="long long")
    cpdef long long busy_ns(self) noexcept

    @cython.final
    cdef SteppedFrame _look_inside(self)

    @cython.locals(now_ns="unsigned long long", inside=SteppedFrame)
    cpdef int activity(self, Node node) except -1

    @cython.final
    @cython.locals(node=Node)
    cdef void _contend(self) noexcept

    @cython.final
    cdef void _begin_late(self, unsigned long long start_ns) noexcept

    @cython.final
    @cython.locals(node=Node)
    cdef int _forget_contenders(self) except -1
