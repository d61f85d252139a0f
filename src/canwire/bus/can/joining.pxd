# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Node

cdef unsigned long long _NEVER

@cython.final
cdef class Joining:
    cdef public list nodes
    cdef public unsigned long long quiet_from_ns

    @cython.locals(node=Node, soonest="unsigned long long", due="unsigned long long")
    cdef unsigned long long next_ns(self) except? 0
    @cython.locals(node=Node)
    cdef int join(self, unsigned long long at_ns) except -1
    @cython.locals(since="unsigned long long", past_ps="unsigned long long")
    cdef int groups(self, Node node, unsigned long long at_ns) except -1
    @cython.locals(node=Node, enough=bint)
    cdef bint count(self, unsigned long long start_ns) except -1
    @cython.locals(node=Node)
    cdef int restart(self) except -1
    cdef unsigned long long _quiet_since(self, Node node) noexcept
    @cython.locals(bits="long long")
    cdef unsigned long long _due_ns(self, Node node) noexcept
