# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.timeline cimport Source

@cython.final
cdef class LinResponse:
    cdef public int bits, gap_bits, id, length, space_bits
    cdef public object enhanced
    cdef readonly bytes octets
    cdef readonly bytearray record, sent_record

@cython.final
cdef class LinOffer:
    cdef public int id, length
    cdef public LinResponse response
    cdef public bint wake_up

cdef class LinNode:
    cdef public object name
    cdef public LinMedium bus
    cdef public bint on_bus, asleep, synchronises, searching
    cdef public unsigned long long ready_ns, awake_since_ns, headers
    cdef public long long bit_ps
    cdef public LinOffer offer
    cdef public list responses, lengths, models
    cdef public int break_bits, delimiter_bits, space_bits, header_bits

    cpdef received(self, LinResponse response, unsigned long long at_ns)
    cpdef transmitted(self, LinResponse response, unsigned long long at_ns)
    cpdef finished(self, LinOffer offer, unsigned long long at_ns)

cdef class LinMedium(Source):
    cpdef poll(self, LinNode node)
    cpdef unsigned long long foreseen_ns(self, LinNode sender, int id) except? 0
