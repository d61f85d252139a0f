# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can cimport reader_state
from canwire.bus.can.bit_layout cimport KeptLayout
from canwire.bus.can.clock cimport Clock
from canwire.bus.can.frame_reader cimport FrameReader
from canwire.bus.can.station cimport Station

cdef int _IDLE, _FRAME, _ACTIVE_FLAG, _PASSIVE_FLAG, _FLAG_WAIT
cdef int _DELIMITER, _OVERLOAD_FLAG, _INTERMISSION, _SUSPEND, _WAITING
cdef int _CRC_DELIMITER, _ACK_DELIMITER, _EOF, _EOF_BITS, _FEW, _FEW_BITS, _LONG, _RECOVERED

cdef class Stretch:
    cdef readonly bytes levels
    cdef readonly int first, level
    cdef readonly Clock sender
    cdef FrameReader _scratch
    cdef int _answer
    cdef bint _unlike
    cdef FrameReader _asked

    @cython.final
    @cython.locals(sender=Station)
    cdef int look(self, list clocks, int most) except -1
    @cython.final
    @cython.locals(found=Clock, clock=Clock)
    cdef Clock first_sender(self, list clocks)
    @cython.final
    @cython.locals(sender=Station, clock=Clock, station=Station)
    cdef int _look_along(self, list clocks, int most) except -1
    @cython.final
    @cython.locals(layout=KeptLayout, end=int, k=int)
    cdef int _agreed(self, Station station, int most) except -1
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
    cdef int level_of(self, int bit) noexcept
    @cython.final
    @cython.locals(at=int)
    cdef int last_fall(self, int bits) noexcept
    @cython.final
    @cython.locals(lead=Station, scratch=FrameReader, clock=Clock, station=Station, taken=int)
    cdef int _read_on(self, list clocks, int bits) except -1
    @cython.final
    @cython.locals(k=int)
    cdef int _count_recessive(self, Station station, int bits) except -1

@cython.locals(waits=bint)
cdef bint _can_wait(Station station) noexcept
@cython.locals(state=int)
cdef int _between(Station station, int level) noexcept
cdef int _counted(Station station, int level) noexcept
@cython.locals(state=int)
cdef int _keep(Station station, int level, int bits) except -1
@cython.locals(reader=FrameReader)
cdef int _pass_tail(Station station, int bits) except -1
