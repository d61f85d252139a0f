# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython

cdef unsigned long long _NEVER

cdef class Source:
    cdef unsigned long long known_ns

    cpdef unsigned long long next_ns(self) except? 0
    cpdef unsigned long long wake_ns(self) except? 0
    cpdef run(self, unsigned long long limit_ns)

@cython.final
cdef class Timer:
    cdef public unsigned long long time_ns, slack_ns
    cdef public object callback
    cdef public bint background

@cython.final
cdef class Timeline:
    cdef public unsigned long long now_ns
    cdef public bint interrupted
    cdef bint _halted
    cdef bint _outdated
    cdef unsigned long long _sequence
    cdef list _timers
    cdef Py_ssize_t _most_timers
    cdef list _sources

    cpdef void halt(self) noexcept

    cpdef unsigned long long next_ns(self) except? 0

    @cython.locals(soonest="unsigned long long", source=Source)
    cpdef unsigned long long wake_ns(self) except? 0

    cpdef unsigned long long busy_ns(self) except? 0

    cpdef bint idle(self) except -1

    cpdef bint run_until(self, unsigned long long limit_ns) except -1

    cpdef bint run_until_idle(self, unsigned long long limit_ns) except -1

    cpdef bint run_busy(self, unsigned long long limit_ns) except -1

    cdef void _begin(self) noexcept

    @cython.locals(soonest="unsigned long long", source=Source)
    cdef unsigned long long _busy_ns(self) except? 0

    @cython.locals(source=Source, timer=Timer)
    cdef bint _idle(self) except -1

    @cython.locals(source=Source)
    cdef int _ask_sources(self) except -1

    cdef unsigned long long _next_timer_ns(self) except? 0

    @cython.locals(soonest="unsigned long long", timer=Timer)
    cdef unsigned long long _wake_timer_ns(self) except? 0

    cdef _sweep(self)

    @cython.locals(due_ns="unsigned long long", first_ns="unsigned long long", bound_ns="unsigned long long", at_ns="unsigned long long", source=Source, first=Source)
    cdef bint _step(self, unsigned long long limit_ns) except -1

    cdef bint _run_timer(self) except -1
