# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem
from canwire.bus.can.node cimport Mailbox

cdef const unsigned int _EXTENDED, _REMOTE, _FD, _BIT_RATE_SWITCH, _ERROR_STATE
cdef const unsigned long long _ESI_WORD
cdef const int _NON_ISO, _TAIL_BITS, _START_STATE
cdef unsigned short *_CRC15
cdef unsigned short *_STUFF1
cdef unsigned short *_STUFF3
cdef unsigned short *_STUFF4
cdef unsigned short *_STUFF5
cdef unsigned short *_STUFF7
cdef unsigned short *_STUFF8
cdef unsigned short *_LENGTHS

@cython.locals(head="unsigned long long", info="unsigned int", identifier="unsigned int", remote="unsigned int")
cpdef void measure(Mailbox box, int fd_mode) noexcept

@cython.locals(shown=bint)
cdef void show_error_state(Mailbox box, bint passive, int fd_mode) noexcept

@cython.locals(info="unsigned int", identifier="unsigned long long", dlc="unsigned int", remote="unsigned int",
               length=Py_ssize_t, table="unsigned short *", crc_table="unsigned short *", header="unsigned long long",
               bits=int, step="unsigned int", count=int, crc="unsigned int", data="unsigned long long")
cdef int _measure_classic(unsigned long long *words, unsigned long long head) noexcept nogil

@cython.locals(words="unsigned long long *", info="unsigned int", identifier="unsigned long long", dlc="unsigned int",
               length=int, switch="unsigned int", table="unsigned short *", header="unsigned long long", bits=int,
               step="unsigned int", count=int, nominal=int, at=int, left=int, data="unsigned long long",
               crc_field=int, _=int)
cdef void _measure_fd(Mailbox box, unsigned long long head, int fd_mode) noexcept
