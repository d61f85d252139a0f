"""Driver of a serial adapter: it runs the talk of session.py over the bytes of link.py.

When an adapter that was gone is back, it is opened again with the same settings.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from canwire.bus.can.node import Mailbox
from canwire.drivers.driver import LineSettings
from canwire.drivers.outside import AdapterClock, Identity, OutsideDriver, Reactor, Trouble
from canwire.drivers.slcan_dongle.acceptance import pushed
from canwire.drivers.slcan_dongle.confinement import state_after
from canwire.drivers.slcan_dongle.conversation import NEVER, Conversation
from canwire.drivers.slcan_dongle.link import BACKLOG, Link, monotonic_ns
from canwire.drivers.slcan_dongle.port import parse_port
from canwire.drivers.slcan_dongle.session import POLL_NS, Session
from canwire.drivers.slcan_dongle.settings import setup_of, versions_of
from canwire.drivers.slcan_dongle.user import Adapter, Setup
from canwire.timeline import Timeline, Timer
from canwire.values.event import ErrorKind, ErrorState, EventKind
from canwire.values.frame import Frame, record_of_frame
from canwire.values.register import RegisterValue
from canwire.values.slcan_text import format_slcan_frame

if TYPE_CHECKING:
    from canwire.chips.host import Host

F_BITS = ("receive queue full", "transmit queue full", "error warning", "data overrun", "", "error passive",
          "arbitration lost", "bus error")  # fmt: skip
_RX_FULL, _OVERRUN, _ARBITRATION_LOST, _BUS_ERROR = 1 << 0, 1 << 3, 1 << 6, 1 << 7
_STAMP_NS = 1_000_000
_STAMP_PERIOD_NS = 60_000 * _STAMP_NS
_BACK_OFF_S = 1.0  # for an adapter that does not answer


class SlcanDriver(OutsideDriver):
    """The Driver (drivers/driver.py) of an adapter at `port` (port.py); raises BadValue.

    The adapter does not report single bus errors, only that some occurred since F was last read.
    """

    def __init__(
        self, host: Host | None, port: str, timeline: Timeline, reactor: Reactor, *, poll_ns: int = POLL_NS
    ) -> None:
        super().__init__(host, timeline, port)
        self.wanted: Setup | None = None
        self._port = parse_port(port)
        self._reactor = reactor
        self._setup: Setup | None = None
        self._number: str | None = None
        self._strange = False
        self._text: bytes | None = None
        self._connected = False
        self._flags = 0
        self._clock = AdapterClock(_STAMP_PERIOD_NS)
        self._timer: Timer | None = None
        self._malformed = self._last_ns = 0
        self.session = Session(
            self,
            lambda: self._conversation.now_ns,
            self._rest,
            poll_ns=poll_ns,
            stamps=self._port.stamps,
            rates={self._port.s7: b"7"} if self._port.s7 else None,
        )
        answer_ns = int(self._port.answer_s * 1e9)
        self._link = Link(self._port, reactor, self._came, self._took, self._gone, self._poke, self.hindered)
        self._conversation = Conversation(self._link.write, self._frames, answer_ns)
        reactor.when_closed(self.close)
        self._link.open()

    # settings

    def check(self, settings: LineSettings) -> None:
        """Raise what no serial adapter can do; what this one cannot do shows only after the commands were sent."""
        settings.refuse_options("a serial adapter")
        setup_of(settings)

    def configure(self, settings: LineSettings) -> None:
        self.check(settings)
        before, self._setup = self._setup, setup_of(settings)
        if before is not None:
            self._setup = replace(self._setup, enough=before.enough)
        self.listen_only = settings.listen_only
        self.fd = 1 if settings.data_timing is not None else 0
        if self.running and not self._is_so_already(before):
            self.wanted = self._setup
            self._poke()

    def _is_so_already(self, before: Setup | None) -> bool:
        """True if the adapter already has these settings: a change interrupts reception, so an equal one is skipped."""
        assert self._setup is not None
        if self.on_bus:
            active = self.state is ErrorState.ERROR_ACTIVE
            return active and before is not None and self._setup.told == before.told
        opening = self.wanted
        return (
            opening is not None and opening is not self.session.refused and self._setup.told == opening.told
        )

    # taking part

    def accept(self, standard: tuple[int, int] | None, extended: tuple[int, int] | None) -> None:
        enough = pushed(standard, extended)
        if (
            self._setup is not None and self._setup.enough != enough
        ):  # else it would leave its bus for nothing
            self._setup = replace(self._setup, enough=enough)
            if self.running:
                self.wanted = self._setup
                self._poke()

    def start(self, at_ns: int, integrated: bool = False) -> None:
        self.begin()
        if self._setup is not None:
            self._setup = replace(self._setup)  # the talk may not have seen yet that it was stopped
        self.wanted = self._setup
        self._poke()
        self.fill()

    def stop(self, at_ns: int) -> None:
        self.wanted = None
        self._poke()
        self.end()

    def restart(self, at_ns: int) -> None:
        """Open the channel again, the only way back from bus-off."""
        if self.running and self._setup is not None:
            self.wanted = replace(self._setup)
            self._poke()

    def close(self) -> None:
        """Close the port, and before that the adapter's channel if the adapter is still connected."""
        self._reactor.forget(self.close)
        if self._connected and self.on_bus:
            self._link.write(b"C\r")
        self._connected = self.on_bus = self.running = False
        self.wanted = None
        self._conversation.end()
        self._link.close()
        if self._timer is not None:
            self._timer.cancel()

    def registers(self) -> list[RegisterValue]:
        """The last answer to F."""
        text = ", ".join(name for bit, name in enumerate(F_BITS) if self._flags >> bit & 1)
        return [RegisterValue("F", 0, self._flags, text or "no flag is set")]

    # sending

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        self._text = None
        self._poke()

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        """A frame that the adapter has accepted cannot be aborted."""
        if not box.occupied or self.session.sending:
            return False
        self.given_up()
        return True

    # session.py's User

    def met(self, adapter: Adapter) -> bool:
        port, number = self._port, adapter.serial_number
        if not port.url and number != port.serial and not self._link.found:
            return False  # looked for by its own number: not this one
        if self._number and number != self._number:
            if not self._strange:
                self._strange = True
                self.trouble(Trouble.STRANGER, f"adapter {number} is where {self._number} was")
            return False
        self._number, self._strange = number, False
        self.text = ""
        facts = [("Port", self._link.where), ("Version", adapter.version)]
        if number:
            facts.append(("Serial number", number))
        facts.append(("Dialect", adapter.dialect.name))
        if self.on_identified is not None:
            self.on_identified(Identity(tuple(facts), *versions_of(adapter.version)))
        return True

    def opened(self) -> None:
        self.joined()

    def closed(self) -> None:
        self._clock = AdapterClock(_STAMP_PERIOD_NS)  # its clock starts at 0 if it lost its power
        self.left()

    def next_frame(self) -> bytes | None:
        if not self.normal.occupied or not self.on_bus:
            return None
        if self._text is None:
            self._text = format_slcan_frame(self.frame())[:-1]
        return self._text

    def sent(self) -> None:
        self._text = None
        self.finished(True)

    def given_up(self) -> None:
        self._text = None
        self.finished(False)

    def ready(self) -> bool:
        return self._link.backlog <= BACKLOG

    def flags(self, value: int) -> None:
        self._flags = value
        malformed = self._conversation.malformed
        if malformed != self._malformed:
            self._malformed = malformed
            self.trouble(Trouble.MALFORMED, f"{malformed} mangled lines")
        if value & _BUS_ERROR:
            self.bus_error(ErrorKind.OTHER, code=value)
        if value & _ARBITRATION_LOST:
            self.arbitration_lost()
        if value & (_OVERRUN | _RX_FULL):
            self.tell(EventKind.OVERRUN)
        self.now_in(state_after(self.state, value))

    def trouble(self, what: Trouble, text: str) -> None:
        """Report trouble, unless the adapter is still being searched for: then others may answer."""
        if self._port.url or self._number is not None:
            super().trouble(what, text)

    def hopeless(self, text: str) -> None:
        self._lose(text)
        self._link.give_up(text, _BACK_OFF_S if self._number is not None or self._port.url else 0.0)

    # the link

    def _came(self) -> None:
        self._connected = True
        self._clock = AdapterClock(_STAMP_PERIOD_NS)
        self._conversation.begin(self.session.talk(), monotonic_ns())
        self._arm()

    def _took(self, data: bytes) -> None:
        self._conversation.feed(data, monotonic_ns())
        self._arm()

    def _gone(self, why: str) -> None:
        self._lose(why)

    def _lose(self, why: str) -> None:
        self.hindered(why)
        self._connected = False
        self.left()
        self._conversation.end()

    def _frames(self, frames: list[Frame], stamps: list[int]) -> None:
        host, box, now_ns = self.host, self._incoming, self.timeline.now_ns
        if host is None or not self.running or not self.session.hears:
            return
        self._received += len(frames)
        block, received, arrived_ns = box.block, host.received, self._conversation.now_ns
        at_ns, ahead_ns, last_ns = now_ns, now_ns - arrived_ns, self._last_ns
        for frame, stamp in zip(frames, stamps, strict=True):
            if stamp >= 0:
                at_ns = ahead_ns + self._clock.host_ns(stamp * _STAMP_NS, arrived_ns)
            if at_ns > last_ns:
                last_ns = at_ns
            block[:] = record_of_frame(frame)
            received(box, last_ns)
        self._last_ns = last_ns

    # time

    def _poke(self) -> None:
        if self._connected:
            self._conversation.poke(monotonic_ns())
            self._arm()

    def _rest(self, until_ns: int) -> None:
        self._conversation.rest_until_ns = until_ns

    def _arm(self) -> None:
        """One timer, early enough; where bus time runs ahead of the clock, it is set again."""
        deadline_ns = self._conversation.deadline_ns
        if not self._connected or deadline_ns >= NEVER:
            return
        at_ns = self.timeline.now_ns + max(0, deadline_ns - monotonic_ns())
        timer = self._timer
        if timer is None or timer.callback is None or timer.time_ns > at_ns:
            if timer is not None:
                timer.cancel()
            self._timer = self.timeline.at(at_ns, self._tick, background=True)

    def _tick(self) -> None:
        if self._connected:
            self._conversation.tick(monotonic_ns())
            self._arm()
