# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus cimport can_bits
from canwire.bus.node cimport Bus, Mailbox, Node
from canwire.chips.confinement cimport Confinement

cdef unsigned int _SINGLE_SHOT, _HIGH_PRIORITY
cdef int _PASSIVE, _BUS_OFF, _STOPPED, _ERROR, _STATE, _ARBITRATION_LOST

cdef class Host:
    cpdef void received(self, Mailbox box, unsigned long long at_ns) except *
    cpdef void transmitted(self, Mailbox box, unsigned long long at_ns) except *
    cpdef void aborted(self, Mailbox box, unsigned long long at_ns) except *
    cpdef void fill(self, unsigned long long at_ns) except *
    cpdef void event(self, int kind, int error, int bit, bint transmitting, unsigned long long at_ns) except *

cdef class CanFdController(Node):
    cdef public Host host
    cdef public Confinement confinement
    cdef public Mailbox normal, high
    cdef public bint running
    cdef public unsigned long long arbitration_losses, errors, frames_sent, frames_received
    cdef public int last_error

    @cython.locals(box=Mailbox)
    cdef bint load(self, unsigned long long *words, Py_ssize_t at, unsigned long long now_ns, object owner) except -1

    cdef void _make_offer(self) noexcept
    cdef void _give_up(self, Mailbox box, unsigned long long at_ns) except *
    cdef void _state_changed(self, unsigned long long at_ns) except *
    cdef void _take_state(self) noexcept
    cdef void _wait(self, int sequences, unsigned long long at_ns) noexcept
