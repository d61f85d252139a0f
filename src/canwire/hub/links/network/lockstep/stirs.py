"""The number of times that a program's other threads were woken to check again, on its way to the hub. No I/O.

Only the latest number counts, so nothing is kept: the next number replaces one that the network drops.
"""

from __future__ import annotations

from collections.abc import Callable

from canwire.errors import BadMessage
from canwire.hub.links.network import wire
from canwire.hub.links.network.wire import Report


class OutgoingStirs:
    """The program's end."""

    number = wire.STIRS

    def __init__(self) -> None:
        self.written = self.sent = self._received = 0

    def stir(self) -> None:
        """Count a wake-up, from any thread, without a lock: two at the same time may count as one."""
        self.written += 1

    @property
    def unconfirmed(self) -> bool:
        return self.sent != self._received

    def batches(self, now_ns: int, *, at_once: bool = False) -> list[bytes]:
        """A payload with the number, if it is new."""
        written = self.written
        if written == self.sent:
            return []
        self.sent = written
        return [wire.frames(self.number, written - 1, memoryview(b""))]

    def acknowledge(self, report: Report) -> None:
        """The hub has received this number."""
        if report.received > self.written:
            raise BadMessage(f"{report} of {self.written} stirs")
        self._received = max(self._received, report.received)
        if report.again:
            self.sent = self._received

    def arm(self, now_ns: int) -> int | None:
        return None

    def close(self) -> None:
        """Do nothing: there is nothing to release."""


class IncomingStirs:
    """The hub's end: `stir` is called for each number that is new, and must not wait."""

    number = wire.STIRS

    def __init__(self, stir: Callable[[], object]) -> None:
        self._stir = stir
        self._asked = self._missing = False
        self.received = 0

    def accept(self, first: int, records: memoryview) -> bool:
        self._asked = True
        if first >= self.received:
            self._stir()  # before its arrival becomes visible
            self.received = first + 1
        return True

    def sent(self, position: int) -> None:
        """The other end has sent up to this number, and requests a report."""
        self._asked = True
        self._missing |= position > self.received

    def report(self, now_ns: int, *, at_once: bool = False) -> Report | None:
        """The report to send now."""
        if not (self._asked or self._missing):
            return None
        made = Report(self.number, self.received, self.received, self._missing)
        self._asked = self._missing = False
        return made

    def arm(self, now_ns: int) -> int | None:
        return None

    def close(self) -> None:
        """Do nothing: there is nothing to release."""
