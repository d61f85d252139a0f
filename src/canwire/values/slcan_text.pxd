# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire.values cimport frame as codec
from canwire.values cimport hex_text
from canwire.values.frame cimport Frame

cdef int _LONGEST, _DLC_SHIFT
cdef unsigned int _EXTENDED, _REMOTE, _FD, _BIT_RATE_SWITCH, _LARGEST_STANDARD, _LARGEST_EXTENDED
cdef bytes _LENGTHS

cdef int decimal_code(bytes text, Py_ssize_t at, Py_ssize_t end, int tens) except -1

@cython.final
cdef class SlcanReader:
    cdef readonly bint fd
    cdef readonly long long dropped
    cdef bytes _rest

    @cython.locals(text=bytes, found=list, start=Py_ssize_t, end=Py_ssize_t, kept=Py_ssize_t)
    cpdef list feed(self, object data)
    @cython.locals(frame=Frame)
    cdef object _line(self, bytes text, Py_ssize_t start, Py_ssize_t end)
    @cython.locals(info="unsigned int", at=Py_ssize_t, digits=int, identifier="unsigned int", value=int, k=Py_ssize_t,
                   code=int, data=bytes)
    cdef Frame _frame(self, bytes text, Py_ssize_t start, Py_ssize_t end)
    cdef unsigned int _kind(self, int letter) noexcept
    @cython.locals(code=int)
    cdef Frame _remote(self, bytes text, Py_ssize_t at, Py_ssize_t end, unsigned int identifier, unsigned int info)

@cython.locals(info="unsigned int", code=int, letter=int, head=bytes)
cpdef bytes format_slcan_frame(Frame frame, object stamp=*)
