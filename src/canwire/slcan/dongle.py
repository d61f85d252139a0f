"""The dongle: converts between the host's bytes and the frames of a CanSide. It has no I/O and no clock.

The manual leaves some points open. Here a frame counts as waiting until it was sent successfully, so a ninth frame is
refused while eight wait (CT-18); flags stay set until F reads them, even if the channel is closed; C discards the
frames in both queues. Source: CANBUS manual; rulings 26 to 29.
"""

from __future__ import annotations

from binascii import Error, unhexlify
from collections.abc import Callable

from canwire import BadValue, BitTiming, EventKind, Frame, LineError, SlcanReader
from canwire.slcan import flags as f
from canwire.slcan.can_side import TRANSMIT_QUEUE, CanSide, Setup
from canwire.slcan.dialects import Rule, State
from canwire.slcan.eeprom import Eeprom, MemoryEeprom
from canwire.slcan.host_side import HostSide
from canwire.slcan.leds import Leds
from canwire.slcan.refusals import Refusals
from canwire.slcan.settings import Chosen, DongleCounters, Settings

OK, BELL = b"\r", b"\a"


class Dongle:
    """A dongle, powered up by its constructor. `now_ns` is the clock that stamps the frames of the CAN side.

    Call `feed` with bytes from the host, and `pump` when the CAN side has something. Write the bytes of `output` to
    the host, and call `written` with how many were written. No bytes from the host make it raise; only HubError is
    raised, when the CAN side is gone.
    """

    def __init__(
        self,
        can: CanSide,
        now_ns: Callable[[], int],
        settings: Settings | None = None,
        eeprom: Eeprom | None = None,
    ) -> None:
        self.settings = settings or Settings()
        self.dialect = self.settings.dialect
        self.state = State.IDLE if self.dialect.timing is None else State.INITIATED
        self.flags = 0
        self.counters = DongleCounters()
        self.on_change: Callable[[str], object] | None = None  # hears what a person may want to know
        self._can = can
        self._now_ns = now_ns
        power_up_ns = now_ns()
        self.leds = Leds(power_up_ns)
        self._host = HostSide(self.settings.output_size, self.counters, power_up_ns)
        self._eeprom = eeprom or MemoryEeprom()
        self._host.stamps = self._eeprom.load()
        self._chosen = Chosen(self.dialect.timing, self.dialect.data_timing)
        self._reader = SlcanReader(fd=self.dialect.fd)
        self._watch = f.Watch()
        self._refusals = Refusals(can, self._say)
        self._waiting = 0  # frames that the CAN side has and that are not through
        self._lost_before = can.lost()
        self._rules: dict[bytes, tuple[Rule, Callable[[bytes], bytes | None]]] = {
            letter: (rule, getattr(self, "_" + rule.action)) for letter, rule in self.dialect.rules.items()
        }

    @property
    def output(self) -> bytearray:
        """Bytes for the host."""
        return self._host.output

    @property
    def bit_rate(self) -> int | None:
        """The bit rate that S or s has set, in bit/s; None before."""
        return None if self._chosen.timing is None else self._chosen.timing.bit_rate

    @property
    def stamps(self) -> bool:
        """True if received frames get a time stamp."""
        return self._host.stamps

    @property
    def waiting(self) -> int:
        """The number of frames in the transmit queue."""
        return self._waiting

    @property
    def queued(self) -> int:
        """The number of frames in the receive queue, which do not fit into the host's buffer."""
        return len(self._host.queue)

    # the host's side

    def feed(self, data: bytes | bytearray | memoryview) -> None:
        """Execute the commands in these bytes from the host."""
        for item in self._reader.feed(data):
            if isinstance(item, Frame):
                self._send(item)
            elif item:
                self._command(item)
            else:
                self._answer(OK)
        self._refusals.tell()

    def written(self, count: int) -> None:
        """Remove this many bytes of `output`, which were written to the host."""
        self._host.written(count)

    def unplug_host(self) -> None:
        """The host is gone: discard the output and an unfinished command. The channel stays as it is."""
        self._host.clear()
        self._reader.clear()

    def power_down(self) -> None:
        """Leave the bus; a second call has no effect."""
        self._can.close()
        self.state = State.IDLE

    # the CAN side

    def pump(self) -> None:
        """Fetch frames and events from the CAN side."""
        for event in self._can.events():
            if event.kind is EventKind.ABORTED:  # a single shot that missed
                self._waiting = max(0, self._waiting - 1)
            else:
                self._raise(self._watch.flags_of(event))
        while frames := self._can.poll():
            for frame in frames:
                if frame.self_received:
                    self._waiting = max(0, self._waiting - 1)
                    self.counters.sent += 1
                    self.leds.frame(frame.timestamp_ns)
                elif self._host.take(frame):
                    self.leds.frame(frame.timestamp_ns)
                else:
                    self._lose(1)
        lost = self._can.lost()
        if lost != self._lost_before:
            self._lose(lost - self._lost_before)
            self._lost_before = lost

    def _lose(self, count: int) -> None:
        self.counters.lost += count
        self._raise(f.RECEIVE_FULL | f.OVERRUN)

    def _raise(self, flags: int) -> None:
        if flags & ~self.flags:
            self.flags |= flags
            self.leds.show(self.flags, self._now_ns())

    # answers

    def _answer(self, reply: bytes) -> None:
        if self.dialect.answers:
            self._host.tell(reply)

    # commands: each returns what it answers, None for an error

    def _send(self, frame: Frame) -> None:
        self.counters.commands += 1
        if self.state is not State.OPEN or not self._room_to_send():
            self._refuse()
            return
        try:
            self._can.send(frame, single_shot=self._chosen.single_shot)
        except (LineError, BadValue):
            self._refuse()
            return
        self._waiting += 1
        queued = b"Z\r" if frame.extended else b"z\r"
        self._answer(OK if self.settings.tx_reply == "cr" else queued)

    def _room_to_send(self) -> bool:
        if self._waiting >= TRANSMIT_QUEUE:
            self._now_ns()  # reading the time makes the hub advance to it: some may have been sent by now
            self.pump()
            if self._waiting >= TRANSMIT_QUEUE:
                self.counters.refused += 1
                self._refusals.one()
                self._raise(f.TRANSMIT_FULL)
                return False
        return True

    def _command(self, line: bytes) -> None:
        self.counters.commands += 1
        rule, action = self._rules.get(line[:1], (None, None))
        if rule is None or action is None or self.state not in rule.states or len(line) - 1 != rule.length:
            self._refuse()
            return
        reply = action(line[1:])
        if reply is None:
            self._refuse()
        else:
            (self._answer if reply == OK else self._host.tell)(reply)

    def _refuse(self) -> None:
        self.counters.errors += 1
        self._answer(BELL)

    def _set_rate(self, argument: bytes) -> bytes | None:
        timing = self.dialect.rates.get(argument)
        return None if timing is None else self._set_timing(timing)

    def _set_registers(self, argument: bytes) -> bytes | None:
        values = _hex(argument)
        return None if values is None else self._set_timing(BitTiming.from_btr(*values))

    def _set_timing(self, timing: BitTiming) -> bytes:
        self._chosen.timing = timing
        self.state = State.INITIATED
        self._say(f"set to {timing.bit_rate} bit/s")
        return OK

    def _set_data_rate(self, argument: bytes) -> bytes | None:
        timing = (self.dialect.data_rates or {}).get(argument)
        self._chosen.data_timing = timing or self._chosen.data_timing
        return None if timing is None else OK

    def _open(self, argument: bytes) -> bytes | None:
        return self._go(listen_only=self._chosen.silent)

    def _listen(self, argument: bytes) -> bytes | None:
        return self._go(listen_only=True)

    def _go(self, *, listen_only: bool) -> bytes | None:
        chosen = self._chosen
        assert chosen.timing is not None
        setup = Setup(chosen.timing, chosen.data_timing, listen_only, chosen.code, chosen.mask)
        try:
            self._can.open(setup)
        except (LineError, BadValue) as error:
            self._say(f"cannot be opened: {error}")
            return None
        self._waiting = 0
        self._refusals.restart()
        self._watch.restart()
        self.state = State.LISTENING if listen_only else State.OPEN
        data = f", {chosen.data_timing.bit_rate} after BRS" if chosen.data_timing else ""
        self._say(f"{'listening' if listen_only else 'open'} at {chosen.timing.bit_rate} bit/s{data}")
        return OK

    def _close(self, argument: bytes) -> bytes:
        self._can.close()
        self._host.queue.clear()
        self._waiting = 0
        self.state = State.INITIATED
        self._say(f"closed; since power-up: {self.counters.summary}")
        return OK

    def _read_flags(self, argument: bytes) -> bytes:
        self.pump()
        reply = b"F%02X\r" % self.flags
        self.flags = 0
        self.leds.show(0, self._now_ns())
        return reply

    def _set_code(self, argument: bytes) -> bytes | None:
        code = _hex(argument)
        self._chosen.code = self._chosen.code if code is None else code
        return None if code is None else OK

    def _set_mask(self, argument: bytes) -> bytes | None:
        mask = _hex(argument)
        self._chosen.mask = self._chosen.mask if mask is None else mask
        return None if mask is None else OK

    def _tell_version(self, argument: bytes) -> bytes:
        return self.settings.version.encode() + OK

    def _tell_serial_number(self, argument: bytes) -> bytes:
        return b"N" + self.settings.serial_number.encode() + OK

    def _tell_errors(self, argument: bytes) -> bytes:
        return b"CANable Error Register: %X" % self.flags

    def _set_stamps(self, argument: bytes) -> bytes | None:
        if argument not in (b"0", b"1"):
            return None
        self._host.stamps = argument == b"1"
        self._eeprom.save(self._host.stamps)
        return OK

    def _set_silent(self, argument: bytes) -> bytes:
        self._chosen.silent = argument == b"1"
        return OK

    def _set_repeating(self, argument: bytes) -> bytes:
        self._chosen.single_shot = argument != b"1"
        return OK

    def _say(self, what: str) -> None:
        if self.on_change is not None:
            self.on_change(what)


def _hex(digits: bytes) -> bytes | None:
    """The bytes that these digits stand for; None for others."""
    try:
        return unhexlify(digits)
    except Error:
        return None
