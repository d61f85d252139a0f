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
    names, in addition to the other settings; an ideal controller has none. With `loop_back` a line receives only
    its own frames. Only an ideal controller accepts `options` other than the default ones.
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
        """Raise Unsupported, in the name of `who`, unless all options have their default values."""
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
    """Makes one controller take part in its bus, and passes frames between the controller and its host, a line.

    A controller has one mailbox for frames, `normal`, and may have a second one, `high`, that is sent first (without
    one, both names mean the same mailbox). With `several`, it has more mailboxes of equal rank, and each channel uses
    one at a time. `boxes` lists all mailboxes. `running`, `listen_only` and `fd` (as Node.fd) say how the controller
    takes part. Times are those of the timeline, in nanoseconds. Call `configure` before `start`; a later call takes
    effect immediately, even in the middle of a frame. `stop` and `close` may be called any number of times.
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
        """Raise what `configure` would raise: BadTiming, Unsupported or BadValue. Changes nothing."""
        raise NotImplementedError

    def configure(self, settings: LineSettings) -> None:
        """Set timing and mode. Raises what `check` raises, before it changes anything."""
        raise NotImplementedError

    def forget(self) -> None:
        """Discard the settings; the controller is stopped."""
        self.listen_only = False
        self.fd = 0

    def accept(self, standard: tuple[int, int] | None, extended: tuple[int, int] | None) -> None:
        """No program wants frames other than those that match these patterns, (code, mask) of id << 1 | remote;
        None: no frames of that format. A driver may discard the others; the line filters in any case."""

    def report(self, kinds: frozenset[int], frames: bool) -> None:
        """Programs want these kinds of events (EventKind), and received `frames` if true, whatever the registers
        of the settings say."""

    def start(self, at_ns: int, integrated: bool = False) -> None:
        """Take part in the bus after 11 recessive bits; immediately if `integrated`: those bits have passed."""
        raise NotImplementedError

    def stop(self, at_ns: int) -> None:
        """Leave the bus; queued frames stay queued."""
        raise NotImplementedError

    def restart(self, at_ns: int) -> None:
        """After bus-off, begin to wait for 128 times 11 recessive bits."""
        raise NotImplementedError

    def rejoin(self, at_ns: int) -> None:
        """The cable was plugged in again: take part after 11 recessive bits, with the counters unchanged."""
        raise NotImplementedError

    def on_wire(self) -> bool:
        """True while the controller transmits a frame."""
        raise NotImplementedError

    def idle(self) -> bool:
        """True while this controller knows of no frame on the wire."""
        return not self.on_wire()

    def sleep(self, at_ns: int) -> None:
        """Save power until the bus is active or a frame is to be sent; raises Unsupported."""
        raise Unsupported("this controller cannot sleep")

    def wake(self, at_ns: int) -> None:
        """End the sleep; raises Unsupported."""
        raise Unsupported("this controller cannot sleep")

    def hold(self, held: bool) -> None:
        """While `held`, the chip's interrupts are not served, as if the system hung; raises Unsupported."""
        raise Unsupported("this controller needs nobody to serve it")

    def counters(self) -> Counters:
        """The present values of the counters."""
        raise NotImplementedError

    def registers(self) -> list[RegisterValue]:
        """The present values of the chip's registers, read without side effects; an ideal controller has none."""
        return []

    def read_register(self, address: int, reset_mode: bool) -> int:
        """Read one register, with the side effects of reading. `reset_mode` reads it in reset mode, for which the
        controller leaves the bus for a moment.

        Raises Unsupported, and BadValue for an address that the chip does not have.
        """
        raise Unsupported("this controller has no registers")

    def write_register(self, address: int, value: int, reset_mode: bool) -> None:
        """Write one register, with all effects; raises what `read_register` raises."""
        raise Unsupported("this controller has no registers")

    def close(self) -> None:
        """Leave the bus for good."""
        self.stop(0)

    # frames; words are those of 80-byte records

    def occupied(self, words: _mem.Words, at: int) -> bool:
        """True while the mailbox for the priority of the record at word `at` is in use."""
        if self.several:
            return self._free() is None
        return self.high.occupied if words[at + 1] >> 32 & _HIGH_PRIORITY else self.normal.occupied

    def load(self, words: _mem.Words, at: int, now_ns: int, owner: object) -> bool:
        """Send the record at word `at` from its mailbox, which must be free. True if the record has high priority."""
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
        """True if none of `several` mailboxes is free, or if one contains a frame of this owner: so the frames of an
        owner keep their order."""
        free = False
        for box in self.boxes:
            if not box.occupied:
                free = True
            elif box.owner is owner:
                return True
        return not free

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        """Send the frame in this mailbox, `normal` or `high`. The caller that loads the frame polls the bus if
        necessary."""
        raise NotImplementedError

    def poll(self) -> None:
        """A frame was loaded by a caller other than the bus."""

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        """Abort the frame in a mailbox. False if the frame is on the wire at this moment and so stays: a chip then
        does not repeat it if it fails."""
        raise NotImplementedError

    def settle(self, box: Mailbox, delivered: bool, at_ns: int) -> None:
        """For drivers: the frame in this mailbox was `delivered` or aborted; the next frame may be loaded."""
        if self.host is not None:
            if delivered:
                self.host.transmitted(box, at_ns)
            else:
                self.host.aborted(box, at_ns)
        box.occupied = False
        if self.host is not None:
            self.host.fill(at_ns)

    def listen(self, sink: Sink, attentive: bool) -> None:
        """Received frames may go directly to `sink`; an `attentive` host needs an event for each loss and error."""
