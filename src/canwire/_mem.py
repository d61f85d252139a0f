"""Memory below the rings, as ordinary Python; `_mem.pxd` is its compiled twin, function by function.

`words` is a block of 64-bit little-endian words: here a memoryview, compiled a pointer. The
caller keeps the buffer alive for as long as it uses the words.
"""

from __future__ import annotations

from operator import getitem, setitem
from typing import Any

Words = Any  # memoryview of format Q here, unsigned long long* compiled


def words_of(buffer: Any) -> Words:
    return memoryview(buffer).cast("B").cast("Q")


def copy_record(target: Words, at: int, source: Words, source_at: int) -> None:
    target[at : at + 10] = source[source_at : source_at + 10]


def data_of(words: Words, at: int, length: int) -> bytes:
    """`length` bytes that start with word `at`."""
    return words[at : at + 8].tobytes()[:length]


def same_data(words: Words, at: int, data: bytes) -> bool:
    """Whether `data` are the bytes that start with word `at`."""
    return words[at : at + 8].tobytes()[: len(data)] == data


def store_data(words: Words, at: int, data: bytes) -> None:
    """Fill the eight words from `at` with up to 64 bytes, then zeros."""
    words[at : at + 8] = memoryview(data.ljust(64, b"\0")).cast("Q")


def clear_tail(words: Words, at: int, length: int) -> None:
    """Zero the bytes after the first `length` of the 64 bytes that start with word `at`."""
    data = words[at : at + 8].tobytes()[:length].ljust(64, b"\0")
    words[at : at + 8] = memoryview(data).cast("Q")


load_acquire = getitem  # (words, at)
store_release = setitem  # (words, at, value)


def fence() -> None:
    """Order a store before a later load. Python cannot, so its waiters re-check on a timeout."""


def whole(number: object) -> int:
    """A whole number from 0 to 2**63 - 1 as it is, anything else as -1."""
    return number if isinstance(number, int) and 0 <= number < 1 << 63 else -1


def shorts_of(buffer: Any) -> Any:
    """A table of 16-bit numbers that nobody changes: a list, whose items are read more quickly."""
    return memoryview(buffer).cast("B").cast("H").tolist()
