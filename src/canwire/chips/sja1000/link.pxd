# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can cimport bits as can_bits
from canwire.bus.can.node cimport Bus, Mailbox, Node
from canwire.chips.confinement cimport Confinement
from canwire.chips.sja1000.fifo cimport ReceiveFifo
from canwire.chips.sja1000.filter cimport AcceptanceFilter
from canwire.chips.sja1000.interrupts cimport Interrupts

cdef int _SR, _ALC, _ECC, _EWLR, _TX_RAM
cdef int _BS, _ES, _TCS, _TBS, _DOS, _RBS
cdef int _RI, _TI, _EI, _DOI, _EPI, _ALI, _BEI
cdef int _FORM_KIND, _CRC_KIND, _DELIMITER_PART, _TOLERATED_PART, _FORM, _RECEIVING
cdef bytes _TYPES
cdef int _LONG_TRANSMITTER, _LONG_RECEIVER, _FLAG_TRANSMITTER, _FLAG_RECEIVER
cdef int _BASIC_WARNING_LIMIT, _BUS_OFF_LIMIT, _BUS_OFF_TXERR
cdef unsigned int _EXTENDED_INFO, _REMOTE_INFO

cdef class BusSide(Node):
    cdef readonly bytearray cells
    cdef readonly Interrupts interrupts
    cdef readonly ReceiveFifo fifo
    cdef readonly AcceptanceFilter filter
    cdef readonly Confinement confinement
    cdef public bint pelican, bus_off
    cdef public unsigned long long frames_sent, errors
    cdef Mailbox _box, _spare
    cdef bint _self_reception, _alc_free, _ecc_free
    cdef int _inside

    cdef int _take_parts(self) except -1
    @cython.locals(status=int)
    cdef void _take_in(self, unsigned long long *words) except *
    cdef int _capture(self, int code) except -1
    @cython.locals(tec=int, rec=int, limit=int, status=int, warned=int, passive=bint)
    cdef void _weigh(self) except *
    cdef int _go_bus_off(self) except -1
    cdef int _enter_reset(self) except -1
    cdef int _give_up(self) except -1
    cdef int _settle(self) except -1
    @cython.locals(status=int, offer=Mailbox, box=Mailbox, bus=Bus)
    cdef void _request(self, bint self_reception, bint single_shot) except *
    @cython.locals(cells="unsigned char *", at=int, first="unsigned int", second="unsigned int", remote="unsigned int",
                   info="unsigned int", identifier="unsigned int", dlc="unsigned int", length=int,
                   head="unsigned long long", data="unsigned long long", octet="unsigned long long", k=int)
    cdef int _compose(self, unsigned long long *words) except -1
