# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.hub.owner.pace cimport RealPace

cdef int _WRITABLE

@cython.final
cdef class Watched:
    cdef public object readable, writable
    cdef public bint active

@cython.final
cdef class Loop:
    cdef public RealPace pace
    cdef public bint stopping
    cdef public object wake, thread
    cdef object _engine, _posted, _poller
    cdef dict _watched

    cdef object _turn(self, object timeout)

    cdef object _work(self, list found)

    @cython.locals(events=int)
    cdef object _handle(self, Watched watched, int events)
