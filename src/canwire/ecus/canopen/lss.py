"""The slave side of LSS, which assigns node-IDs to the devices on a bus: requests in, answers out.

Source: CiA 305 (Layer setting services and protocols): switch state, configure, inquire and identify services.
"""

from __future__ import annotations

from collections.abc import Callable

REQUESTS, ANSWERS = 0x7E5, 0x7E4
_GLOBAL, _CONFIGURE_ID, _CONFIGURE_TIMING, _STORE = 0x04, 0x11, 0x13, 0x17
_SELECTIVE, _SELECTED = range(0x40, 0x44), 0x44  # vendor, product, revision, serial number
_IDENTIFY, _IDENTIFIED = range(0x46, 0x4C), 0x4F  # vendor, product, then both ends of the other two
_INQUIRE, _INQUIRE_ID = range(0x5A, 0x5E), 0x5E
_DONE, _REFUSED = 0, 1
_HIGHEST_ID = 127


class LssSlave:
    """`identity` returns the four numbers of object 1018h, `id` the node-ID.

    `pending` is the node-ID that takes effect at the next reset of the communication, `stored` the one at the next
    reset of the node. Requests to change the bus's bit rate are refused. Fast scans are ignored: they find devices
    without a node-ID, and this device always has one.
    """

    def __init__(self, identity: Callable[[], list[int]], id: int) -> None:
        self.id = self.pending = self.stored = id
        self.configuring = False
        self._identity = identity
        self._met: dict[range, int] = {}  # so many numbers of a row have fitted, one after the other

    def answer(self, request: bytes) -> bytes | None:
        """Return the response to an LSS request, eight bytes, or None for no response."""
        code, number = request[0], int.from_bytes(request[1:5], "little")
        found: bytes | None = None
        if code == _GLOBAL:
            self.configuring = request[1] == 1
        elif code in _SELECTIVE:
            found = self._selected(code, number)
        elif code in _IDENTIFY:
            found = self._identified(code, number)
        elif self.configuring:
            found = self._configured(code, request[1])
        return None if found is None else found.ljust(8, b"\0")

    def _selected(self, code: int, number: int) -> bytes | None:
        place = code - _SELECTIVE.start
        if self._all_met(_SELECTIVE, place, self._identity()[place] == number):
            self.configuring = True
            return bytes([_SELECTED])
        return None

    def _identified(self, code: int, number: int) -> bytes | None:
        place = code - _IDENTIFY.start
        vendor, product, revision, serial = self._identity()
        fits = (
            vendor == number,
            product == number,
            revision >= number,
            revision <= number,
            serial >= number,
            serial <= number,
        )
        return bytes([_IDENTIFIED]) if self._all_met(_IDENTIFY, place, fits[place]) else None

    def _all_met(self, row: range, place: int, fits: bool) -> bool:
        """Whether this request completes a sequence in which every request has matched."""
        before = self._met.get(row, 0)
        self._met[row] = place + 1 if fits and place == (before if place else 0) else 0
        return self._met[row] == len(row)

    def _configured(self, code: int, value: int) -> bytes | None:
        if code in _INQUIRE:
            return bytes([code]) + self._identity()[code - _INQUIRE.start].to_bytes(4, "little")
        if code == _INQUIRE_ID:
            return bytes([code, self.id])
        if code == _CONFIGURE_ID:
            fits = 1 <= value <= _HIGHEST_ID
            self.pending = value if fits else self.pending
            return bytes([code, _DONE if fits else _REFUSED])
        if code == _STORE:
            self.stored = self.pending
            return bytes([code, _DONE])
        return bytes([code, _REFUSED]) if code == _CONFIGURE_TIMING else None
