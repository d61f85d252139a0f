# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.boards.channel cimport Channel
from canwire.bus.node cimport Mailbox, Sink
from canwire.chips.can_fd cimport CanFdController, Host
from canwire.ring cimport Ring
from canwire.timeline cimport Timeline
from canwire.values cimport frame as codec
from canwire.values.frame cimport Frame

cdef unsigned int _SELF_RECEPTION, _CONFIRM, _HIGH_PRIORITY
cdef int _ABORTED

cdef class Splitter(Sink):
    cdef public list channels

    @cython.locals(channel=Channel)
    cdef int _deliver(self, Mailbox box, unsigned long long at_ns, unsigned long long flags) except -1

cdef class Line(Host):
    cdef readonly object name
    cdef readonly Timeline timeline
    cdef readonly CanFdController controller
    cdef public object driver
    cdef Mailbox _scratch
    cdef int _turn
    cdef list _all, _senders, _observers
    cdef Splitter _splitter

    cpdef int send(self, Channel channel, Frame frame, unsigned int flags=*, unsigned long long delay_ns=*) except -1

    @cython.locals(controller=CanFdController, had_offer=Mailbox)
    cpdef int kick(self) except -1

    @cython.locals(channel=Channel, info="unsigned int")
    cpdef transmitted(self, Mailbox box, unsigned long long at_ns)

    @cython.locals(channel=Channel)
    cpdef aborted(self, Mailbox box, unsigned long long at_ns)

    cpdef fill(self, unsigned long long at_ns)

    @cython.final
    @cython.locals(senders=list, count=int, controller=CanFdController, k=int, turn=int, normal_taken=bint, channel=Channel, ring=Ring,
                   at=Py_ssize_t)
    cdef bint _load_one(self, unsigned long long at_ns) except -1

    @cython.final
    @cython.locals(delay_ns="unsigned long long")
    cdef bint _due(self, Channel channel, Ring ring, Py_ssize_t at, unsigned long long now_ns) except -1
