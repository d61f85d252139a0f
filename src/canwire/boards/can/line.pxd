# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.boards.can.channel cimport Channel, Splitter
from canwire.bus.can.node cimport Mailbox, Node
from canwire.chips.host cimport Host
from canwire.drivers.driver cimport Driver
from canwire.ring cimport Ring
from canwire.timeline cimport Timeline
from canwire.values cimport frame as codec
from canwire.values.frame cimport Frame

cdef unsigned int _CONFIRM, _CONFIRM_LOAD, _HIGH_PRIORITY
cdef const unsigned int _SELF_RECEPTION, _EXTENDED, _REMOTE, _FD, _FAST, _LOOP_BACK
cdef const unsigned int _LARGEST_STANDARD, _LARGEST_EXTENDED
cdef const unsigned long long _M32, _PAUSE_NS
cdef const int _REFUSALS
cdef int _ABORTED, _ERROR, _EVERY

@cython.final
cdef class Line(Host):
    cdef readonly object name
    cdef readonly Timeline timeline
    cdef readonly Node controller
    cdef readonly Driver driver
    cdef public object coupling_fault
    cdef public bint long_data, fast_data, holding
    cdef public object kin
    cdef Mailbox _scratch
    cdef int _turn, _refusals
    cdef unsigned long long _loads, _patient_until_ns
    cdef bint _watched
    cdef list _all, _senders, _observers, _prioritised
    cdef object _backlog
    cdef dict _hearings
    cdef Splitter _splitter
    cdef Channel _lone

    @cython.locals(driver=Driver, box=Mailbox)
    cpdef bint pending(self)

    cpdef int send(self, Channel channel, Frame frame, unsigned int flags=*, unsigned long long delay_ns=*) except -1

    @cython.locals(driver=Driver, before="unsigned long long", lone=Channel, free=bint)
    cpdef int kick(self) except -1

    @cython.locals(other=Channel, info="unsigned int")
    cdef inline int _count_sent(self, Channel channel, Mailbox box, unsigned long long at_ns) except -1

    @cython.locals(senders=list, count=int, k=int, turn=int, normal_taken=bint, channel=Channel, loaded=bint)
    cdef inline bint _load_one(self, unsigned long long at_ns) except -1

    @cython.locals(ring=Ring, at=Py_ssize_t, driver=Driver, delay_ns="unsigned long long")
    cdef inline bint _load_trusted(self, Channel channel, unsigned long long at_ns) except -1

    @cython.locals(ring=Ring, at=Py_ssize_t, driver=Driver, words="unsigned long long *", delay="unsigned long long")
    cdef bint _load_untrusted(self, Channel channel, unsigned long long at_ns) except -1

    @cython.locals(ring=Ring, at=Py_ssize_t, words="unsigned long long *", priority=int, loop_back=bint)
    cdef int _drain(self, Channel channel, unsigned long long at_ns) except -1

    cdef int _tell_aborted(self, Channel channel, unsigned long long at_ns) except -1

    @cython.locals(channel=Channel, owner=Channel, driver=Driver, box=Mailbox)
    cdef bint _load_first(self, unsigned long long at_ns) except -1

    cdef bint _refuse(self, Channel channel, unsigned long long at_ns) except -1

    @cython.locals(info="unsigned long long", identifier="unsigned long long", length=int)
    cdef bint _admit(self, unsigned long long *words, Channel channel) except -1

    cdef inline bint _due(self, Channel channel, unsigned long long delay_ns, unsigned long long now_ns) except -1
