# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.boards.can.channel cimport Channel
from canwire.boards.can.line cimport Line
from canwire.values.frame cimport Frame

cdef unsigned int _SINGLE_SHOT, _HIGH_PRIORITY

cdef class Sending:
    cdef object _time
    cdef public Line line
    cdef public Channel _channel
    cdef public unsigned int _flags
    cdef public bint _plain, _closed
    cdef dict _waiters
