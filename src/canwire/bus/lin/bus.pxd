# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.lin.node cimport LinMedium, LinNode, LinOffer, LinResponse
from canwire.bus.load cimport BusLoad
from canwire.timeline cimport Timeline

cdef unsigned long long _NEVER
cdef int _REST, _HEADER, _RESPONSE, _SILENCE, _BITWISE, _LONGEST_RESPONSE

@cython.final
cdef class LinBus(LinMedium):
    cdef public object name
    cdef public Timeline timeline
    cdef public list nodes
    cdef public BusLoad load
    cdef public object bits, wire
    cdef public bint bitwise
    cdef int _state
    cdef unsigned long long _due_ns
    cdef bint _running, _drowsy
    cdef list _members, _offering
    cdef dict _followed, _subscribers
    cdef unsigned long long _deaf_until_ns, _busy_from_ns
    cdef LinNode _sender, _owner
    cdef LinOffer _offer
    cdef LinResponse _response
    cdef object _phase_ps, _end_ps, _counted_ps
    cdef tuple _last_octet
    cdef object _idleness

    @cython.locals(node=LinNode, response=LinResponse, found=LinResponse)
    cdef LinResponse _foreseen(self, int id)

    @cython.locals(sender=LinNode, offer=LinOffer, now_ns="unsigned long long")
    cdef _begin(self)

    cdef bint _is_plain(self, LinNode sender, LinOffer offer) except -1

    @cython.locals(offer=LinOffer, sender=LinNode, owner=LinNode, node=LinNode, id=int, own=LinResponse, found=LinResponse,
                   response=LinResponse, rivals=bint, disturbed=bint)
    cdef _answer(self)

    @cython.locals(owner=LinNode, sender=LinNode, node=LinNode, response=LinResponse, at_ns="unsigned long long")
    cdef _deliver(self)

    @cython.locals(offer=LinOffer, sender=LinNode)
    cdef _fall_silent(self)

    @cython.locals(offer=LinOffer, sender=LinNode, node=LinNode, at_ns="unsigned long long")
    cdef _expire(self)
    cdef bint _misses(self, LinResponse response) except -1
    cdef _rest(self)
    cdef _step(self)
    cdef _go_on(self)
    cdef _request(self)
    cdef _schedule(self)
