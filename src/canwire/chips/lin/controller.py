# cython: boundscheck=True
"""The ideal LIN controller, master or slave: a response table, one transmit buffer, sleep and wake-up.

Received frames go to a `LinEar`, everything else to a `LinHost` (host.py).

Source: LIN 2.2A 2; VCI V4 manual 5.3.3; reference/lin-protocol.md sections 6 to 8.
"""

from __future__ import annotations

from canwire.bus.lin.node import IDENTIFIERS, LinNode, LinOffer, LinResponse
from canwire.chips.lin.host import LinEar, LinHost
from canwire.chips.lin.responses import ResponseTable
from canwire.values.lin.event import (
    BUS_OFF_STATUS,
    ERROR_LIMIT_STATUS,
    STOPPED_STATUS,
    LinErrorKind,
    LinOutcome,
    LinState,
)
from canwire.values.lin.frame import MASTER_REQUEST
from canwire.values.lin.timing import FIELD_BITS

_ANSWERED, _SILENT, _FAILED = LinOutcome.ANSWERED, LinOutcome.SILENT, LinOutcome.FAILED
_BIT, _OTHER, _NOBUS = int(LinErrorKind.BIT), int(LinErrorKind.OTHER), int(LinErrorKind.NOBUS)
_CHKSUM, _SLNORE = int(LinErrorKind.CHKSUM), int(LinErrorKind.SLNORE)
_IN_RESPONSE = (_BIT, _CHKSUM, _OTHER)
ERROR_LIMIT = 255  # of an 8-bit error counter
_RESERVED = 0x3E


