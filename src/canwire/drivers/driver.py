"""The seam between a line and whatever makes its controller send and receive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from canwire.values.bit_timing import BitTiming
from canwire.values.event import ErrorState


@dataclass(frozen=True, slots=True)
class LineSettings:
    """How a line takes part in its bus.

    `data_timing` None means a classic line. `oscillator_ppm` is how far the node's crystal is off
    (positive: fast), -100,000..100,000.
    """

    timing: BitTiming
    data_timing: BitTiming | None = None
    iso_fd: bool = True
    listen_only: bool = False
    oscillator_ppm: float = 0.0


@dataclass(frozen=True, slots=True)
class Counters:
    """What a controller counts; `tec` is held at 256 in bus-off."""

    tec: int
    rec: int
    state: ErrorState
    errors: int
    arbitration_losses: int
    frames_sent: int
    frames_received: int


class Driver(Protocol):
    """Makes one controller take part in its bus. Times are the timeline's, in nanoseconds.

    `configure` before `start`; a second one takes effect at once, mid-frame if need be. `stop` and `close` may be
    called again and again. Frames go through the line's queues, not through here.
    """

    def configure(self, settings: LineSettings) -> None:
        """Set timing and mode; raises BadTiming for what the controller cannot do."""

    def start(self, at_ns: int, *, integrated: bool = False) -> None:
        """Take part in the bus, after 11 recessive bits unless `integrated` says they were seen."""

    def stop(self, at_ns: int) -> None:
        """Leave the bus; queued frames stay queued."""

    def restart(self, at_ns: int) -> None:
        """After bus-off, begin to wait for 128 times 11 recessive bits."""

    def counters(self) -> Counters:
        """The counters as they are now."""

    def close(self) -> None:
        """Leave the bus for good."""
