# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
from cpython.bytes cimport PyBytes_FromStringAndSize
from libc.string cimport memchr

cdef enum:
    NO_DIGIT = 16


# Without branches: which digit comes next cannot be predicted.
cdef inline int digit(unsigned int character) noexcept nogil:
    cdef unsigned int letter = (character | 32) - 97
    cdef bint is_digit = character - 48 < 10
    cdef bint is_letter = letter < 6
    return (character - 48) * is_digit + (letter + 10) * is_letter + NO_DIGIT * (1 - is_digit - is_letter)


cdef inline bytes octets_of(bytes text, Py_ssize_t at, Py_ssize_t end):
    cdef const unsigned char *digits = <const unsigned char *> (<const char *> text) + at
    cdef Py_ssize_t k, length = (end - at) >> 1
    cdef bytes found = PyBytes_FromStringAndSize(NULL, length)
    cdef unsigned char *octets = <unsigned char *> (<char *> found)
    cdef int high, low, seen = 0
    if length << 1 != end - at:
        return None
    for k in range(length):
        high, low = digit(digits[2 * k]), digit(digits[2 * k + 1])
        seen |= high | low
        octets[k] = <unsigned char> (high << 4 | low)
    return None if seen & NO_DIGIT else found


cdef inline Py_ssize_t line_end(bytes text, Py_ssize_t start) noexcept:
    cdef const char *characters = text
    cdef const void *found = NULL
    if start < len(text):
        found = memchr(characters + start, 13, len(text) - start)
    return -1 if found == NULL else <const char *> found - characters
