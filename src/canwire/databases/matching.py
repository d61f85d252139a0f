"""Finds the message of a frame: by its exact identifier, or by its PGN if the file marks it as J1939."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from canwire.databases.description import MessageDescription

if TYPE_CHECKING:
    import numpy

EXTENDED_KEY = 1 << 31  # of a key, beside its identifier
_EXACT = (1 << 32) - 1
_NO_PRIORITY = EXTENDED_KEY | 0x03FF_FFFF
_PDU2 = EXTENDED_KEY | 0x03FF_FF00  # the group extension counts
_PDU1 = EXTENDED_KEY | 0x03FF_0000  # the destination does not


class Stage(NamedTuple):
    """Messages by the bits of their keys that are 1 in `mask`."""

    mask: int
    numbers: dict[int, int]


def key_of(id: int, extended: bool) -> int:
    """Identifier and format in one number of 32 bits."""
    return id | EXTENDED_KEY if extended else id


def match_mask(message: MessageDescription) -> int:
    """The fewest bits of a key that identify the message."""
    if not message.j1939:
        return _EXACT
    return _PDU2 if message.id >> 16 & 0xFF >= 240 else _PDU1


class Matching:
    """Finds the message of a frame: its number in `messages`, -1 for none.

    It tries the exact identifier first, then the identifier of J1939 without the priority, then the PGN. If several
    messages have one identifier, the last in the file counts, as with cantools; if several have one PGN, the first.
    """

    def __init__(self, messages: Sequence[MessageDescription]) -> None:
        stages = {mask: Stage(mask, {}) for mask in (_EXACT, _NO_PRIORITY, _PDU2, _PDU1)}
        for number, message in enumerate(messages):
            widest = match_mask(message)
            for mask in (_EXACT, _NO_PRIORITY, widest) if message.j1939 else (_EXACT,):
                key = key_of(message.id, message.extended) & mask
                if mask == _EXACT:
                    stages[mask].numbers[key] = number
                else:
                    stages[mask].numbers.setdefault(key, number)
        self._stages = [stage for stage in stages.values() if stage.numbers]

    def find(self, key: int) -> int:
        """The number of the message with this key."""
        for mask, numbers in self._stages:
            found = numbers.get(key & mask, -1)
            if found >= 0:
                return found
        return -1

    def find_array(self, keys: numpy.ndarray) -> numpy.ndarray:
        """The numbers of the messages with these keys (uint32), as int32."""
        import numpy

        found = numpy.full(len(keys), -1, numpy.int32)
        for mask, numbers in self._stages:
            known = numpy.array(sorted(numbers), numpy.uint32)
            values = numpy.array([numbers[key] for key in known.tolist()], numpy.int32)
            masked = keys & numpy.uint32(mask)
            places = numpy.minimum(numpy.searchsorted(known, masked), len(known) - 1)
            met = (known[places] == masked) & (found < 0)
            found[met] = values[places[met]]
        return found
