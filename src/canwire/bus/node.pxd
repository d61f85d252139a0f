# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
from canwire cimport _mem
from canwire.timeline cimport Source

cdef class Mailbox:
    cdef readonly object block
    cdef unsigned long long *words
    cdef public unsigned int key
    cdef public int bits, data_bits
    cdef public unsigned long long ready_ns
    cdef public bint occupied, esi_added
    cdef public object owner

cdef class Node:
    cdef public object name
    cdef public Bus bus
    cdef public bint on_bus, listen_only, passive, tainted
    cdef public int fd
    cdef public Mailbox offer, contending
    cdef public unsigned long long suspended_ns, waiting_from_ns
    cdef public int waiting, sequences
    cdef public long long bit_ps, sample_ps, quantum_ps, phase1_ps, jump_ps
    cdef public long long data_bit_ps, data_sample_ps, data_quantum_ps, data_jump_ps

    cpdef void received(self, Mailbox box, unsigned long long at_ns) except *
    cpdef void transmitted(self, Mailbox box, unsigned long long at_ns) except *
    cpdef void arbitration_lost(self, Mailbox box, int bit, unsigned long long at_ns) except *
    cpdef void error(self, int kind, int bit, bint transmitting, int rule, unsigned long long at_ns) except *
    cpdef void count(self, int rule, unsigned long long at_ns) except *
    cpdef void joined(self, unsigned long long at_ns) except *

cdef class Bus(Source):
    cpdef void poll(self, Node node) except *
    cpdef void interrupt(self) except *
    cpdef void changed(self) except *
    cpdef bint on_wire(self, Node node) except -1
