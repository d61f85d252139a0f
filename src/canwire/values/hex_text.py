"""Hex digits in lines of bytes, as ordinary Python; `hex_text.pxd` is its compiled twin, function by function."""

from __future__ import annotations

from binascii import Error, unhexlify

NO_DIGIT = 16


def digit(character: int) -> int:
    """The value of a hex digit, 0..15; NO_DIGIT for other characters."""
    if 48 <= character <= 57:
        return character - 48
    character |= 32
    if 97 <= character <= 102:
        return character - 87
    return NO_DIGIT


def octets_of(text: bytes, at: int, end: int) -> bytes | None:
    """The bytes of the pairs of digits from `at` to `end`; None if another character is among them."""
    try:
        return unhexlify(text[at:end])
    except Error:
        return None


def line_end(text: bytes, start: int) -> int:
    """Where the next CR is; -1 if there is none."""
    return text.find(b"\r", start)
