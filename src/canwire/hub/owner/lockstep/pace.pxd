# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.hub.owner.lockstep.keeper cimport Lockstep
from canwire.hub.owner.lockstep.turns cimport Participant, Turns
from canwire.hub.owner.pace cimport RealPace
from canwire.timeline cimport Timeline

cdef long long _SLICE, _LONGEST_SILENCE_NS, _STEP_NS, _NEVER

cdef class LockstepPace(RealPace):
    cdef Lockstep _lockstep
    cdef Turns _turns
    cdef object _held, _missing
    cdef long long _patience_ns, _instant, _stand_ns, _stand_given
    cdef Participant _stand_runs
    cdef bint _told, _told_of_repeats
    cdef dict _spent_ns

    cpdef tuple lateness(self)

    @cython.locals(until_ns="long long", now_ns="long long")
    cpdef catch_up(self)

    @cython.locals(timeline=Timeline, began_ns="long long", until_ns="long long", due_ns="long long", next_ns="long long",
                   limit_ns="long long", whole=bint)
    cpdef object run(self)

    cdef long long _limit_ns(self, long long next_ns) except? -1

    @cython.locals(long_ns="long long", repeats_ns="long long", repeats=bint)
    cdef object _watch(self, long long now_ns)

    @cython.locals(spent_ns="long long", instant="long long")
    cdef object _look(self, long long now_ns)
