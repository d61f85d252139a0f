# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Bus, Mailbox
from canwire.chips.sja1000.modes cimport Modes

cdef int _SPECIAL, _WINDOW, _BUFFER, _CONTROL
cdef int _READ_STATUS, _READ_INTERRUPT, _READ_ALC, _READ_ECC, _READ_RXERR, _READ_TXERR, _READ_RMC, _READ_RBSA
cdef int _WRITE_MODE, _WRITE_CONTROL, _WRITE_COMMAND, _WRITE_IER, _WRITE_RXERR, _WRITE_TXERR, _WRITE_RBSA, _WRITE_CDR
cdef int _MOD, _SR, _IER, _ALC, _ECC, _OCR, _CDR, _TX_RAM, _RX_FIFO
cdef int _RM, _SM, _TR, _AT, _RRB, _CDO, _SRR
cdef int _RBS, _DOS, _TBS, _RS, _TS, _BS, _RI, _BASIC_IR_ONES, _CDR_ZERO
cdef int _QUIET, _RECEIVED_LAST, _RECEIVING, _SENDING
cdef int _FORCED_TXERR, _STOPS_AFTER_BITS

@cython.final
cdef class Sja1000(Modes):
    @cython.locals(code=int)
    cpdef int read(self, int address) except -1
    @cython.locals(code=int)
    cpdef int peek(self, int address) except -1
    @cython.locals(code=int)
    cpdef write(self, int address, int value)
    cdef int _look_at(self, int code) except -1
    cdef inline int _window(self, int code) noexcept
    @cython.locals(value=int, activity=int)
    cdef int _status(self) except -1
    cdef int _write(self, int code, int value) except -1
    cdef int _write_txerr(self, int value) except -1
    cdef void _write_divider(self, int value) except *
    cdef int _write_mode(self, int value) except -1
    cdef int _write_control(self, int value) except -1
    @cython.locals(asked=int)
    cdef int _command(self, int value) except -1
    @cython.locals(offer=Mailbox)
    cdef void _abort(self) except *
