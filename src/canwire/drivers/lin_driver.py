"""The seam between a LIN line and whatever makes its controller send and receive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from canwire.values.lin.event import LinState
from canwire.values.lin.frame import LinFrame


@dataclass(frozen=True, slots=True)
class LinSettings:
    """How a line takes part in its LIN bus.

    `bit_rate` in bit/s, for a slave also 0: it finds the rate on the running bus. `oscillator_ppm` is how far
    the node's clock is off (positive: fast), -200,000..200,000; a slave that `synchronises` makes up for
    140,000 of them. A master's break has `break_bits` (13..60) and a delimiter of `delimiter_bits` (1..14);
    `header_space_bits` (0..14) lie between its sync field and its identifier. Responses begin
    `response_space_bits` (0..126) after the header, with `byte_space_bits` (0..126) between bytes.
    A started or woken node hears nothing for `start_up_ns` (0..100 ms).
    """

    master: bool
    bit_rate: int
    oscillator_ppm: float = 0.0
    synchronises: bool = True
    break_bits: int = 13
    delimiter_bits: int = 1
    header_space_bits: int = 0
    response_space_bits: int = 0
    byte_space_bits: int = 0
    start_up_ns: int = 0


@dataclass(frozen=True, slots=True)
class LinCounters:
    """What a controller counts since its start; `errors` by LinErrorKind, `headers` the valid ones heard.

    `bit_rate` is 0 while it is being looked for. `status` holds VCI's LIN_STATUS_ bits, but for the overrun.
    """

    state: LinState
    status: int
    bit_rate: int
    headers: int
    frames_sent: int
    frames_received: int
    wake_ups: int
    errors: tuple[int, ...]
    response_error: bool


class LinDriver(Protocol):
    """Makes one controller take part in its LIN bus. Times are the timeline's, in nanoseconds.

    `configure` before `start`; a second one takes effect at once, mid-frame if need be. `stop` and `close` may be
    called again and again. The response table may be changed at any time, and outlives a stop.
    """

    def configure(self, settings: LinSettings) -> None:
        """Set mode and timing; raises BadTiming or BadValue for what the controller cannot do."""

    def start(self, at_ns: int) -> None:
        """Take part in the bus."""

    def stop(self, at_ns: int) -> None:
        """Leave the bus; what waits to be sent is given up."""

    def clear(self) -> None:
        """Empty the response table; lengths, events and the error bit that it was told are forgotten too."""

    def respond(self, frame: LinFrame, *, once: bool = False) -> None:
        """Answer the frame's header with its data from now on, or once."""

    def withdraw(self, id: int) -> None:
        """Answer this header no more."""

    def subscribe(self, id: int, length: int) -> None:
        """A frame of this length (1..8) is expected behind this header; 0: nothing is."""

    def expect_checksum(self, id: int, enhanced: bool | None) -> None:
        """This frame is right with this checksum alone (True: enhanced); None: with either, until told otherwise."""

    def associate(self, event: int, id: int) -> None:
        """Answer the event-triggered frame `event` with the response of `id`, when that was updated."""

    def take(self, id: int) -> object:
        """Everything that it was told about this frame, which it forgets: for `place`."""

    def place(self, id: int, role: object) -> None:
        """The frame that was taken has this identifier from now on: response, length, checksum, events, error bit."""

    def report_errors_in(self, id: int, bit: int) -> None:
        """This bit of the response of `id` tells of errors in responses, until it was sent."""

    def is_updated(self, id: int) -> bool:
        """The response of `id` has been changed since it was sent last."""

    def ask(self, id: int, length: int, silence_is_fine: bool) -> None:
        """Send a header for somebody to answer with `length` bytes (0: as many as come); the buffer must be free."""

    def send(self, frame: LinFrame) -> None:
        """Send the frame's header with its data behind it; the buffer must be free."""

    def wake_up(self) -> None:
        """Send a wake-up pulse; the buffer must be free."""

    def on_wire(self) -> bool:
        """Something of this controller's is on the wire, or awaits its response."""

    def counters(self, at_ns: int) -> LinCounters:
        """The counters as they are now."""

    def close(self) -> None:
        """Leave the bus for good."""
