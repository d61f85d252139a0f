# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can cimport coasting, reader_state
from canwire.bus.can.clock cimport Clock
from canwire.bus.can.coasting cimport Stretch
from canwire.bus.can.frame_reader cimport FrameReader
from canwire.bus.can.station cimport Station

cdef int _FRAME, _ACTIVE_FLAG, _OVERLOAD_FLAG, _CRC_DELIMITER, _RES_FIELD, _FREE
cdef long long _NEVER, _LONG

cdef class Apart(Stretch):
    cdef readonly Clock lead
    cdef readonly long long end_ps, latest_ps
    cdef int _wire

    @cython.locals(clock=Clock, sender=Station)
    cdef int look_apart(self, list clocks, int wire, long long limit_ps, bint calm) except -1
    @cython.locals(sender=Clock)
    cdef bint is_inside_bit(self) noexcept
    @cython.locals(lead=Clock, sender=Station, began_ps="long long", most="long long", bits=int, clock=Clock, station=Station)
    cdef int _look_along_one(self, list clocks, int wire, long long limit_ps) except -1
    @cython.locals(scratch=FrameReader, taken=int)
    cdef int _mere_bits(self, int most) except -1
    @cython.locals(lead=Clock, clock=Clock)
    cdef int cut(self, list clocks, int bits) except -1
    @cython.locals(bit_ps="long long", sample_ps="long long", sender_bit_ps="long long", edge_ps="long long",
                   start_ps="long long", due_ps="long long", sampling=bint, synchronised=bint, last=int, wire=int,
                   taken=int, begun=int, k=int, level=int)
    cdef bint _follow(self, Clock clock, int bits) except -1
    @cython.locals(busy=bint, clock=Clock, station=Station, bits="long long", sampled_ps="long long")
    cdef int _look_at_rest(self, list clocks, long long limit_ps) except -1
    @cython.locals(clock=Clock, bit_ps="long long", sample_ps="long long", start_ps="long long", due_ps="long long",
                   sampling=bint, synchronised=bint, taken=int, begun=int)
    cdef int _run_down(self, list clocks) except -1
    cdef long long last_ps(self, long long began_ps, int bits, Clock clock) except? -1
    @cython.locals(clock=Clock, station=Station)
    cdef int go(self, list clocks, int bits, long long at_ps, unsigned long long sampled_ns) except -1
    @cython.locals(station=Station)
    cdef int _go_at_rest(self, Clock clock) except -1

cdef bint _runs_freely(Clock clock) noexcept
@cython.locals(jump_ps="long long", early_ps="long long", quantum_ps="long long", late_ps="long long")
cdef long long _correction(Clock clock, long long edge_ps, long long start_ps, long long due_ps, bint sampling) noexcept
