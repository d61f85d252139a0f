# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.clock cimport Clock
from canwire.bus.can.coasting cimport Stretch
from canwire.bus.can.drifting cimport Apart
from canwire.bus.can.node cimport Node
from canwire.bus.can.station cimport Station
from canwire.bus.can.tally cimport Tally
from canwire.bus.can.stimulus cimport Stimulus

cdef int _FRAME, _QUIET, _IDLE, _SUSPEND, _WAITING, _FREE
cdef long long _NEVER, _MOST
cdef unsigned long long _FAR_NS

@cython.final
cdef class BitLevel:
    cdef readonly Tally tally
    cdef readonly list clocks
    cdef list _known
    cdef public unsigned long long origin_ns
    cdef public long long origin_ps, now_ps, delay_ps
    cdef public bint shorted, undisturbed, pinned, coasts, aligned, halfway
    cdef Stretch _stretch
    cdef Apart _apart
    cdef bint _stepping, _forcing, _drifts, _driven
    cdef public object capture, capture_many, disturb, spare, watch
    cdef readonly list stimuli
    cdef long long _change_ps, _asked_ps, _fell_ps
    cdef public Node victim, sender_seen
    cdef public int index_seen
    cdef int _wire, _shown, _flip, _forced
    cdef Clock _flip_sender, _latest

    cdef int _take_parts(self) except -1
    @cython.locals(clock=Clock)
    cpdef int stimulate(self, Stimulus stimulus, long long at_ps) except -1
    cpdef long long offset_ps(self) noexcept
    cpdef unsigned long long at_ns(self, long long at_ps) noexcept
    @cython.locals(soonest="long long", clock=Clock)
    cpdef long long next_ps(self) noexcept
    @cython.locals(clock=Clock)
    cpdef int activity(self, Node node) except -1
    @cython.locals(clock=Clock)
    cpdef int enter(self, list nodes, unsigned long long origin_ns, long long origin_ps) except -1
    cpdef void add(self, Node node, long long at_ps) except *
    @cython.locals(first=Clock, node=Node, station=Station)
    cdef int _take_in(self, Clock clock, long long at_ps) except -1
    @cython.locals(clock=Clock)
    cpdef int leave(self) except -1
    @cython.locals(first=Clock, clock=Clock, most=int, bits=int, sample_ps="long long", latest_ps="long long")
    cpdef bint coast(self, unsigned long long limit_ns) except -1
    @cython.locals(apart=Apart, bits=int)
    cdef bint _coast_apart(self, unsigned long long limit_ns) except -1
    @cython.locals(left_ns="long long")
    cdef long long _end_ps(self, unsigned long long limit_ns) noexcept
    @cython.locals(left_ps="long long", bits="long long")
    cdef int _bits_until(self, unsigned long long limit_ns, Clock clock) except -1
    @cython.locals(sender=Clock)
    cdef int _calm(self, Stretch stretch, int bits) except -1
    @cython.locals(bit_ps="long long", began_ps="long long", last_ps="long long", fall=int, at_ps="long long")
    cdef int _pass(self, Stretch stretch, Clock first, int bits) except -1
    cdef int _show(self, int wire, int shown, long long at_ps) except -1
    @cython.locals(at_ps="long long")
    cpdef int replay(self, unsigned long long now_ns) except -1
    cpdef int step_at(self, long long at_ps) except -1
    @cython.locals(clock=Clock, at_ns="unsigned long long")
    cdef bint _deliver(self, long long at_ps) except -1
    @cython.locals(at_ns="unsigned long long", begun=bint, sent=bint, shown_otherwise=bint, clock=Clock)
    cdef int _step(self, long long at_ps) except -1
    @cython.locals(clock=Clock)
    cdef int _begin_bits(self, long long at_ps) except -1
    @cython.locals(station=Station, idle=bint, out=int)
    cdef int _begin_bit(self, Clock clock, long long at_ps) except -1
    cdef bint _dominant_before(self, Clock clock, long long at_ps) except -1
    @cython.locals(common="long long", due="long long", clock=Clock)
    cpdef bint resting(self) except -1
    @cython.locals(wire=int, shown=int, falls=bint, clock=Clock)
    cdef int _settle(self, long long at_ps) except -1
    @cython.locals(falls=Clock, clock=Clock, fallen=int, sees=bint, arrives="long long")
    cdef int _send_edges(self, long long at_ps) except -1
    @cython.locals(absolute_ps="long long", soonest="long long", clock=Clock, stimulus=Stimulus)
    cdef int _force(self, long long at_ps) except -1
    @cython.locals(clock=Clock, arrives=bint, fell=bint, level=int)
    cdef int _look_for_edges(self, long long at_ps) except -1
    @cython.locals(level=int, flipped=bint)
    cdef int _seen_by(self, Clock clock, long long at_ps) except -1
    @cython.locals(level=int, other=Clock)
    cdef int _undisturbed_level(self, Clock clock, long long at_ps) except -1
    cdef bint _flipped_for(self, Clock clock) except -1
    @cython.locals(sender=Clock, driver=Clock, index=int)
    cdef void _begin_disturbance(self) except *
