# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.boards.can.message_filter cimport MessageFilter
from canwire.bus.can.node cimport Mailbox, Sink
from canwire.ring cimport Ring

cdef const unsigned int _REMOTE, _EXTENDED, _HIGH_PRIORITY, _CONFIRM, _SELF_RECEPTION, _FD
cdef unsigned int _ACCEPTED
cdef int _ALWAYS, _OWN_FILTERED, _ALL, _OWN, _AS_BUS, _EVERY, _OTHERS, _OTHERS_AND_OWN
cdef const unsigned long long _M32, _OVERRUN, _FRAME_BITS
cdef unsigned long long _KEY_EXTENDED, _KEY_REMOTE, _KEY_NO_BYTE_1, _KEY_NO_BYTES

@cython.final
cdef class Channel(Sink):
    cdef readonly Ring receive, transmit
    cdef public bint frames, sends, untrusted, fd, prioritised, hears_errors, standard, extended
    cdef public object events, acceptance, stands_for, kin
    cdef public unsigned long long accepted, lost, sent, delivered, aborted, refused, last_sent_ns
    cdef public unsigned long long tick_ns, origin_ns, delay_tick_ns, longest_delay
    cdef public bint held, paused
    cdef public int siblings
    cdef public unsigned int allowed
    cdef public long long urgent, in_flight
    cdef public MessageFilter filter, line_filter
    cdef bint _overrun_due, _open, _by_head
    cdef tuple _outcomes
    cdef object _pairs_block
    cdef unsigned long long *_pairs
    cdef int _head_words, _pair_words
    cdef list _listed

    cpdef bint gated(self)

    @cython.locals(code="unsigned long long")
    cdef int arrive(self, Mailbox box, unsigned long long at_ns, unsigned long long flags, bint looped) except -1

    cdef int _take_judged(self, Mailbox box, unsigned long long at_ns, unsigned long long flags,
                          unsigned long long code) except -1
    cdef inline int _take(self, Mailbox box, unsigned long long at_ns, unsigned long long head, unsigned long long flags) except -1

    cpdef int tell_outcome(self, Mailbox box, bint delivered, unsigned long long at_ns) except -1

    @cython.locals(head="unsigned long long")
    cpdef int deliver_sent(self, Mailbox box, unsigned long long at_ns) except -1

    cpdef int return_own(self, Mailbox box, unsigned long long at_ns) except -1

    @cython.locals(words="unsigned long long *", time_ns="unsigned long long")
    cpdef int deliver_event(self, bytes record, bint stamped=*) except -1

    cdef inline unsigned long long _stamp(self, unsigned long long at_ns) noexcept

    @cython.locals(pairs="unsigned long long *", k=int)
    cdef inline bint _passes(self, unsigned long long *words, unsigned long long head) except -1

    @cython.locals(info="unsigned int", identifier="unsigned long long", key="unsigned long long",
                   data="unsigned long long", k=int, length=int)
    cdef bint _passes_by_key(self, unsigned long long *words, unsigned long long head) except -1

    cdef bint _is_listed(self, unsigned long long identifier, unsigned int info) except -1

@cython.final
cdef class Splitter(Sink):
    cdef list channels  # not public: no None is among them

    cpdef int loop_back(self, Mailbox box, unsigned long long at_ns) except -1

    @cython.locals(channel=Channel)
    cdef int _deliver(self, Mailbox box, unsigned long long at_ns, unsigned long long flags, bint looped) except -1
