# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.bus.can.node cimport Bus, Mailbox
from canwire.chips.sja1000.link cimport BusSide

cdef int _MOD, _SR, _IER, _CDR, _ACR0, _AMR0
cdef int _RM, _SM, _RBS, _DOS, _TBS, _RS, _TS, _EI, _WUI, _CDR_PELICAN, _CONTROL
cdef int _RECOVERY_GROUPS

cdef class Modes(BusSide):
    cdef public long long oscillator_hz
    cdef public double oscillator_ppm
    cdef public int power_up_cdr
    cdef public object transceiver
    cdef public unsigned long long asleep_from_ns
    cdef bytearray _reads, _writes
    cdef bint _resetting, _forced_off, _told_off

    cpdef hardware_reset(self)
    cpdef pull_interrupt(self)
    cdef void _sleep(self) except *
    cdef int _wake(self) except -1
    cdef int _leave_bus(self) except -1
    @cython.locals(tec=int)
    cdef int _enter_reset(self) except -1
    cdef void _leave_reset(self) except *
    @cython.locals(cells=bytearray)
    cdef int _take_settings(self) except -1
    @cython.locals(pelican=bint)
    cdef int _look(self) except -1
    cdef int _wait(self, int groups, int seen) except -1
    cdef unsigned long long _now_ns(self) except? 0
    @cython.locals(left=int)
    cdef int _txerr(self) except -1
    cdef int _enable(self) except -1
