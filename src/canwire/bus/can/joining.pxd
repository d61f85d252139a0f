# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Node

cdef unsigned long long _NEVER

@cython.final
cdef class Joining:
    cdef public list nodes
    cdef public unsigned long long quiet_from_ns
    cdef public long long quiet_from_ps

    cpdef object quiet_from(self)
    @cython.locals(node=Node, soonest="unsigned long long", due="unsigned long long")
    cdef unsigned long long next_ns(self, unsigned long long start_ns, long long start_ps) except? 0
    @cython.locals(node=Node, due="unsigned long long")
    cdef int join(self, unsigned long long at_ns, long long at_ps) except -1
    @cython.locals(since="unsigned long long", past_ps="long long")
    cdef int groups(self, Node node, unsigned long long at_ns, long long at_ps) except -1
    @cython.locals(node=Node, enough=bint)
    cdef bint count(self, unsigned long long start_ns, long long start_ps) except -1
    @cython.locals(node=Node)
    cdef int restart(self) except -1
    cdef unsigned long long _quiet_since(self, Node node) noexcept
    cdef long long _beyond_ps(self, Node node) noexcept
    cdef unsigned long long _due_ns(self, Node node) noexcept
    cdef long long _due_ps(self, Node node) noexcept
    cdef long long _missing_ps(self, Node node) noexcept
