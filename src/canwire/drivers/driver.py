"""The seam between a line and whatever makes its controller send and receive."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from canwire import _mem
from canwire.bus.can.node import Mailbox, Sink
from canwire.errors import Unsupported
from canwire.values.controller_options import USUAL, ControllerOptions
from canwire.values.event import ErrorState
from canwire.values.register import RegisterValue
from canwire.values.timing.bit_timing import BitTiming

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
    names, beyond what the other settings say; an ideal controller has none. With `loop_back` it hears only itself.
    Only an ideal controller has other `options` than the usual ones.
    """

    timing: BitTiming
    data_timing: BitTiming | None = None
    iso_fd: bool = True
    listen_only: bool = False
    oscillator_ppm: float = 0.0
    registers: tuple[tuple[str, int], ...] = ()
    loop_back: bool = False
    options: ControllerOptions = USUAL

    def refuse_options(self, who: str) -> None:
        """Raise Unsupported for other options than the usual ones, which `who` does not have."""
        if unusual := self.options.unusual():
            raise Unsupported(f"{who} has no {', '.join(unusual)}: only ideal controllers do")


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
    one); or `several` equal ones, and then one for each channel at a time. `boxes` are all of them. `running`,
    `listen_only` and `fd` (as Node.fd) say how it takes part. Times are the timeline's, in nanoseconds.
    `configure` before `start`; a second one takes effect at once, mid-frame if need be. `stop` and `close` may be
    called again and again.
    """

    def __init__(self, host: Host | None, normal: Mailbox, high: Mailbox) -> None:
        self.host = host
        self.normal = normal
        self.high = high
        self.boxes = [normal] if normal is high else [normal, high]
        self.several = False
        self.running = False
        self.listen_only = False
        self.fd = 0

    def check(self, settings: LineSettings) -> None:
        """Raise what `configure` would: BadTiming, Unsupported or BadValue; nothing is changed."""
        raise NotImplementedError

    def configure(self, settings: LineSettings) -> None:
        """Set timing and mode; raises what `check` does, before anything is changed."""
        raise NotImplementedError

    def forget(self) -> None:
        """What it was set up for no longer holds; the controller is stopped."""
        self.listen_only = False
        self.fd = 0

    def accept(self, standard: tuple[int, int] | None, extended: tuple[int, int] | None) -> None:
        """Nobody wants other frames than those that agree with these patterns, (code, mask) of
        id << 1 | remote; None: none of that format. Whoever can holds up others; the line filters by itself."""

    def report(self, kinds: frozenset[int], frames: bool) -> None:
        """Programs want these kinds of events (EventKind), and `frames`, whatever the settings' registers say."""

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

    def idle(self) -> bool:
        """No frame is on the wire, as far as this controller knows."""
        return not self.on_wire()

    def sleep(self, at_ns: int) -> None:
        """Save power until something happens on the bus, or is to be sent; raises Unsupported."""
        raise Unsupported("this controller cannot sleep")

    def wake(self, at_ns: int) -> None:
        """No longer asleep."""
        raise Unsupported("this controller cannot sleep")

    def hold(self, held: bool) -> None:
        """Whoever serves the controller is kept from it, as by a system that hangs; raises Unsupported."""
        raise Unsupported("this controller needs nobody to serve it")

    def counters(self) -> Counters:
        """The counters as they are now."""
        raise NotImplementedError

    def registers(self) -> list[RegisterValue]:
        """The chip's registers as they are, read without side effects; an ideal controller has none."""
        return []

    def read_register(self, address: int, reset_mode: bool) -> int:
        """One register, with what reading it does; in reset mode if asked for, which leaves the bus for a moment.

        Raises Unsupported, and BadValue for an address that the chip does not have.
        """
        raise Unsupported("this controller has no registers")

    def write_register(self, address: int, value: int, reset_mode: bool) -> None:
        """Write one, whatever that does; raises like `read_register`."""
        raise Unsupported("this controller has no registers")

    def close(self) -> None:
        """Leave the bus for good."""
        self.stop(0)

    # frames; words are those of 80-byte records

    def occupied(self, words: _mem.Words, at: int) -> bool:
        """The mailbox for the priority of the record at word `at` is taken."""
        if self.several:
            return self._free() is None
        return self.high.occupied if words[at + 1] >> 32 & _HIGH_PRIORITY else self.normal.occupied

    def load(self, words: _mem.Words, at: int, now_ns: int, owner: object) -> bool:
        """Send the record at word `at` from its mailbox, which must be free; True if it is one of high priority."""
        info = words[at + 1] >> 32
        urgent = info & _HIGH_PRIORITY != 0
        if self.several:
            box = self._free()
        elif urgent:
            box = self.high
        else:
            box = self.normal
        _mem.copy_record(box.words, 0, words, at)
        box.occupied = True
        box.esi_added = False
        box.single_shot = info & _SINGLE_SHOT != 0
        box.abort_on_error = info & _ABORT_ON_ERROR != 0
        box.owner = owner
        box.ready_ns = now_ns
        self.transmit(box, now_ns)
        return urgent

    def _free(self) -> Any:
        for box in self.boxes:
            if not box.occupied:
                return box
        return None

    def full_for(self, owner: object) -> bool:
        """Of `several` mailboxes, none is free, or one has a frame of this owner's: its frames keep their order."""
        free = False
        for box in self.boxes:
            if not box.occupied:
                free = True
            elif box.owner is owner:
                return True
        return not free

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        """The frame in this mailbox, one of the two, is to be sent; whoever loads it polls the bus if need be."""
        raise NotImplementedError

    def poll(self) -> None:
        """Something was loaded from outside the bus's own calls."""

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        """Give up the frame in a mailbox; False if it stays, on the wire this very moment: then a chip sends it no
        second time should it fail."""
        raise NotImplementedError

    def settle(self, box: Mailbox, delivered: bool, at_ns: int) -> None:
        """For drivers: the frame in this mailbox went through, or was given up; the next one may come."""
        if self.host is not None:
            if delivered:
                self.host.transmitted(box, at_ns)
            else:
                self.host.aborted(box, at_ns)
        box.occupied = False
        if self.host is not None:
            self.host.fill(at_ns)

    def listen(self, sink: Sink, attentive: bool) -> None:
        """Received frames may go straight to `sink`; an `attentive` host wants to hear of every loss and error."""
