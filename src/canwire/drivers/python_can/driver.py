"""Driver of an adapter that python-can opens: the Driver (drivers/driver.py) over the threads of adapter.py."""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire.bus.can.node import Mailbox
from canwire.drivers.driver import LineSettings
from canwire.drivers.outside import AdapterClock, Identity, OutsideDriver, Reactor, Trouble
from canwire.drivers.python_can.adapter import Adapter, Heard, User, look, monotonic_ns
from canwire.drivers.python_can.backends import backend
from canwire.drivers.python_can.opening import Setup
from canwire.drivers.python_can.port import parse_port
from canwire.errors import BadText, Unsupported
from canwire.timeline import Timeline
from canwire.values.error_frame import decode_error_frame
from canwire.values.event import ErrorKind, ErrorState, EventKind
from canwire.values.frame import record_of_frame

if TYPE_CHECKING:
    from canwire.chips.host import Host


_ECHOES = 64  # frames that are on their way back at most


class PythonCanDriver(OutsideDriver, User):
    """The adapter at `port` (port.py), open while the line runs; raises BadValue.

    If the interface does not report a state, the state is ERROR_ACTIVE while it is open. A frame counts as sent once
    python-can has accepted it.
    """

    def __init__(self, host: Host | None, port: str, timeline: Timeline, reactor: Reactor) -> None:
        super().__init__(host, timeline, port)
        self._port = parse_port(port)
        self._kind = backend(self._port.interface)
        self._reactor = reactor
        self._setup: Setup | None = None
        self._adapter: Adapter | None = None
        self._sending = self._complained = False
        self._last_ns = 0
        self._clock = AdapterClock()
        self._echoes: deque[bytes] = deque(maxlen=_ECHOES)  # what it was given to send and will receive
        reactor.when_closed(self.close)
        look(self._port, reactor, self._looked)

    # settings

    def check(self, settings: LineSettings) -> None:
        settings.refuse_options("an adapter of python-can")
        if settings.loop_back or settings.registers:
            raise Unsupported("an adapter of python-can has no loop-back and no registers")
        if settings.listen_only and self._kind.listen_only is None:
            raise Unsupported(f"python-can's {self._port.interface} has no listen-only mode")
        if settings.data_timing is not None and self._kind.fd is None:
            raise Unsupported(f"python-can's {self._port.interface} is used for classic CAN only")

    def configure(self, settings: LineSettings) -> None:
        self.check(settings)
        self._setup = Setup(settings.timing, settings.data_timing, settings.listen_only)
        self.listen_only = settings.listen_only
        self.fd = 1 if settings.data_timing is not None else 0
        if self.running:
            self._leave()
            self._open()

    # taking part

    def start(self, at_ns: int, integrated: bool = False) -> None:
        self.begin()
        self._open()

    def stop(self, at_ns: int) -> None:
        self.end()
        self._leave()

    def restart(self, at_ns: int) -> None:
        """Open the bus again, the only way back from bus-off."""
        if self.running:
            self._leave()
            self._open()

    def close(self) -> None:
        self._reactor.forget(self.close)
        self._leave()
        self.running = self.on_bus = False

    def _open(self) -> None:
        if self._setup is not None:
            self._clock = AdapterClock()
            self._echoes.clear()
            self._adapter = Adapter(self._port, self._setup, self._reactor, self)

    def _leave(self) -> None:
        if self._adapter is not None:
            self._adapter.close()
            self._adapter = None
        if self._sending:
            self._sending = False
            self.finished(False)

    # sending

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        if self.on_bus and self._adapter is not None and not self._sending:
            self._sending = True
            frame = self.frame()
            if self._kind.echoes:
                self._echoes.append(record_of_frame(frame))
            self._adapter.send(frame)

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        """A frame that python-can has accepted cannot be aborted."""
        if not box.occupied or self._sending:
            return False
        self.finished(False)
        return True

    # adapter.py's User

    def opened(self, adapter: Adapter, what: str) -> None:
        if adapter is not self._adapter:
            return
        self._complained = False
        self._identify(what)
        self._clock = AdapterClock()
        self.joined()
        if self.normal.occupied:
            self.transmit(self.normal, self.timeline.now_ns)

    def _looked(self, why: str) -> None:
        """The result of `look`, for a line that is not running yet: an obstacle, or ""."""
        if self._adapter is None and why:
            self.hindered(why)
        elif self._adapter is None:
            self._identify("")

    def _identify(self, what: str) -> None:
        facts = [
            ("Port", self.port),
            ("Interface", self._port.interface),
            ("Channel", self._port.channel or ""),
        ]
        if what:
            facts.append(("Adapter", what))
        if self.on_identified is not None:
            self.on_identified(Identity(tuple(facts)))

    def failed(self, adapter: Adapter, why: str) -> None:
        """Report the failure, with one event until the bus is open."""
        self.hindered(why)
        if adapter is self._adapter and not self._complained:
            self._complained = True
            self.trouble(Trouble.REFUSED, why)

    def lost(self, adapter: Adapter, why: str) -> None:
        if adapter is self._adapter:
            self.hindered(why)
            self._complained = True  # STATE tells
            self.left()
            if self._sending:
                self._sending = False
                self.finished(False)

    def sent(self, adapter: Adapter, why_not: str) -> None:
        if adapter is self._adapter and self._sending:
            self._sending = False
            if why_not:
                if self._echoes:
                    self._echoes.pop()
                self.trouble(Trouble.REFUSED, why_not)
            self.finished(not why_not)

    def in_state(self, adapter: Adapter, state: ErrorState) -> None:
        if adapter is self._adapter and self.on_bus:
            self.now_in(state)

    def heard(self, adapter: Adapter, batch: list[Heard]) -> None:
        host, box = self.host, self._incoming
        if adapter is not self._adapter or host is None or not self.on_bus:
            return
        ahead_ns = self.timeline.now_ns - monotonic_ns()
        for heard in batch:
            if heard.error is not None:
                self._error(*heard.error)
                continue
            if heard.own or heard.record in self._echoes:
                with suppress(ValueError):
                    self._echoes.remove(heard.record)
                continue
            self._received += 1
            at_ns = heard.arrived_ns
            if heard.stamp_ns:
                at_ns = self._clock.host_ns(heard.stamp_ns, heard.arrived_ns)
            self._last_ns = max(self._last_ns, ahead_ns + at_ns)
            box.block[:] = heard.record
            host.received(box, self._last_ns)

    def _error(self, id: int, data: bytes) -> None:
        if not self._kind.classes:
            self.bus_error(ErrorKind.OTHER)
            return
        try:
            event = decode_error_frame(id, data)
        except BadText:
            return
        self._tec, self._rec = event.tec or self._tec, event.rec or self._rec
        if event.kind is EventKind.STATE:
            self.now_in(event.state)
        elif event.kind is EventKind.ERROR:
            self.bus_error(event.error, bit=event.bit, transmitting=event.transmitting)
        elif event.kind is EventKind.ARBITRATION_LOST:
            self.arbitration_lost(event.bit, transmitting=event.transmitting)
        elif event.kind is EventKind.INFO:  # restarted
            self.now_in(ErrorState.ERROR_ACTIVE)
        else:
            self.tell(event.kind, event.error, bit=event.bit, transmitting=event.transmitting)
