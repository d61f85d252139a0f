# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.timeline cimport Source, Timeline

@cython.final
cdef class Mailbox:
    cdef readonly object block
    cdef unsigned long long *words
    cdef public unsigned int key
    cdef public int bits, data_bits
    cdef public unsigned long long ready_ns
    cdef public bint occupied, esi_added, single_shot, abort_on_error
    cdef public object owner

cdef class Sink:
    cpdef int deliver(self, Mailbox box, unsigned long long at_ns, unsigned long long flags) except -1

cdef class Node:
    cdef public object name
    cdef public Bus bus
    cdef public Node next_member
    cdef public bint attentive, contends
    cdef public Sink sink
    cdef public unsigned long long arbitration_losses, frames_received
    cdef public bint on_bus, listen_only, passive, tainted, self_test, asleep, read_dominant
    cdef public int fd, segment
    cdef public Mailbox offer, contending
    cdef public unsigned long long suspended_ns, waiting_from_ns, counted_ns, stored_ns
    cdef public long long waiting_from_ps
    cdef public int waiting, sequences
    cdef public long long bit_ps, sample_ps, quantum_ps, phase1_ps, jump_ps
    cdef public long long data_bit_ps, data_sample_ps, data_quantum_ps, data_jump_ps
    cdef public long long loop_ps, second_sample_ps, least_second_ps, sample_gap_ps
    cdef public bint compensates, measures_delay, edge_filter, restricted, validates_early, protocol_exception
    cdef public object timing

    cpdef received(self, Mailbox box, unsigned long long at_ns)
    cpdef transmitted(self, Mailbox box, unsigned long long at_ns)
    cpdef arbitration_lost(self, Mailbox box, int bit, unsigned long long at_ns)
    cpdef error(self, int kind, int bit, bint transmitting, int rule, unsigned long long at_ns)
    cpdef count(self, int rule, unsigned long long at_ns)
    cpdef joined(self, unsigned long long at_ns)
    cpdef woken(self, unsigned long long at_ns)

cdef class Bus(Source):
    cdef public Timeline timeline

    cpdef poll(self, Node node)
    cpdef interrupt(self)
    cpdef changed(self)
    cpdef bint on_wire(self, Node node) except -1
    cpdef bint idle(self) except -1
    cpdef int activity(self, Node node) except -1
    cpdef catch_up(self, Node node)
    cpdef int recessive_groups(self, Node node) except -1
