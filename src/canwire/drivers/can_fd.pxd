# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Bus
from canwire.chips.ideal.can_fd cimport CanFdController
from canwire.drivers.driver cimport Driver

@cython.final
cdef class CanFdDriver(Driver):
    cdef CanFdController _controller
