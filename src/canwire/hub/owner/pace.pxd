# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.timeline cimport Timeline

cdef long long _REST, _BURST, _SLICE, _STEP, _LONGEST_STEP, _LARGEST_GAP, _LONGEST_WAIT, _UNHEARD, _NEVER

cdef class RealPace:
    cdef public bint held
    cdef public object lateness_ns
    cdef public long long skipped_ns
    cdef public object _world, _monotonic_ns
    cdef object _bells, _due
    cdef public Timeline _timeline
    cdef long long _origin_ns, _rest_until_ns, _step_ns, _warned_ns

    @cython.locals(behind_ns="long long")
    cpdef tuple lateness(self)

    @cython.locals(now_ns="long long", late_ns="long long")
    cpdef catch_up(self)

    @cython.locals(began_ns="long long", before_ns="long long", after_ns="long long", spent_ns="long long", due_ns="long long")
    cdef bint _in_steps(self, long long limit_ns, bint busy) except -1

    cdef long long _due_ns(self, bint busy) except? -1

    @cython.locals(timeline=Timeline)
    cdef int _run(self, long long limit_ns, bint busy) except -1

    cpdef int tell(self) except -1

    cdef object _warn(self)

    @cython.locals(due_ns="long long", now_ns="long long", wait_ns="long long")
    cpdef object run(self)

    cdef long long _clock_ns(self) except? -1

    cdef object _skip(self, long long span_ns)

cdef class FastPace(RealPace):
    cdef long long _patient_until_ns

    cpdef catch_up(self)

    @cython.locals(timeline=Timeline, wait_ns="long long", limit_ns="long long")
    cpdef object run(self)

    cdef object _rest(self)

    cdef bint _held_up(self) except -1

    cdef long long _patience_ns(self) except? -1

    cdef object _go_on_from_here(self)
