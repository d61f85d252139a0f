# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can.node cimport Node

cdef long long _NEVER
cdef int _HISTORY

@cython.final
cdef class Echo:
    cdef readonly Node node
    cdef readonly object _block
    cdef unsigned long long *_history
    cdef readonly long long changes  # an index is made of it
    cdef public long long measuring_ps, measured_ps
    cdef public int last
    cdef public bint failed
    cdef list _checks, _expected

    cdef int _take_memory(self) except -1
    cpdef int begin(self) except -1
    cpdef void drive(self, int level, long long at_ps) noexcept
    @cython.locals(last=int, changes="long long", k=int)
    cdef int drive_run(self, bytes levels, int first, int bits, long long at_ps, long long bit_ps) except -1
    @cython.locals(changed_ps="long long")
    cpdef bint changed_at(self, long long at_ps) noexcept
    @cython.locals(newest="long long", oldest="long long", changed_ps="long long")
    cpdef int level_at(self, long long at_ps) noexcept
    cpdef bint takes(self, long long at_ps) noexcept
    cpdef long long measure_from(self, long long at_ps) noexcept
    @cython.locals(delay_ps="long long")
    cdef bint _measured(self, long long at_ps) noexcept
    @cython.locals(node=Node, after_ps="long long")
    cpdef long long look_later(self, int level, long long at_ps) except? 0
    cpdef int invert(self) except -1
    cpdef long long check(self, int level) except? 0
    @cython.locals(failed=bint)
    cpdef int outcome(self, int level) noexcept
    cpdef long long forget_checks(self) except? 0
