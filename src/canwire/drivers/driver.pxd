# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can.node cimport Mailbox, Sink
from canwire.chips.host cimport Host

cdef const unsigned int _SINGLE_SHOT, _HIGH_PRIORITY, _ABORT_ON_ERROR

cdef class Driver:
    cdef public Host host
    cdef public Mailbox normal, high
    cdef public bint running, listen_only, several
    cdef public list boxes
    cdef public int fd

    @cython.final
    cdef bint occupied(self, unsigned long long *words, Py_ssize_t at) except -1

    @cython.final
    @cython.locals(info="unsigned int", urgent=bint, box=Mailbox)
    cdef bint load(self, unsigned long long *words, Py_ssize_t at, unsigned long long now_ns, object owner) except -1

    @cython.final
    @cython.locals(box=Mailbox)
    cdef object _free(self)

    @cython.locals(free=bint, box=Mailbox)
    cpdef bint full_for(self, object owner) except -1
    cpdef transmit(self, Mailbox box, unsigned long long at_ns)
    cpdef poll(self)
    cpdef bint abort(self, Mailbox box, unsigned long long at_ns) except -1
    cpdef listen(self, Sink sink, bint attentive)
    cpdef bint on_wire(self) except -1
