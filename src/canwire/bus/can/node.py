"""The interface between a bus and its nodes.

A `Node` is one controller as its bus sees it: the bus reads its attributes and calls its methods, and a chip
implements them. The bus does not know how a chip is built, and this file knows no registers.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire import _mem
from canwire.timeline import NEVER, Source, Timeline
from canwire.values.record import RECORD_SIZE

if TYPE_CHECKING:
    from canwire.values.timing.check import NodeTiming

# effect of a detected error on the counters, by the numbers of reference/can-protocol.md section 7
NO_RULE = 0
RECEIVE_ERROR = 1
DOMINANT_AFTER_FLAG = 2
TRANSMIT_ERROR = 3
FLAG_BIT_ERROR_TRANSMITTER = 4
FLAG_BIT_ERROR_RECEIVER = 5
LONG_DOMINANT_TRANSMITTER = 6
LONG_DOMINANT_RECEIVER = 7
RECEIVED = 8

# Node.fd
CLASSIC_ONLY = 0
ISO_FD = 1
NON_ISO_FD = 2


# Bus.activity
QUIET = 0
RECEIVED_LAST = 1
SENT = 2
RECEIVING = 3
SENDING = 4
FAILED = 5

_NOWHERE = memoryview(bytearray(RECORD_SIZE))


class Mailbox:
    """One frame in a controller, and what the wire needs to know of it.

    `words` is its 80-byte record. `key` is its arbitration field, most significant bit first, so
    that the lowest key wins; `bits` its length from SOF to the end of EOF and `data_bits` those of
    them that follow BRS up to the end of the CRC, both at the sender's present error state.
    """

    def __cinit__(self) -> None:
        """Compiled: give an object that is never initialised a record, so that its use cannot crash the interpreter."""
        self.words = _mem.words_of(_NOWHERE)

    def __init__(self) -> None:
        self.block = bytearray(RECORD_SIZE)
        self.words = _mem.words_of(self.block)
        self.key = 0
        self.bits = 0
        self.data_bits = 0
        self.ready_ns = 0
        self.occupied = False
        self.esi_added = False
        self.single_shot = False
        self.abort_on_error = False
        self.owner: Any = None

    def record(self) -> bytes:
        return bytes(self.block)


class Sink:
    """The destination of received frames, if no object between the node and the bus needs to see them."""

    def deliver(self, box: Mailbox, at_ns: int, flags: int) -> None:
        """Deliver a frame; `box` is valid until this returns, `flags` are additional info bits for its record."""
        raise NotImplementedError


class Node:
    """One controller on a bus.

    The bus reads: `on_bus` (started, integrated, not bus-off), `listen_only`, `self_test` (needs no acknowledge),
    `passive`, `fd`, `offer` (the mailbox to send next, or None), `tainted` (its REC is not 0), `suspended_ns` (it sends
    no SOF before), `waiting` and `sequences` (how many runs of 11 recessive bits it needs to join, and has seen),
    `asleep` (neither on the bus nor waiting: the bus only calls its `woken`), and the timing in
    picoseconds, by its own oscillator. It reads its levels back `loop_ps` late. One that `compensates`
    checks its own bits of the data phase `second_sample_ps` after the delay that it `measures_delay`, and
    `least_second_ps` after their start at the least; if it measures none, `second_sample_ps` after their start.
    While it waits for the bus an `edge_filter` ignores dominant time of less than two quanta. In `restricted` operation
    it sends no flags, and offers nothing. With `protocol_exception` it leaves a frame alone whose format it does not
    know: at a recessive res bit, a classic node at FDF. One with a `sample_gap_ps` samples each bit thrice, so far
    apart and the last time at its sample point, and takes what two of the samples are. One that `validates_early` is
    given a frame where receivers may take it as valid, at the sample point of the last bit but one of EOF; others get
    theirs where EOF ends. `timing` is how it was set up, for warnings of what could not work on copper; None if
    unknown.

    It writes only `contending` (the node's mailbox on the wire, until it loses), `contends` (the same of its offer,
    for as long as nobody else can look), `arbitration_losses`, `sequences`, `suspended_ns`, `waiting_from_ns` (and
    the picoseconds beyond it, `waiting_from_ps`), `counted_ns` (SOF of the last frame that was counted as received
    before its end), `stored_ns` (SOF of the last frame that it was given early), before `error` and `count`
    `segment` (which part of a frame it was, as the low bits of SJA1000's ECC tell), before `error` `read_dominant`
    (what that bit was read as), and `next_member`, which links those on the bus. A node with a `sink` has its frames
    put there and counted in `frames_received` instead of `received` being called. Only an `attentive` node gets a call
    for each lost arbitration, at the very bit; a single-shot frame makes it one.

    The bus calls the methods below in the order of bus time, with `at_ns` never decreasing for one
    node. A node may call back only what `Bus` offers.
    """

    def __init__(self) -> None:
        self.name = ""
        self.bus: Bus | None = None
        self.next_member: Node | None = None
        self.attentive = False
        self.sink: Sink | None = None
        self.frames_received = 0
        self.arbitration_losses = 0
        self.on_bus = False
        self.listen_only = False
        self.passive = False
        self.tainted = False
        self.self_test = False
        self.asleep = False
        self.segment = 0
        self.read_dominant = False
        self.fd = CLASSIC_ONLY
        self.offer: Mailbox | None = None
        self.contends = False
        self.contending: Mailbox | None = None
        self.suspended_ns = 0
        self.waiting = 0
        self.sequences = 0
        self.waiting_from_ns = 0
        self.waiting_from_ps = 0
        self.counted_ns = NEVER
        self.stored_ns = NEVER
        self.bit_ps = 2_000_000
        self.sample_ps = 1_750_000
        self.quantum_ps = 125_000
        self.phase1_ps = 250_000
        self.jump_ps = 125_000
        self.data_bit_ps = 500_000
        self.data_sample_ps = 400_000
        self.data_quantum_ps = 12_500
        self.data_jump_ps = 12_500
        self.loop_ps = 0
        self.compensates = False
        self.measures_delay = True
        self.second_sample_ps = 0
        self.least_second_ps = 0
        self.edge_filter = False
        self.restricted = False
        self.validates_early = False
        self.sample_gap_ps = 0
        self.protocol_exception = False
        self.timing: NodeTiming | None = None

    def received(self, box: Mailbox, at_ns: int) -> None:
        """Called when a valid frame ended; `box` is the sender's, valid until this returns."""
        raise NotImplementedError

    def transmitted(self, box: Mailbox, at_ns: int) -> None:
        """Called when this node's frame was transmitted and acknowledged."""
        raise NotImplementedError

    def arbitration_lost(self, box: Mailbox, bit: int, at_ns: int) -> None:
        """Called when a lower arbitration field won; `bit` is where, 0..31 as in SJA1000's ALC, `at_ns` the SOF."""
        raise NotImplementedError

    def error(self, kind: int, bit: int, transmitting: bool, rule: int, at_ns: int) -> None:
        """Called when an error (ErrorKind) was detected at frame bit `bit`; counter rule `rule` must be applied."""
        raise NotImplementedError

    def count(self, rule: int, at_ns: int) -> None:
        """Apply a counter rule that belongs to no new error."""
        raise NotImplementedError

    def joined(self, at_ns: int) -> None:
        """Called when the node has seen 11 (after bus-off 128 x 11) recessive bits; it is on the bus again."""
        raise NotImplementedError

    def woken(self, at_ns: int) -> None:
        """Called when the node was asleep, and an SOF (or a short) has come."""
        raise NotImplementedError


NOBODY = Node()  # whom what was never initialised belongs to


class Bus(Source):
    """The methods of its bus that a node may call; `timeline` holds the present time."""

    timeline: Timeline

    def poll(self, node: Node) -> None:
        """Announce an offer of a node that had none; not needed from inside the methods above."""
        raise NotImplementedError

    def interrupt(self) -> None:
        """Prepare a change of a node's timing, mode or part in the bus, perhaps in the middle of a frame."""
        raise NotImplementedError

    def changed(self) -> None:
        """Apply a change that `interrupt` prepared; it takes effect at this very moment."""
        raise NotImplementedError

    def on_wire(self, node: Node) -> bool:
        """Whether this node's frame is being transmitted at this moment."""
        raise NotImplementedError

    def idle(self) -> bool:
        """Whether nothing is on the wire, and the intermission is over."""
        raise NotImplementedError

    def activity(self, node: Node) -> int:
        """What a node on the bus is doing.

        RECEIVING or SENDING a frame, FAILED from its error or overload flag to the end of the delimiter,
        RECEIVED_LAST or SENT in the intermission after these, QUIET otherwise.
        """
        raise NotImplementedError

    def catch_up(self, node: Node) -> None:
        """Count, up to this moment, arbitration losses of a node that is not attentive."""
        raise NotImplementedError

    def recessive_groups(self, node: Node) -> int:
        """How many of the groups of 11 recessive bits that a waiting node needs have passed."""
        raise NotImplementedError
