"""Drivers that find things out by themselves: they keep time, count, and tell their host; with interrupts or without.

The ideal controller (can_fd.py) tells its host itself, frame by frame in the compiled core, and needs none of this.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.bus.can.node import Mailbox
from canwire.drivers.driver import Counters, Driver
from canwire.values.event import ErrorKind, ErrorState, EventKind

if TYPE_CHECKING:
    from canwire.chips.host import Host

_PASSES = 20  # through a chip's interrupts in one go; the next interrupt takes up the rest


class ReportingDriver(Driver):
    """One mailbox unless the driver says otherwise. `now` tells the time in ns; `_incoming` is for a frame received."""

    def __init__(self, host: Host | None, now: Callable[[], int]) -> None:
        box = Mailbox()
        super().__init__(host, box, box)
        self._now = now
        self._incoming = Mailbox()
        self._errors = self._losses = self._sent = self._received = self._last_error = 0

    def counted(self, tec: int, rec: int, state: ErrorState) -> Counters:
        """These, with what was counted here."""
        return Counters(
            tec, rec, state, self._errors, self._losses, self._sent, self._received, self._last_error
        )

    def bus_error(self, kind: ErrorKind, *, bit: int = -1, transmitting: bool = False, code: int = 0) -> None:
        """Count an error on the bus, and tell."""
        self._errors += 1
        self._last_error = int(kind)
        self.tell(EventKind.ERROR, kind, bit=bit, transmitting=transmitting, code=code)

    def arbitration_lost(self, bit: int = -1, *, transmitting: bool = True) -> None:
        """Count it, and tell."""
        self._losses += 1
        self.tell(EventKind.ARBITRATION_LOST, bit=bit, transmitting=transmitting)

    def over(self, box: Mailbox, delivered: bool) -> None:
        """The frame in this mailbox went through, or was given up: count it, and `settle`."""
        self._sent += delivered
        self.settle(box, delivered, self._now())

    def fill(self) -> None:
        """A mailbox may be free."""
        if self.host is not None:
            self.host.fill(self._now())

    def tell(
        self,
        kind: EventKind,
        error: ErrorKind = ErrorKind.NONE,
        *,
        bit: int = -1,
        transmitting: bool = False,
        code: int = 0,
    ) -> None:
        if self.host is not None:
            self.host.event(int(kind), int(error), bit, transmitting, self._now(), code)


class ChipDriver(ReportingDriver):
    """One whose chip has registers and interrupts. Whoever wires the chip's INT calls `service`.

    `read` reads a register. How chips start, stop, sleep and wake only looks alike: which registers are touched, and
    in what order, is each chip's own.
    """

    _pending: Callable[[], int]  # the chip's interrupts that wait to be served; 0: none

    def __init__(self, host: Host | None, now: Callable[[], int], read: Callable[[int], int]) -> None:
        super().__init__(host, now)
        self._read = read
        self._transmits = False  # the chip can be told to send: it takes part, or will soon
        self._state = ErrorState.ERROR_ACTIVE
        self._servicing = self._held = self._asleep = False

    def hold(self, held: bool) -> None:
        self._held = held
        self.service()

    def service(self) -> None:
        """Serve the chip's interrupts until there are none; safe to call when there are none."""
        if self._servicing or self._held:
            return  # the loop below looks again, or `hold` does
        self._servicing = True
        try:
            for _ in range(_PASSES):
                interrupts = self._pending()
                if not interrupts:
                    break
                self._serve(interrupts)
        finally:
            self._servicing = False

    def _serve(self, interrupts: int) -> None:
        """What is to be done about these."""
        raise NotImplementedError
