# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can cimport bits as can_bits
from canwire.bus.can.node cimport Bus, Mailbox, Node
from canwire.chips.confinement cimport Confinement
from canwire.chips.host cimport Host

cdef const int _PASSIVE, _BUS_OFF
cdef int _STOPPED, _ERROR, _STATE, _ARBITRATION_LOST

@cython.final
cdef class CanFdController(Node):
    cdef readonly Host host
    cdef readonly Confinement confinement
    cdef readonly Mailbox normal, high
    cdef public bint running
    cdef public unsigned long long errors, frames_sent
    cdef public int last_error

    cpdef int take(self, Mailbox box) except -1
    cpdef bint abort(self, Mailbox box, unsigned long long at_ns) except -1

    cdef inline void _make_offer(self) noexcept
    cdef int _take_options(self, object options) except -1
    cdef int _give_up(self, Mailbox box, unsigned long long at_ns) except -1
    cdef int _state_changed(self, unsigned long long at_ns) except -1
    cdef void _take_state(self) noexcept
    cdef void _wait(self, int sequences, unsigned long long at_ns) noexcept