class LinController(LinNode):
    """A response table, a transmit buffer, and error detection.

    `errors` counts by LinErrorKind. What is to be sent waits in the buffer until the wire is free.
    """

    def __init__(self, host: LinHost, ear: LinEar) -> None:
        super().__init__()
        self.host = host
        self.ear = ear
        self.running = False
        self.frames_sent = 0
        self.frames_received = 0
        self.wake_ups = 0
        self.errors = [0] * len(LinErrorKind)
        self.table = ResponseTable()
        self.responses = self.table.responses
        self._bus_off = False
        self._driven = True
        self._start_up_ns = 0
        self._silence_is_fine = False
        self._outcome = _FAILED
        self._headers: dict[int, LinOffer] = {}

    # the host's side

    def configure(
        self,
        bit_ps: int,
        *,
        synchronises: bool,
        searching: bool,
        header: tuple[int, int, int],
        response_spaces: tuple[int, int],
        start_up_ns: int,
    ) -> None:
        """Bits of break, delimiter and space in headers, of space and gaps in responses; effective immediately."""
        self._interrupt()
        self.bit_ps = bit_ps
        self.synchronises = synchronises
        self.searching = searching
        self.break_bits, self.delimiter_bits, self.space_bits = header
        self.header_bits = sum(header) + 2 * FIELD_BITS
        self._start_up_ns = start_up_ns
        self.table.spaces = response_spaces
        self.table.refill()
        self._changed()

    def start(self, at_ns: int) -> None:
        """Join the bus, awake, with cleared counters; it receives nothing until it has started up."""
        self._interrupt()
        self.frames_sent = self.frames_received = self.headers = self.wake_ups = 0
        self.errors = [0] * len(LinErrorKind)
        self.running = self.on_bus = True
        self._bus_off = False
        self.table.set_response_error(False)
        self._wake(at_ns)
        self.host.state_changed(at_ns)

    def stop(self, at_ns: int) -> None:
        """Leave the bus immediately, even in the middle of a bit; the transmit buffer is discarded."""
        if not self.running:
            return
        self._interrupt()
        self.running = self.on_bus = self.asleep = False
        offer, self.offer = self.offer, None
        self._changed()
        self.host.state_changed(at_ns)
        if offer is not None:
            self.host.finished(offer.id, _FAILED, at_ns)

    def clear(self) -> None:
        """Empty the response table and discard all settings of frames."""
        self._interrupt()
        self.table.clear()
        self.lengths = [0] * IDENTIFIERS
        self.models = [None] * IDENTIFIERS
        self._changed()

    def subscribe(self, id: int, length: int) -> None:
        """Set the length of a frame, whose absence is then an error; 0: any length, and absence is no error."""
        self._interrupt()
        self.lengths[id] = length
        self._changed()

    def ask(self, id: int, length: int, silence_is_fine: bool) -> None:
        """Send a header that another node answers with `length` bytes (0: any number); the buffer must be free."""
        offer = self._headers.get(id << 4 | length)
        if offer is None:
            offer = self._headers[id << 4 | length] = LinOffer(id, length)
        self._silence_is_fine = silence_is_fine
        self._put(offer)

    def send(self, id: int, data: bytes, enhanced: bool) -> None:
        """Send a header followed by these data; the buffer must be free."""
        self._silence_is_fine = False
        self._put(LinOffer(id, 0, self.table.make(id, data, enhanced)))

    def wake_up(self) -> None:
        """Send a wake-up pulse; the buffer must be free."""
        self._put(LinOffer(-1, wake_up=True))

    def sleep(self, at_ns: int) -> None:
        """Fall asleep: ignore everything except a wake-up."""
        if self.running and not self.asleep:
            self._interrupt()
            self.asleep = True
            self._changed()
            self.host.state_changed(at_ns)

    def state(self, at_ns: int) -> LinState:
        """The controller's state at this moment."""
        if not self.running:
            return LinState.STOPPED
        if self.asleep:
            return LinState.ASLEEP
        return LinState.INITIALISING if self.ready_ns > at_ns else LinState.OPERATIONAL

    def status(self) -> int:
        """VCI's LIN_STATUS_ bits, without the overrun, which only the line knows."""
        limit = ERROR_LIMIT_STATUS if sum(self.errors) >= ERROR_LIMIT else 0
        off = BUS_OFF_STATUS if self._bus_off else 0
        return limit | off | (0 if self.running else STOPPED_STATUS)

    # the bus's side

    def received(self, response: LinResponse, at_ns: int) -> None:
        id, enhanced = response.id, response.enhanced
        model = self.models[id]
        if enhanced is None or (model is not None and enhanced is not model):
            self._outcome = _FAILED
            self._count(_CHKSUM, id, False, at_ns)
            return
        self._outcome = _ANSWERED
        self.frames_received += 1
        if self.ear.hears:
            self.ear.deliver(response, at_ns)
        if response.id == MASTER_REQUEST and response.octets[0] == 0:
            self.sleep(at_ns)

    def transmitted(self, response: LinResponse, at_ns: int) -> None:
        self._outcome = _ANSWERED
        self.frames_sent += 1
        table = self.table
        if response.id in table.updated or response.id in table.watched:
            table.sent(response.id)
        if self.ear.hears_own:
            self.ear.deliver_sent(response, at_ns)
        if response.id == MASTER_REQUEST and response.octets[0] == 0:
            self.sleep(at_ns)

    def unanswered(self, id: int, received: int, at_ns: int) -> None:
        self._outcome = _FAILED if received else _SILENT
        if received:
            self._count(_OTHER, id, False, at_ns)
        elif self.offer is None or not self._silence_is_fine:
            self._count(_SLNORE, id, False, at_ns)

    def error(self, kind: int, id: int, transmitting: bool, at_ns: int) -> None:
        self._outcome = _FAILED
        before = self.status()
        if kind == _NOBUS:
            self._bus_off = True
            self._driven = False
        self._count(kind, id, transmitting, at_ns, before)

    def finished(self, offer: LinOffer, at_ns: int) -> None:
        self.offer = None
        outcome = self._outcome
        if offer.wake_up:
            outcome = _ANSWERED
            if self.asleep:
                self._wake(at_ns)
                self.host.state_changed(at_ns)
        elif self._bus_off and self._driven:
            self._bus_off = False
            self.host.state_changed(at_ns)
        self.host.finished(offer.id, outcome, at_ns)

    def woken(self, at_ns: int) -> None:
        self.wake_ups += 1
        self._wake(at_ns)
        self.host.woken(at_ns)

    def quiet(self, at_ns: int) -> None:
        self._count(_NOBUS, -1, False, at_ns)
        self.sleep(at_ns)

    def rate_found(self, bit_ps: int, at_ns: int) -> None:
        self.bit_ps = bit_ps
        self.searching = False
        self._changed()
        self.host.state_changed(at_ns)

    # between the two

    def _put(self, offer: LinOffer) -> None:
        bus = self.bus
        if self.asleep and bus is not None and not offer.wake_up:
            self._interrupt()
            self._wake(bus.now_ns())
            self.host.state_changed(bus.now_ns())
        self._outcome = _FAILED
        self._driven = True
        self.offer = offer
        if bus is not None:
            bus.poll(self)

    def _wake(self, at_ns: int) -> None:
        self.asleep = False
        self.awake_since_ns = at_ns
        self.ready_ns = at_ns + self._start_up_ns
        self._changed()

    def _count(self, kind: int, id: int, transmitting: bool, at_ns: int, before: int = -1) -> None:
        if before < 0:
            before = self.status()
        self.errors[kind] += 1
        if kind in _IN_RESPONSE and self._is_mine(id, transmitting):
            self.table.set_response_error(True)
        self.host.error(kind, id, transmitting, at_ns)
        if self.status() != before:
            self.host.state_changed(at_ns)

    def _is_mine(self, id: int, transmitting: bool) -> bool:  # for the response-error bit
        if not 0 <= id < _RESERVED or self.table.is_event(id):
            return False
        return (transmitting and self.responses[id] is not None) or self.lengths[id] > 0

    def _interrupt(self) -> None:
        if self.bus is not None:
            self.bus.interrupt()

    def _changed(self) -> None:
        if self.bus is not None:
            self.bus.changed()
