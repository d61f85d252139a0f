"""One node of a LIN bus, bit by bit: its position in a frame, its transmitter and its receiver."""

from __future__ import annotations

from canwire.bus.lin.bits import wake_fields
from canwire.bus.lin.node import LinNode, LinOffer, LinResponse
from canwire.bus.lin.receiver import ASLEEP, DEAF, IN_DATA, IN_SYNC, LISTENING, OFF, LinReceiver, Listener
from canwire.bus.lin.sender import LinSender
from canwire.bus.lin.wire import NO_RESPONSE, Outgoing, Wire
from canwire.values.lin.event import LinErrorKind
from canwire.values.lin.frame import LARGEST_ID, protected_id
from canwire.values.lin.timing import longest_response_bits

_RESTING = (DEAF, ASLEEP, LISTENING)
_NONE = LinErrorKind.NONE


class LinStation(Listener):
    """Transmitter, receiver and the frame in progress; `at_ps` of every call is bus time."""

    def __init__(self, node: LinNode, wire: Wire, at_ps: int) -> None:
        self.node = node
        self.offer: LinOffer | None = None
        self.sender = LinSender()
        self.receiver = LinReceiver(node, self)
        self._wire = wire
        self._told = False
        self._response: LinResponse | None = None
        self._id = -1
        self._octets = bytearray()
        self._expected = 0
        self.rest(at_ps)

    # for the bit level

    def at_rest(self) -> bool:
        """Whether the node neither sends nor is in a frame."""
        return not self.sender.active and self.receiver.mode in _RESTING

    def stands_by(self) -> bool:
        """Whether a header has ended, no byte of a response has come, and the node needs no response."""
        waits = self.receiver.mode == IN_DATA and not self._octets
        return waits and not self._expected and self.offer is None

    def rest(self, at_ps: int) -> None:
        """Wait for the next frame, or if asleep for a wake-up; the node receives nothing until it has started up."""
        ready_ps = self.node.ready_ns * 1000
        if self.node.asleep:
            self.receiver.follow(ASLEEP)
        elif ready_ps > at_ps:
            self.receiver.follow(DEAF, ready_ps)
        else:
            self.receiver.follow(LISTENING)

    def obey(self, at_ps: int) -> None:
        """Follow the node, which may have fallen asleep or woken up."""
        if self.at_rest() and self.node.asleep != (self.receiver.mode == ASLEEP):
            self.rest(at_ps)

    def begin(self, offer: LinOffer, at_ps: int) -> None:
        """Send the node's offer."""
        self.offer = offer
        going_out = Outgoing(wake_fields()) if offer.wake_up else self._wire.header(self.node, offer.id)
        self._send(going_out, self.node.bit_ps, at_ps)

    def enter(
        self, id: int, offer: LinOffer | None, response: LinResponse | None, bit_ps: int, at_ps: int
    ) -> None:
        """Begin a response after the header, which ended at `at_ps`: send this one, or receive one."""
        self.offer = offer
        self.receiver.bit_ps = bit_ps
        self._id = id
        self._octets.clear()
        going_out = None if response is None else self._wire.response(response)
        if response is not None and going_out is not None:
            self._response = response
            self._send(going_out, bit_ps, at_ps)
        else:
            self._expected = self.node.lengths[id] if offer is None else offer.length
            limit_ps = at_ps + longest_response_bits(self._expected) * bit_ps
            self.receiver.await_response(limit_ps)

    def act(self, wire: int, at_ps: int) -> None:
        """Process the event that is due."""
        if self.sender.due_ps <= at_ps:
            done = self.sender.act(wire)
            if self.sender.failure is not _NONE and not self._told:
                self._told = True
                self.node.error(self.sender.failure, self._about(), True, nanoseconds(at_ps))
            if done:
                self._sent(at_ps)
            elif self.sender.failure is LinErrorKind.NOBUS:
                self._close(at_ps)
        elif self.receiver.due_ps <= at_ps:
            self.receiver.act(wire, at_ps)

    def leave(self) -> None:
        """Stop driving the wire: the node is detached."""
        self.sender.stop()

    # calls of the receiver

    def broke(self, at_ps: int) -> None:
        self._wire.planned = NO_RESPONSE
        if self._id >= 0:
            self.late(at_ps)

    def lost(self, field: int, at_ps: int) -> None:
        kind = LinErrorKind.SYNC if field == IN_SYNC else LinErrorKind.OTHER
        if not self.node.searching:
            self.node.error(kind, self._id, False, nanoseconds(at_ps))
        self._close(at_ps)

    def parity_wrong(self, pid: int, at_ps: int) -> None:
        self.node.error(LinErrorKind.PARITY, pid & LARGEST_ID, False, nanoseconds(at_ps))
        self._close(at_ps)

    def header(self, pid: int, at_ps: int) -> None:
        id = pid & LARGEST_ID
        self.node.headers += 1
        response = self.node.responses[id]
        if self.offer is not None and self.offer.response is not None:
            response = self.offer.response
        self.enter(id, self.offer, response, self.receiver.bit_ps, at_ps)

    def octet(self, value: int, at_ps: int) -> None:
        self._octets.append(value)
        length = self._expected or self._wire.planned
        if len(self._octets) == length + 1:
            self.node.received(LinResponse.heard(self._id, bytes(self._octets)), nanoseconds(at_ps))
            self._close(at_ps)

    def late(self, at_ps: int) -> None:
        if self._octets or self._expected or self.offer is not None:
            self.node.unanswered(self._id, len(self._octets), nanoseconds(at_ps))
        self._close(at_ps)

    def woken(self, at_ps: int) -> None:
        self.node.woken(nanoseconds(at_ps))

    def rate_found(self, bit_ps: int, at_ps: int) -> None:
        self.node.rate_found(bit_ps, nanoseconds(at_ps))

    # sending

    def _send(self, going_out: Outgoing, bit_ps: int, at_ps: int) -> None:
        self._told = False
        self.receiver.follow(OFF)
        self.sender.start(going_out.fields, bit_ps, at_ps, going_out.flips)

    def _sent(self, at_ps: int) -> None:
        if self.sender.failure is _NONE:
            if self._response is not None:
                self.node.transmitted(self._response, nanoseconds(at_ps))
                self._wire.transmitted(self.node, self._response, nanoseconds(at_ps))
            elif self.offer is not None and not self.offer.wake_up:
                self.receiver.bit_ps = self.node.bit_ps
                self.header(protected_id(self.offer.id), at_ps)
                return
        self._close(at_ps)

    def _about(self) -> int:
        """The identifier of the frame that is being sent."""
        if self._id < 0 and self.offer is not None and not self.offer.wake_up:
            return self.offer.id
        return self._id

    def _close(self, at_ps: int) -> None:
        """End the frame for this node."""
        self._id = -1
        self._expected = 0
        self._response = None
        self._octets.clear()
        self.rest(at_ps)
        offer, self.offer = self.offer, None
        if offer is not None:
            self.node.finished(offer, nanoseconds(at_ps))
            self.obey(at_ps)


def nanoseconds(ps: int) -> int:
    """The nearest whole nanosecond."""
    return (ps + 500) // 1000
