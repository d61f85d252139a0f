# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus cimport can_bits
from canwire.bus.node cimport Bus, Mailbox, Node
from canwire.chips.confinement cimport Confinement

cdef unsigned int _SINGLE_SHOT, _HIGH_PRIORITY
cdef int _PASSIVE, _BUS_OFF, _STOPPED, _ERROR, _STATE, _ARBITRATION_LOST

cdef class Host:
    cpdef received(self, Mailbox box, unsigned long long at_ns)
    cpdef transmitted(self, Mailbox box, unsigned long long at_ns)
    cpdef aborted(self, Mailbox box, unsigned long long at_ns)
    cpdef fill(self, unsigned long long at_ns)
    cpdef event(self, int kind, int error, int bit, bint transmitting, unsigned long long at_ns)

@cython.final
cdef class CanFdController(Node):
    cdef public Host host
    cdef public Confinement confinement
    cdef public Mailbox normal, high
    cdef public bint running
    cdef public unsigned long long errors, frames_sent
    cdef public int last_error

    cdef bint occupied(self, unsigned long long *words, Py_ssize_t at) noexcept

    @cython.locals(box=Mailbox, urgent=bint)
    cdef bint load(self, unsigned long long *words, Py_ssize_t at, unsigned long long now_ns, object owner) except -1

    cdef void _make_offer(self) noexcept
    cdef int _give_up(self, Mailbox box, unsigned long long at_ns) except -1
    cdef int _state_changed(self, unsigned long long at_ns) except -1
    cdef void _take_state(self) noexcept
    cdef void _wait(self, int sequences, unsigned long long at_ns) noexcept
