"""The interface between a LIN bus and its nodes.

A `LinNode` is one controller as the wire sees it: a bus reads its attributes and calls its methods, a chip
fills them in. Nothing above knows how a chip is built.
"""

from __future__ import annotations

from canwire.timeline import Source
from canwire.values.lin.frame import lin_checksum, protected_id
from canwire.values.lin.record import ENHANCED, LENGTH_SHIFT, SENT, record_tail
from canwire.values.lin.timing import FIELD_BITS, HEADER_BITS

IDENTIFIERS = 64


class LinResponse:
    """The bytes that answer a header, with the properties that a record stores.

    `octets` are data and checksum. `enhanced` says which checksum fits, None when neither does. `bits` is the
    length on the wire from the end of the header, `space_bits` of them before the first byte, and `gap_bits` between
    any two. `tail` and `sent_tail` are its records behind their time word, as others and as its sender see it.
    """

    __slots__ = ("bits", "enhanced", "gap_bits", "id", "length", "octets", "sent_tail", "space_bits", "tail")

    def __init__(
        self, id: int, octets: bytes, enhanced: bool | None, *, space_bits: int = 0, gap_bits: int = 0
    ) -> None:
        self.id = id
        self.octets = octets
        self.enhanced = enhanced
        self.length = len(octets) - 1
        self.space_bits = space_bits
        self.gap_bits = gap_bits
        self.bits = space_bits + FIELD_BITS * len(octets) + gap_bits * self.length
        info = protected_id(id) | self.length << LENGTH_SHIFT | (ENHANCED if enhanced else 0)
        self.tail = record_tail(info, octets[:-1], octets[-1])
        self.sent_tail = record_tail(info | SENT, octets[:-1], octets[-1])

    @classmethod
    def to_send(
        cls, id: int, data: bytes, enhanced: bool, *, space_bits: int = 0, gap_bits: int = 0
    ) -> LinResponse:
        """These data with the checksum that goes with them."""
        checksum = lin_checksum(data, protected_id(id) if enhanced else 0)
        return cls(id, data + bytes([checksum]), enhanced, space_bits=space_bits, gap_bits=gap_bits)

    @classmethod
    def heard(cls, id: int, octets: bytes) -> LinResponse:
        """Bytes as they came over the wire, with the checksum that fits; the receiver knows which one is right."""
        data, checksum = octets[:-1], octets[-1]
        if checksum == lin_checksum(data):
            return cls(id, octets, False)
        enhanced = id not in _ALWAYS_CLASSIC and checksum == lin_checksum(data, protected_id(id))
        return cls(id, octets, True if enhanced else None)


class LinOffer:
    """What a node wants to put on the wire next: a header, with its own response or without, or a wake-up pulse.

    `length` is how many bytes another node's response must have, 0 for as many as come.
    """

    __slots__ = ("id", "length", "response", "wake_up")

    def __init__(
        self, id: int, length: int = 0, response: LinResponse | None = None, *, wake_up: bool = False
    ) -> None:
        self.id = id
        self.length = length
        self.response = response
        self.wake_up = wake_up


class LinNode:
    """One controller on a bus.

    The bus reads: `on_bus` (started), `asleep`, `ready_ns` (deaf before), `awake_since_ns`, `offer`, the table of
    `responses`, `lengths` (of the frames that it subscribes to, 0 elsewhere), and the timing: `bit_ps` by its own
    oscillator, `synchronises` (it follows the master's bit rate by the sync field), `searching` (it does not
    know the bit rate yet), and of its headers `break_bits`, `delimiter_bits` and `space_bits` before the identifier.

    `models` are for the node itself: which checksum it takes of a frame (True: enhanced alone, None: either).

    The bus writes only `headers`, the number of valid ones so far.

    The bus calls the methods below in the order of bus time. A node may call back only what `LinMedium` offers.
    """

    def __init__(self) -> None:
        self.name = ""
        self.bus: LinMedium | None = None
        self.on_bus = False
        self.asleep = False
        self.ready_ns = 0
        self.awake_since_ns = 0
        self.offer: LinOffer | None = None
        self.responses: list[LinResponse | None] = [None] * IDENTIFIERS
        self.lengths = [0] * IDENTIFIERS
        self.models: list[bool | None] = [None] * IDENTIFIERS
        self.headers = 0
        self.synchronises = False
        self.searching = False
        self.bit_ps = 52_083_333
        self.break_bits = 13
        self.delimiter_bits = 1
        self.space_bits = 0
        self.header_bits = HEADER_BITS

    def received(self, response: LinResponse, at_ns: int) -> None:
        """A whole response came in; its checksum may be wrong."""
        raise NotImplementedError

    def transmitted(self, response: LinResponse, at_ns: int) -> None:
        """This node's response went out undisturbed."""
        raise NotImplementedError

    def unanswered(self, id: int, received: int, at_ns: int) -> None:
        """The time for a response is over and `received` bytes came; called for the master and subscribers."""
        raise NotImplementedError

    def error(self, kind: int, id: int, transmitting: bool, at_ns: int) -> None:
        """Something went wrong (LinErrorKind) with the frame `id`, -1 where it is not known."""
        raise NotImplementedError

    def finished(self, offer: LinOffer, at_ns: int) -> None:
        """This node's transmission is over; the calls above have reported the result."""
        raise NotImplementedError

    def woken(self, at_ns: int) -> None:
        """A dominant pulse ended that wakes a sleeping node up."""
        raise NotImplementedError

    def quiet(self, at_ns: int) -> None:
        """There has been no edge on the wire for 4 s."""
        raise NotImplementedError

    def rate_found(self, bit_ps: int, at_ns: int) -> None:
        """A searching node has measured the bit time by a sync field."""
        raise NotImplementedError


class LinMedium(Source):
    """What a node may ask of its bus."""

    def now_ns(self) -> int:
        """The timeline's time."""
        raise NotImplementedError

    def load_percent(self) -> float:
        """Busy time over elapsed time in the last second, 0..100 %."""
        raise NotImplementedError

    def poll(self, node: LinNode) -> None:
        """The node has an offer where it had none."""
        raise NotImplementedError

    def interrupt(self) -> None:
        """A node is about to change its timing or its part in the bus, perhaps in the middle of a frame."""
        raise NotImplementedError

    def changed(self) -> None:
        """It has; takes effect at this very moment."""
        raise NotImplementedError

    def foreseen_ns(self, sender: LinNode, id: int) -> int:
        """How long a header of this node and its response will take in the present state; 0 if that is unknown."""
        raise NotImplementedError

    def on_wire(self, node: LinNode) -> bool:
        """This node is sending, or waits for the response to its header, at this moment."""
        raise NotImplementedError


_ALWAYS_CLASSIC = (0x3C, 0x3D)
