"""Base classes of drivers that count frames and errors and report them to their host, with or without interrupts.

The ideal controller (can_fd.py) reports to its host in the compiled core, and needs none of this.
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
    """A driver with one mailbox by default. `now` returns the time in ns; `_incoming` is for a received frame."""

    def __init__(self, host: Host | None, now: Callable[[], int]) -> None:
        box = Mailbox()
        super().__init__(host, box, box)
        self._now = now
        self._incoming = Mailbox()
        self._errors = self._losses = self._sent = self._received = self._last_error = 0

    def counted(self, tec: int, rec: int, state: ErrorState) -> Counters:
        """Counters with these values and with what this driver has counted."""
        return Counters(
            tec, rec, state, self._errors, self._losses, self._sent, self._received, self._last_error
        )

    def bus_error(self, kind: ErrorKind, *, bit: int = -1, transmitting: bool = False, code: int = 0) -> None:
        """Count an error on the bus, and report it to the host."""
        self._errors += 1
        self._last_error = int(kind)
        self.tell(EventKind.ERROR, kind, bit=bit, transmitting=transmitting, code=code)

    def arbitration_lost(self, bit: int = -1, *, transmitting: bool = True) -> None:
        """Count a lost arbitration, and report it to the host."""
        self._losses += 1
        self.tell(EventKind.ARBITRATION_LOST, bit=bit, transmitting=transmitting)

    def over(self, box: Mailbox, delivered: bool) -> None:
        """The frame in this mailbox was delivered or aborted: count it, and `settle`."""
        self._sent += delivered
        self.settle(box, delivered, self._now())

    def fill(self) -> None:
        """Ask the host for the next frame: a mailbox may be free."""
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
    """The driver of a chip with registers and interrupts. Code that connects the chip's INT pin calls `service`.

    `read` reads a register. Starting, stopping, sleeping and waking are left to each chip's driver, since chips differ
    in the registers for that and in their order.
    """

    _pending: Callable[[], int]  # the chip's interrupts that wait to be served; 0: none

    def __init__(self, host: Host | None, now: Callable[[], int], read: Callable[[int], int]) -> None:
        super().__init__(host, now)
        self._read = read
        self._transmits = False  # the chip accepts requests to send: it takes part, or will soon
        self._state = ErrorState.ERROR_ACTIVE
        self._servicing = self._held = self._asleep = False

    def hold(self, held: bool) -> None:
        self._held = held
        self.service()

    def service(self) -> None:
        """Serve the chip's interrupts until none is left; safe to call without any."""
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
