# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can.node cimport Mailbox

cdef const unsigned int _EXTENDED, _REMOTE, _FD, _BIT_RATE_SWITCH, _ERROR_STATE
cdef const unsigned long long _ESI_WORD
cdef const int _NON_ISO, _TAIL_BITS
cdef const unsigned int _IDLE, _STATE
cdef const unsigned int _BEFORE_39, _BEFORE_36, _BEFORE_19, _BEFORE_17
cdef unsigned short *_CRC15
cdef unsigned short *_NEXT
cdef unsigned short *_INSERTED
cdef unsigned short *_NEXT5
cdef unsigned short *_INSERTED5
cdef unsigned short *_LENGTHS

@cython.locals(head="unsigned long long", info="unsigned int", identifier="unsigned int", remote="unsigned int")
cpdef void measure(Mailbox box, int fd_mode) noexcept

@cython.locals(shown=bint)
cdef void show_error_state(Mailbox box, bint passive, int fd_mode) noexcept

@cython.locals(info="unsigned int", identifier="unsigned long long", dlc="unsigned int", remote="unsigned int",
               after="unsigned long long", header="unsigned long long", bits=int, state="unsigned long long",
               at="unsigned long long", crc="unsigned int", data="unsigned long long", byte="unsigned long long")
cdef int _measure_classic(unsigned long long *words, unsigned long long head) noexcept nogil

@cython.locals(at="unsigned long long", count="unsigned int")
cdef inline unsigned int _stuffed(unsigned long long state, unsigned long long data, int length) noexcept nogil

@cython.locals(words="unsigned long long *", info="unsigned int", identifier="unsigned long long", dlc="unsigned int",
               left=int, switch="unsigned int", header="unsigned long long", bits=int, step="unsigned int",
               state="unsigned long long", guess="unsigned long long", at="unsigned long long", nominal=int,
               data="unsigned long long")
cdef void _measure_fd(Mailbox box, unsigned long long head, int fd_mode) noexcept
