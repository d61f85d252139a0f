# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.node cimport Bus
from canwire.chips.can_fd cimport CanFdController
from canwire.drivers.driver cimport Driver

@cython.final
cdef class CanFdDriver(Driver):
    cdef CanFdController _controller
