# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.boards.channel cimport Channel
from canwire.bus.node cimport Mailbox
from canwire.chips.can_fd cimport CanFdController, Host
from canwire.ring cimport Ring
from canwire.timeline cimport Timeline
from canwire.values cimport frame as codec
from canwire.values.frame cimport Frame

cdef unsigned int _SELF_RECEPTION, _CONFIRM
cdef int _ABORTED

cdef class Line(Host):
    cdef readonly object name
    cdef readonly Timeline timeline
    cdef readonly CanFdController controller
    cdef public object driver
    cdef Mailbox _scratch
    cdef int _turn
    cdef list _all, _senders, _receivers, _observers

    cpdef void send(self, Channel channel, Frame frame, unsigned int flags=*, unsigned long long delay_ns=*) except *

    @cython.locals(controller=CanFdController, had_offer=Mailbox)
    cpdef void kick(self) except *

    @cython.locals(channel=Channel)
    cpdef void received(self, Mailbox box, unsigned long long at_ns) except *

    @cython.locals(channel=Channel, listener=Channel, info="unsigned int")
    cpdef void transmitted(self, Mailbox box, unsigned long long at_ns) except *

    @cython.locals(channel=Channel)
    cpdef void aborted(self, Mailbox box, unsigned long long at_ns) except *

    @cython.locals(senders=list, count=int, controller=CanFdController, loaded=bint, k=int, turn=int,
                   channel=Channel, at=Py_ssize_t)
    cpdef void fill(self, unsigned long long at_ns) except *

    @cython.locals(delay_ns="unsigned long long")
    cdef bint _due(self, Channel channel, Ring ring, Py_ssize_t at, unsigned long long now_ns) except -1
