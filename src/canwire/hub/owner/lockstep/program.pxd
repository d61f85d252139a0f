# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.hub.owner.lockstep.shared_page cimport SharedPage
from canwire.hub.owner.lockstep.turns cimport Participant
from canwire.timeline cimport Timeline

cdef class Seat:
    cdef public Program program
    cdef public Participant participant
    cdef public object asked, answer
    cdef public SharedPage page
    cdef public set sessions

cdef class Program:
    cdef public object word, name, process
    cdef public long long number
    cdef public list sessions
    cdef public dict seats
    cdef public bint rung
    cdef Timeline _timeline

    @cython.locals(seat=Seat)
    cpdef bint runs(self) except -1

    @cython.locals(seat=Seat)
    cpdef halt(self)
