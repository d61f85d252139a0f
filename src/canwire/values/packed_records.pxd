# cython: boundscheck=False, wraparound=False, initializedcheck=False, cdivision=True
cimport cython
from canwire cimport _mem

cdef int _SIZE, _WORDS, _HEAD, _SMALLEST, _LARGEST, _COARSE_NS, _INFO, _LONG, _EXPLICIT, _BACK, _CODE, _DLC_SHIFT
cdef int _MOST_CLASSIC, _MOST, _LONGEST_NUMBER, _NOWHERE
cdef unsigned int _FD
cdef bytes _LENGTHS
cdef unsigned long long _M32, _M64, _TOP

@cython.locals(words="unsigned long long *", count=Py_ssize_t, room=bytearray, unit="unsigned long long", at=Py_ssize_t,
               before="unsigned long long", before_info="unsigned int", k=Py_ssize_t, first=Py_ssize_t,
               info="unsigned int")
cpdef bytes pack(bytearray records)

@cython.locals(size=Py_ssize_t, count=Py_ssize_t, unit="unsigned long long", padded=bytes, records=bytearray,
               words="unsigned long long *", at=Py_ssize_t, before="unsigned long long", info="unsigned int",
               k=Py_ssize_t)
cpdef bytearray unpack(bytes packed)

@cython.locals(k=Py_ssize_t)
cdef unsigned long long _unit(unsigned long long *words, Py_ssize_t count) noexcept

@cython.locals(apart="unsigned long long")
cdef unsigned long long _apart(unsigned long long stamp, unsigned long long before) noexcept

@cython.locals(_=int)
cdef Py_ssize_t _put(bytearray room, Py_ssize_t at, unsigned long long value, Py_ssize_t size) noexcept

@cython.locals(value="unsigned long long")
cdef unsigned long long _get(bytes packed, Py_ssize_t at, Py_ssize_t size) noexcept

@cython.locals(identifier="unsigned long long", info="unsigned int", code=int, rest="unsigned int", length=int, used=int,
               mark=int, word=Py_ssize_t)
cdef Py_ssize_t _put_record(bytearray room, Py_ssize_t at, unsigned long long *words, Py_ssize_t first,
                            unsigned long long apart, unsigned long long before, unsigned int before_info) noexcept

@cython.locals(apart="unsigned long long", part="unsigned long long", shift=int, mark=int, size=int, code=int, length=int, word=Py_ssize_t)
cdef Py_ssize_t _get_record(bytes packed, Py_ssize_t at, unsigned long long *words, Py_ssize_t first,
                            unsigned long long before, unsigned long long unit,
                            unsigned long long info) noexcept

cdef int _implied(unsigned int info, int code) noexcept

@cython.locals(word=int, used=int, value="unsigned long long")
cdef int _used(unsigned long long *words, Py_ssize_t first) noexcept
