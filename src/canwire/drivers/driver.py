"""The seam between a line and whatever makes its controller send and receive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from canwire import _mem
from canwire.bus.node import Mailbox, Sink
from canwire.values.bit_timing import BitTiming
from canwire.values.event import ErrorState
from canwire.values.register import RegisterValue

if TYPE_CHECKING:
    from canwire.chips.host import Host

_SINGLE_SHOT = 1 << 8
_HIGH_PRIORITY = 1 << 9
_ABORT_ON_ERROR = 1 << 14


@dataclass(frozen=True, slots=True)
class LineSettings:
    """How a line takes part in its bus.

    `data_timing` None means a classic line. `oscillator_ppm` is how far the node's crystal is off
    (positive: fast), -100,000..100,000. `registers` are values for registers of the chip by their data-sheet
    names, beyond what the other settings say; an ideal controller has none.
    """

    timing: BitTiming
    data_timing: BitTiming | None = None
    iso_fd: bool = True
    listen_only: bool = False
    oscillator_ppm: float = 0.0
    registers: tuple[tuple[str, int], ...] = ()


@dataclass(frozen=True, slots=True)
class Counters:
    """What a controller counts; `tec` is held at 256 in bus-off, `last_error` is an ErrorKind."""

    tec: int
    rec: int
    state: ErrorState
    errors: int
    arbitration_losses: int
    frames_sent: int
    frames_received: int
    last_error: int = 0


class Driver:
    """Makes one controller take part in its bus, and hands frames to and fro between it and its host, a line.

    A controller has a mailbox for frames and perhaps another, `high`, that goes before it (else both are the same
    one). `running`, `listen_only` and `fd` (as Node.fd) say how it takes part. Times are the timeline's, in
    nanoseconds. `configure` before `start`; a second one takes effect at once, mid-frame if need be. `stop` and
    `close` may be called again and again.
    """

    def __init__(self, host: Host | None, normal: Mailbox, high: Mailbox) -> None:
        self.host = host
        self.normal = normal
        self.high = high
        self.running = False
        self.listen_only = False
        self.fd = 0

    def configure(self, settings: LineSettings) -> None:
        """Set timing and mode; raises BadTiming for what the controller cannot do."""
        raise NotImplementedError

    def forget(self) -> None:
        """What it was set up for no longer holds; the controller is stopped."""
        self.listen_only = False
        self.fd = 0

    def start(self, at_ns: int, integrated: bool = False) -> None:
        """Take part in the bus, after 11 recessive bits unless `integrated` says they were seen."""
        raise NotImplementedError

    def stop(self, at_ns: int) -> None:
        """Leave the bus; queued frames stay queued."""
        raise NotImplementedError

    def restart(self, at_ns: int) -> None:
        """After bus-off, begin to wait for 128 times 11 recessive bits."""
        raise NotImplementedError

    def rejoin(self, at_ns: int) -> None:
        """Its plug is back in: 11 recessive bits, counters as they are."""
        raise NotImplementedError

    def on_wire(self) -> bool:
        """A frame of this controller's is being transmitted at this moment."""
        raise NotImplementedError

    def counters(self) -> Counters:
        """The counters as they are now."""
        raise NotImplementedError

    def registers(self) -> list[RegisterValue]:
        """The chip's registers as they are, read without side effects; an ideal controller has none."""
        return []

    def close(self) -> None:
        """Leave the bus for good."""
        self.stop(0)

    # frames; words are those of 80-byte records

    def occupied(self, words: _mem.Words, at: int) -> bool:
        """The mailbox for the priority of the record at word `at` is taken."""
        return self.high.occupied if words[at + 1] >> 32 & _HIGH_PRIORITY else self.normal.occupied

    def load(self, words: _mem.Words, at: int, now_ns: int, owner: object) -> bool:
        """Send the record at word `at` from its mailbox, which must be free; True if it is one of high priority."""
        info = words[at + 1] >> 32
        urgent = info & _HIGH_PRIORITY != 0
        box = self.high if urgent else self.normal
        _mem.copy_record(box.words, 0, words, at)
        box.occupied = True
        box.esi_added = False
        box.single_shot = info & _SINGLE_SHOT != 0
        box.abort_on_error = info & _ABORT_ON_ERROR != 0
        box.owner = owner
        box.ready_ns = now_ns
        self.transmit(box, now_ns)
        return urgent

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        """The frame in this mailbox, one of the two, is to be sent; whoever loads it polls the bus if need be."""
        raise NotImplementedError

    def poll(self) -> None:
        """Something was loaded from outside the bus's own calls."""

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        """Give up the frame in a mailbox, unless it is on the wire this very moment; False if it stays."""
        raise NotImplementedError

    def listen(self, sink: Sink, attentive: bool) -> None:
        """Received frames may go straight to `sink`; an `attentive` host wants to hear of every loss and error."""
