"""The transmitter of a LIN node, bit by bit: it puts levels on the wire and reads each back."""

from __future__ import annotations

from collections.abc import Sequence

from canwire.bus.lin.bits import BREAK, DATA, PID, SYNC, Field
from canwire.timeline import NEVER
from canwire.values.lin.event import LinErrorKind

_READ_BACK = (PID, DATA)


class LinSender:
    """Sends fields one after the other. `out` is the level it drives, `due_ps` when it acts next.

    A level that is read back wrong ends the transmission: immediately in break and sync field (the wire is shorted, or
    another master drives it), else at the end of the byte. `failure` is the LinErrorKind, `failed_now` is true until it
    has been handled. `flips` are the bits (field, bit) that a disturbance inverts on the wire.
    """

    def __init__(self) -> None:
        self.out = 1
        self.due_ps = NEVER
        self.active = False
        self.failure = LinErrorKind.NONE
        self.flips: frozenset[tuple[int, int]] = frozenset()
        self.flipping = False
        self._fields: Sequence[Field] = ()
        self._bit_ps = 0
        self._start_ps = 0
        self._field = 0
        self._bit = 0
        self._checking = False

    def start(
        self,
        fields: Sequence[Field],
        bit_ps: int,
        at_ps: int,
        flips: frozenset[tuple[int, int]] = frozenset(),
    ) -> None:
        """Send these fields from `at_ps` on; a call of `act` at that time drives the first level."""
        self._fields = fields
        self._bit_ps = bit_ps
        self._start_ps = self.due_ps = at_ps
        self._field = self._bit = 0
        self._checking = False
        self.failure = LinErrorKind.NONE
        self.flips = flips
        self.active = True

    def stop(self) -> None:
        """Stop driving the wire."""
        self.out = 1
        self.due_ps = NEVER
        self.active = self.flipping = False

    def act(self, wire: int) -> bool:
        """Drive the next bit, or read it back, whichever is due; True when all fields were sent."""
        if self._checking:
            self._check(wire)
            return False
        if self._bit == len(self._fields[self._field].levels):
            return self._next_field()
        self._drive()
        return False

    def _drive(self) -> None:
        self.out = self._fields[self._field].levels[self._bit]
        self.flipping = (self._field, self._bit) in self.flips
        self._checking = True
        self.due_ps = self._start_ps + (2 * self._bit + 1) * self._bit_ps // 2

    def _check(self, wire: int) -> None:
        self._checking = False
        self._bit += 1
        self.due_ps = self._start_ps + self._bit * self._bit_ps
        if wire == self.out:
            return
        kind = self._fields[self._field].kind
        if kind in (BREAK, SYNC):
            self.failure = LinErrorKind.NOBUS
            self.stop()
        elif kind in _READ_BACK:
            self.failure = LinErrorKind.BIT

    def _next_field(self) -> bool:
        self._start_ps += self._bit * self._bit_ps
        self._bit = 0
        self._field += 1
        if self.failure is LinErrorKind.NONE and self._field < len(self._fields):
            self._drive()
            return False
        self.stop()
        return True
