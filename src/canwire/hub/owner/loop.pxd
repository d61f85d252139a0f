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
    cdef list _reminders
    cdef object _numbers

    cdef object _turn(self, object timeout)

    cdef object _work(self, list found)

    cdef object _until_reminder(self, object timeout)

    cdef object _remind(self)

    @cython.locals(events=int)
    cdef object _handle(self, Watched watched, int events)
