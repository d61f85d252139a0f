# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.hub.owner.lockstep.program cimport Program, Seat
from canwire.hub.owner.lockstep.shared_page cimport SharedPage
from canwire.hub.owner.lockstep.turns cimport Participant, Turns
from canwire.timeline cimport Timeline

cdef class Lockstep:
    cdef public Turns turns
    cdef public object standstill, held
    cdef public long long turn_ns
    cdef Timeline _timeline
    cdef object _world, _hub
    cdef dict _programs, _of_session, _pages, _seats
    cdef long long _last

    @cython.locals(program=Program, page=SharedPage, seat=Seat)
    cpdef rung(self, session)

    @cython.locals(one=Participant, seat=Seat)
    cpdef give_turn(self)

    cdef Seat _at(self, Program program, session, thread)

    @cython.locals(page=SharedPage, other=Seat)
    cdef object _sends(self, Program program, Seat seat)

    cdef Program _of(self, session)

    @cython.locals(participant=Participant, seat=Seat)
    cdef Seat _seated(self, Program program, thread, name)
