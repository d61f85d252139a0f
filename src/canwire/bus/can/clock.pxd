# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.echo cimport Echo
from canwire.bus.can.node cimport Node
from canwire.bus.can.station cimport Station

cdef int _FRAME, _IDLE, _INTERMISSION, _SUSPEND, _WAITING, _ACTIVE_FLAG, _OVERLOAD_FLAG
cdef int _KEEP_RATE, _TO_DATA_RATE, _FREE, _RES_FIELD
cdef long long _NEVER

@cython.final
cdef class Clock:
    cdef readonly Station station
    cdef readonly Node node
    cdef public long long start_ps, due_ps, edge_ps, check_ps
    cdef public int forced, seen, looks
    cdef public bint sampling, synchronised, data_rate, free, joins, edged
    cdef readonly Echo echo
    cdef readonly long long ahead_start_ps, ahead_due_ps
    cdef readonly int ahead_taken, ahead_begun
    cdef readonly bint ahead_sampling, ahead_synchronised

    cpdef int begin(self, long long at_ps) except -1
    cdef long long bit_ps(self) noexcept
    cdef long long sample_ps(self) noexcept
    cpdef int begin_bit(self, long long at_ps) except -1
    cdef int _compensate(self, long long at_ps) except -1
    @cython.locals(soonest="long long", gap_ps="long long")
    cdef long long next_ps(self, long long now_ps) noexcept
    @cython.locals(before_ps="long long", gap_ps="long long")
    cdef bint looks_before(self, long long at_ps) noexcept
    cdef void look(self, int level) noexcept
    cdef int found(self, int level) except? -1
    cpdef void check(self, int level, long long at_ps) except *
    @cython.locals(change=int)
    cpdef int sampled(self, long long at_ps) except -1
    cdef int drive_run(self, bytes levels, int first, int bits, long long at_ps) except -1
    cdef int answer(self, long long at_ps, bint over) except -1
    @cython.locals(state=int, level=int)
    cdef int drive_steady(self, long long at_ps) except -1
    cdef int pass_bits(self, int bits, long long at_ps) noexcept
    cdef void keep_ahead(self, long long start_ps, long long due_ps, bint sampling, bint synchronised, int taken, int begun) noexcept
    cdef void go_ahead(self) noexcept
    cdef bint coasts_with(self, Clock other) noexcept
    @cython.locals(station=Station, state=int, idle=bint, behind=bint)
    cpdef void edge(self, long long at_ps) except *
    cdef int _restart_bit(self, long long at_ps) except -1
    @cython.locals(quantum="long long", jump="long long", late="long long", early="long long")
    cdef void _resynchronise(self, long long at_ps) except *
