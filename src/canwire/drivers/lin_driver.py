"""The interface between a LIN line and the driver that makes its controller send and receive."""

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
    A started or woken node receives nothing for `start_up_ns` (0..100 ms).
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
    """What a controller has counted since its start: `errors` by LinErrorKind, `headers` the valid ones received.

    `bit_rate` is 0 until the controller has found the rate. `status` holds VCI's LIN_STATUS_ bits except the overrun.
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

    Call `configure` before `start`; a later call takes effect immediately, even in the middle of a frame. `stop` and
    `close` may be called any number of times. The response table may be changed at any time; a stop does not clear it.
    """

    def configure(self, settings: LinSettings) -> None:
        """Set mode and timing; raises BadTiming or BadValue for what the controller cannot do."""

    def start(self, at_ns: int) -> None:
        """Take part in the bus."""

    def stop(self, at_ns: int) -> None:
        """Leave the bus; frames that wait to be sent are discarded."""

    def clear(self) -> None:
        """Clear the response table, with all lengths, events and the error bit."""

    def respond(self, frame: LinFrame, *, once: bool = False) -> None:
        """Answer the frame's header with its data from now on; only the next time with `once`."""

    def withdraw(self, id: int) -> None:
        """Stop answering this header."""

    def subscribe(self, id: int, length: int) -> None:
        """Expect a response of this length (1..8) after this header; 0: expect none."""

    def expect_checksum(self, id: int, enhanced: bool | None) -> None:
        """Accept this frame only with this checksum (True: enhanced, False: classic); None: with either."""

    def associate(self, event: int, id: int) -> None:
        """Answer the event-triggered frame `event` with the response of `id` if that response was updated."""

    def take(self, id: int) -> object:
        """Remove all settings of this frame and return them, for `place`."""

    def place(self, id: int, role: object) -> None:
        """Give settings that `take` returned this identifier: response, length, checksum, events, error bit."""

    def report_errors_in(self, id: int, bit: int) -> None:
        """Set this bit of the response of `id` after an error in a response, until the bit has been sent."""

    def is_updated(self, id: int) -> bool:
        """True if the response of `id` has changed since it was last sent."""

    def ask(self, id: int, length: int, silence_is_fine: bool) -> None:
        """Send a header that another node answers with `length` bytes (0: any number); the buffer must be free."""

    def send(self, frame: LinFrame) -> None:
        """Send the frame's header and its data; the buffer must be free."""

    def wake_up(self) -> None:
        """Send a wake-up pulse; the buffer must be free."""

    def on_wire(self) -> bool:
        """True while this controller transmits, or waits for the response to its header."""

    def counters(self, at_ns: int) -> LinCounters:
        """The present values of the counters."""

    def close(self) -> None:
        """Leave the bus for good."""
