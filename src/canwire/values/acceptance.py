"""Acceptance filters: which frames a receiver accepts, in one form that the core can match quickly.

A frame becomes a 64-bit key, a filter a list of (code, mask) pairs over it:

    bit 63      extended
    bit 47, 46  data byte 1, data byte 0 does not exist (the frame is shorter, or remote)
    bits 45..17 identifier, right-aligned: an 11-bit one lies in bits 27..17
    bit 16      remote
    bits 15..8  data byte 0, 0 where it does not exist
    bits 7..0   data byte 1, likewise

Every vendor's registers are turned into that form: see acceptance_orders.py.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from canwire.errors import BadFilter
from canwire.values.checks import shown
from canwire.values.frame import Frame

KEY_EXTENDED = 1 << 63
KEY_NO_BYTE_1 = 1 << 47
KEY_NO_BYTE_0 = 1 << 46
KEY_ID_SHIFT = 17
KEY_REMOTE = 1 << 16
KEY_BITS = (1 << 64) - 1
LIST_EXTENDED = 1 << 31


def frame_key(frame: Frame) -> int:
    """The 64-bit key described above."""
    key = frame.id << KEY_ID_SHIFT
    if frame.extended:
        key |= KEY_EXTENDED
    if frame.remote:
        return key | KEY_REMOTE | KEY_NO_BYTE_0 | KEY_NO_BYTE_1
    data = frame.data
    if len(data) >= 2:
        return key | data[0] << 8 | data[1]
    if data:
        return key | data[0] << 8 | KEY_NO_BYTE_1
    return key | KEY_NO_BYTE_0 | KEY_NO_BYTE_1


def list_key(frame: Frame) -> int:
    """The frame's place in an identifier list: id << 1 | remote, bit 31 for extended."""
    return frame.id << 1 | frame.remote | frame.extended << 31


@dataclass(frozen=True, slots=True)
class Acceptance:
    """Frames whose key agrees with a pair in all its mask bits, or whose list key is listed.

    Pairs are (code, mask) over the key above; a mask bit of 1 must match. `a | b` accepts the
    frames that either accepts. Raises BadFilter if a number is no key.
    """

    pairs: tuple[tuple[int, int], ...]
    identifiers: frozenset[int] = frozenset()

    def __post_init__(self) -> None:
        if not isinstance(self.pairs, tuple) or not all(
            isinstance(pair, tuple) and len(pair) == 2 for pair in self.pairs
        ):
            raise BadFilter(
                f"pairs {shown(self.pairs)}: a tuple of (code, mask) over 64-bit keys; "
                "of identifiers Acceptance.from_filters([(0x120, 0x7F0)]) makes one"
            )
        for code, mask in self.pairs:
            if not 0 <= code <= KEY_BITS or not 0 <= mask <= KEY_BITS:
                raise BadFilter(f"pair {code:#x}/{mask:#x}: keys have 64 bits")
        for listed in self.identifiers:
            if not 0 <= listed < 1 << 32:
                raise BadFilter(f"list key {listed:#x}: 32 bits at most")

    def accepts(self, frame: Frame) -> bool:
        """Whether the filter accepts the frame."""
        key = frame_key(frame)
        for code, mask in self.pairs:
            if not (key ^ code) & mask:
                return True
        return bool(self.identifiers) and list_key(frame) in self.identifiers

    def __or__(self, other: Acceptance) -> Acceptance:
        if not isinstance(other, Acceptance):
            return NotImplemented
        pairs = dict.fromkeys(self.pairs + other.pairs)  # keeps the order, drops the repeated
        return Acceptance(tuple(pairs), self.identifiers | other.identifiers)

    @classmethod
    def everything(cls) -> Acceptance:
        """A filter that accepts every frame."""
        return cls(((0, 0),))

    @classmethod
    def nothing(cls) -> Acceptance:
        """No frame passes."""
        return cls(())

    @classmethod
    def from_filters(cls, filters: Iterable[Sequence[int]]) -> Acceptance:
        """Filters of the lab: (code, mask) for 11-bit frames, (code, mask, True) for 29-bit ones.

        A mask bit of 1 must match; the filters accept data and remote frames; an empty list accepts
        no frames. Raises BadFilter with the invalid filter.

        >>> Acceptance.from_filters([(0x120, 0x7F8)]).accepts(Frame(0x127))
        True
        """
        if not isinstance(filters, Iterable):
            raise BadFilter(
                f"filters {shown(filters)}: give a list of (code, mask), such as [(0x120, 0x7F0)]"
            )
        return cls(tuple(_pair_of_filter(entry) for entry in filters))

    @classmethod
    def identifier_list(cls, codes: Iterable[int], *, extended: bool) -> Acceptance:
        """Exactly these frames; a code is id << 1 | remote, as in VCI's lists.

        Source: VCI V4 manual 5.2.4. Raises BadFilter if a code has too many bits.
        """
        width = 30 if extended else 12
        marked = LIST_EXTENDED if extended else 0
        return cls((), frozenset(checked("code", code, width) | marked for code in codes))


def checked(name: str, value: object, bits: int) -> int:
    """Return the value if it is a whole number of `bits` bits; raises BadFilter with its name otherwise."""
    if not isinstance(value, int) or value < 0 or value >> bits:
        shown = f"{value:#x}" if isinstance(value, int) else repr(value)
        raise BadFilter(f"{name} {shown}: a whole number of {bits} bits")
    return value


def id_pair(code: int, mask: int, *, extended: bool, remote: tuple[int, int] = (0, 0)) -> tuple[int, int]:
    """The pair that compares identifier bits, right-aligned, in one frame format.

    `remote` is (code, mask) for the RTR bit; data is not compared.
    """
    code_key = code << KEY_ID_SHIFT | (KEY_EXTENDED if extended else 0) | remote[0] << 16
    return code_key, mask << KEY_ID_SHIFT | KEY_EXTENDED | remote[1] << 16


def _pair_of_filter(entry: Sequence[int]) -> tuple[int, int]:
    if isinstance(entry, (str, bytes)) or not isinstance(entry, Sequence) or not 2 <= len(entry) <= 3:
        raise BadFilter(f"filter {entry!r}: give (code, mask), or (code, mask, True) for 29-bit frames")
    extended = len(entry) == 3 and bool(entry[2])
    width = 29 if extended else 11
    try:
        code, mask = checked("code", entry[0], width), checked("mask", entry[1], width)
    except BadFilter as error:
        hint = "" if extended else "; add True as third for 29-bit frames"
        raise BadFilter(f"filter {entry!r}: {error}{hint}") from None
    return id_pair(code, mask, extended=extended)
