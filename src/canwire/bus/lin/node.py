# cython: boundscheck=True
"""The interface between a LIN bus and its nodes.

A `LinNode` is one controller as its bus sees it: the bus reads its attributes and calls its methods, and a chip
implements them. The bus does not know how a chip is built.
"""

from __future__ import annotations

from canwire.timeline import Source
from canwire.values.lin.frame import lin_checksum, protected_id
from canwire.values.lin.record import ENHANCED, LENGTH_SHIFT, SENT, TIME_SIZE, record_tail
from canwire.values.lin.timing import FIELD_BITS, HEADER_BITS

IDENTIFIERS = 64


class LinResponse:
    """The bytes that answer a header, with the properties that a record stores.

    `octets` are data and checksum. `enhanced` says which checksum is right, None if neither is. `bits` is the
    length on the wire from the end of the header, `space_bits` of them before the first byte, and `gap_bits` between
    any two. `record` and `sent_record` are its records, whose time is 0, as for receivers and its sender.
    """

    __slots__ = (
        "bits",
        "enhanced",
        "gap_bits",
        "id",
        "length",
        "octets",
        "record",
        "sent_record",
        "space_bits",
    )

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
        data, checksum = octets[: self.length], octets[self.length]
        self.record = bytearray(TIME_SIZE) + record_tail(info, data, checksum)
        self.sent_record = bytearray(TIME_SIZE) + record_tail(info | SENT, data, checksum)

    @classmethod
    def to_send(
        cls, id: int, data: bytes, enhanced: bool, *, space_bits: int = 0, gap_bits: int = 0
    ) -> LinResponse:
        """A response with these data and the checksum that belongs to them."""
        checksum = lin_checksum(data, protected_id(id) if enhanced else 0)
        return cls(id, data + bytes([checksum]), enhanced, space_bits=space_bits, gap_bits=gap_bits)

    @classmethod
    def heard(cls, id: int, octets: bytes) -> LinResponse:
        """A response with bytes as received from the wire; `enhanced` is set by the checksum that is right."""
        data, checksum = octets[: len(octets) - 1], octets[len(octets) - 1]
        if checksum == lin_checksum(data):
            return cls(id, octets, False)
        enhanced = id not in _ALWAYS_CLASSIC and checksum == lin_checksum(data, protected_id(id))
        return cls(id, octets, True if enhanced else None)


class LinOffer:
    """The next transmission of a node: a header, with its own response or without, or a wake-up pulse.

    `length` is how many bytes another node's response must have, 0 for any number.
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

    __slots__ = ("asleep", "awake_since_ns", "bit_ps", "break_bits", "bus", "delimiter_bits", "header_bits",
                 "headers", "lengths", "models", "name", "offer", "on_bus", "ready_ns", "responses",
                 "searching", "space_bits", "synchronises")  # fmt: skip

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
        """Called when a whole response was received; its checksum may be wrong."""
        raise NotImplementedError

    def transmitted(self, response: LinResponse, at_ns: int) -> None:
        """Called when this node's response was sent undisturbed."""
        raise NotImplementedError

    def unanswered(self, id: int, received: int, at_ns: int) -> None:
        """Called for the master and subscribers when the time for a response is over; `received` bytes came."""
        raise NotImplementedError

    def error(self, kind: int, id: int, transmitting: bool, at_ns: int) -> None:
        """Called at an error (LinErrorKind) in the frame `id`, -1 if that is not known."""
        raise NotImplementedError

    def finished(self, offer: LinOffer, at_ns: int) -> None:
        """Called when this node's transmission is over; the calls above have reported the result."""
        raise NotImplementedError

    def woken(self, at_ns: int) -> None:
        """Called at the end of a dominant pulse that wakes a sleeping node."""
        raise NotImplementedError

    def quiet(self, at_ns: int) -> None:
        """Called when the wire has had no edge for 4 s."""
        raise NotImplementedError

    def rate_found(self, bit_ps: int, at_ns: int) -> None:
        """Called when a searching node has measured the bit time in a sync field."""
        raise NotImplementedError


class LinMedium(Source):
    """The methods of its bus that a node may call."""

    def now_ns(self) -> int:
        """The timeline's time."""
        raise NotImplementedError

    def load_percent(self) -> float:
        """Busy time over elapsed time in the last second, 0..100 %."""
        raise NotImplementedError

    def poll(self, node: LinNode) -> None:
        """Announce an offer of a node that had none."""
        raise NotImplementedError

    def interrupt(self) -> None:
        """Prepare a change of a node's timing or of its part in the bus, perhaps in the middle of a frame."""
        raise NotImplementedError

    def changed(self) -> None:
        """Apply a change that `interrupt` prepared; it takes effect at this very moment."""
        raise NotImplementedError

    def foreseen_ns(self, sender: LinNode, id: int) -> int:
        """How long a header of this node and its response will take in the present state; 0 if that is unknown."""
        raise NotImplementedError

    def on_wire(self, node: LinNode) -> bool:
        """Whether this node is sending, or waits for the response to its header, at this moment."""
        raise NotImplementedError


_ALWAYS_CLASSIC = (0x3C, 0x3D)
