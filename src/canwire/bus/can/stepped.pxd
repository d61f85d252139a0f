# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Mailbox, Node

cdef unsigned long long _NEVER, _TOP_BIT
cdef int _QUIET, _RECEIVED_LAST, _SENT, _RECEIVING, _SENDING, _FAILED, _RECEIVED
cdef long long _ACK_SLOT_TO_EOF_END, _INTERMISSION

@cython.final
cdef class SteppedFrame:
    cdef public unsigned long long start_ns
    cdef public long long lead_ps, end_ps
    cdef readonly Node sender
    cdef public Node first
    cdef readonly Mailbox box
    cdef public bint over

    cdef int take(self, unsigned long long start_ns, long long lead_ps, long long end_ps, Node sender, Mailbox box) except -1
    @cython.locals(soonest="unsigned long long", node=Node, box=Mailbox)
    cdef unsigned long long next_ns(self, unsigned long long end_ns, bint acknowledged) except? 0
    @cython.locals(soonest="unsigned long long", due="unsigned long long", sender=Node, node=Node, box=Mailbox)
    cdef unsigned long long happen(self, unsigned long long now_ns, unsigned long long end_ns, bint acknowledged) except? 0
    @cython.locals(box=Mailbox)
    cdef void catch_up(self, Node node, unsigned long long now_ns) except *
    @cython.locals(joined=bint)
    cdef int activity(self, Node node, unsigned long long now_ns) except -1
    @cython.locals(box=Mailbox)
    cdef bint transmits(self, Node node, unsigned long long now_ns) except -1
    @cython.locals(node=Node)
    cdef bint fails(self, unsigned long long now_ns) except -1
    cdef int activity_behind(self, Node node, unsigned long long now_ns) except -1
    cdef unsigned long long _at_ns(self, long long at_ps) noexcept
    cdef int _lose(self, Node node, Mailbox box) except -1
    @cython.locals(at_bit="long long")
    cdef unsigned long long _loses_ns(self, Node node, Mailbox box) except? 0
    cdef bint _is_to_count(self, Node node) except -1
    cdef bint _is_to_store(self, Node node) noexcept
    cdef unsigned long long _valid_ns(self, Node node) except? 0
    cdef unsigned long long _acknowledges_ns(self, Node node) except? 0

@cython.locals(differing="unsigned long long", bit=int)
cpdef int losing_bit(unsigned long long key, unsigned long long winner) except -1

@cython.locals(at=int, run=int, last=int, k=int, level=int)
cpdef int wire_bit(unsigned long long key, int bit) except -1
