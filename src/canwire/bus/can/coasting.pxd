# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can cimport reader_state
from canwire.bus.can.bit_layout cimport KeptLayout
from canwire.bus.can.clock cimport Clock
from canwire.bus.can.frame_reader cimport FrameReader
from canwire.bus.can.node cimport Node
from canwire.bus.can.station cimport Station

cdef int _IDLE, _FRAME, _ACTIVE_FLAG, _PASSIVE_FLAG, _FLAG_WAIT
cdef int _DELIMITER, _OVERLOAD_FLAG, _INTERMISSION, _SUSPEND, _WAITING
cdef int _CRC_DELIMITER, _ACK_DELIMITER, _EOF, _EOF_BITS, _TAIL_BITS, _ACK_BIT, _FEW, _FEW_BITS, _LONG, _RECOVERED, _NON_ISO

cdef class Stretch:
    cdef readonly bytes levels
    cdef readonly int first, level, tail
    cdef readonly Clock sender
    cdef FrameReader _scratch
    cdef int _answer
    cdef bint _unlike
    cdef FrameReader _asked

    @cython.final
    @cython.locals(sender=Station, bits=int)
    cdef int look(self, list clocks, int most, bint recessive, unsigned long long at_ns) except -1
    @cython.final
    @cython.locals(clock=Clock)
    cdef int _let_begin(self, list clocks, unsigned long long at_ns) except -1
    @cython.final
    @cython.locals(found=Clock, clock=Clock)
    cdef Clock first_sender(self, list clocks)
    @cython.final
    @cython.locals(lead=Station, clock=Clock, station=Station, answered=bint, quiet=int, bits=int)
    cdef int _look_along(self, list clocks, int most) except -1
    @cython.final
    cdef int _take(self, Station lead, bytes levels) except -1
    @cython.final
    @cython.locals(lead=Station, lost=int)
    cdef int _agreed(self, Station station, int most) except -1
    @cython.final
    @cython.locals(bits=int, k=int)
    cdef int _loses_at(self, Station station, int most) except? -1
    @cython.final
    @cython.locals(lead=Station, node=Node, reader=FrameReader)
    cdef bint _receives_from_here(self, Station station) except -1
    @cython.final
    cdef int _end(self, Station station, int quiet) noexcept
    @cython.final
    @cython.locals(lead=Station, scratch=FrameReader, clock=Clock, station=Station, reads=bint)
    cdef int _read_along(self, list clocks, int most) except -1
    @cython.final
    @cython.locals(level=int, clock=Clock, station=Station, bits=int, busy=bint)
    cdef int _look_ahead(self, list clocks, int most) except -1
    @cython.final
    @cython.locals(reader=FrameReader, field=int, good=bint)
    cdef int _in_frame(self, Station station, int level) except -1
    @cython.final
    cdef int _bits_before_error(self, FrameReader reader, int level) except -1
    cdef long long last_ps(self, long long began_ps, int bits, Clock clock) except? -1
    @cython.locals(clock=Clock, station=Station)
    cdef int go(self, list clocks, int bits, long long at_ps, unsigned long long sampled_ns) except -1
    @cython.final
    @cython.locals(station=Station, lost=int)
    cdef int _go_along(self, Clock clock, int bits, long long at_ps) except -1
    @cython.final
    @cython.locals(station=Station, passed=int)
    cdef int _go_to_the_end(self, Clock clock, int bits, long long at_ps) except -1
    @cython.final
    cdef int level_of(self, int bit) noexcept
    @cython.final
    @cython.locals(at=int)
    cdef int last_fall(self, int wire, int bits) noexcept
    @cython.final
    @cython.locals(k=int)
    cdef list _changes(self, int bits, long long at_ps, long long bit_ps, int shown, long long unit_ps)
    @cython.final
    cdef void show(self, int bits, long long at_ps, long long bit_ps, int shown, capture, capture_many) except *
    @cython.final
    @cython.locals(lead=Station, scratch=FrameReader, clock=Clock, station=Station)
    cdef int _read_on(self, list clocks, int bits) except -1
    @cython.final
    @cython.locals(passed=int, taken=int)
    cdef int _read_at_once(self, FrameReader reader, KeptLayout layout, int bits) except -1
    @cython.final
    @cython.locals(k=int)
    cdef int _count_recessive(self, Station station, int bits) except -1

@cython.locals(clock=Clock)
cdef bint _all_idle(list clocks) except -1
cdef bint _reports_loss(Station station) noexcept
cdef bint _acknowledges(Station station) noexcept
cdef int _quiet_tail(Station station) noexcept
@cython.locals(waits=bint)
cdef bint _can_wait(Station station) noexcept
@cython.locals(state=int)
cdef int _between(Station station, int level) noexcept
cdef int _counted(Station station, int level) noexcept
@cython.locals(state=int)
cdef int _keep(Station station, int level, int bits) except -1
@cython.locals(reader=FrameReader)
cdef int _pass_tail(Station station, int bits) except -1
