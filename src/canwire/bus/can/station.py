# cython: nonecheck=False
"""The protocol machine of one node, bit by bit: what ISO 11898-1 calls medium access control.

A `Station` gets the level at each of its sample points and sets the level that it drives in its next bit. It knows
no time but `now_ns`, which its owner (bit_level.py) keeps up to date; bit_level.py has clocks, the wire and
disturbances. The node has the error counters and their consequences.
Source: ISO 11898-1:2015 chapters 8 and 10; Bosch CAN FD 1.0; reference/can-protocol.md sections 1 to 7.
"""

from __future__ import annotations

from canwire.bus.can import bits as can_bits
from canwire.bus.can import frame_reader as fields
from canwire.bus.can import node as seam
from canwire.bus.can import reader_state
from canwire.bus.can.bit_layout import KeptLayout
from canwire.bus.can.frame_reader import FrameReader
from canwire.bus.can.node import NOBODY, Mailbox, Node
from canwire.bus.can.tally import Tally
from canwire.values.checks import instance

# states
(
    IDLE, FRAME, ACTIVE_FLAG, PASSIVE_FLAG, FLAG_WAIT, DELIMITER, OVERLOAD_FLAG, INTERMISSION, SUSPEND, WAITING,
) = range(10)  # fmt: skip
_IDLE, _FRAME, _ACTIVE_FLAG, _PASSIVE_FLAG, _FLAG_WAIT = IDLE, FRAME, ACTIVE_FLAG, PASSIVE_FLAG, FLAG_WAIT
_DELIMITER, _OVERLOAD_FLAG, _INTERMISSION, _SUSPEND, _WAITING = (
    DELIMITER, OVERLOAD_FLAG, INTERMISSION, SUSPEND, WAITING,
)  # fmt: skip

# of frame_reader.py and node.py, as C constants
_BASE, _RTR, _IDE, _EXT, _RTR2 = fields.BASE, fields.RTR, fields.IDE, fields.EXT, fields.RTR2
_CRC_DELIMITER, _ACK, _ACK_DELIMITER = fields.CRC_DELIMITER, fields.ACK, fields.ACK_DELIMITER
_EOF, _TAKEN, _STUFF_ERROR, _FORM_ERROR = fields.EOF, fields.TAKEN, fields.STUFF_ERROR, fields.FORM_ERROR
_PROTOCOL_EXCEPTION, _FAST_FROM_HERE = fields.PROTOCOL_EXCEPTION, fields.FAST_FROM_HERE
_NO_RULE, _RECEIVED, _TRANSMIT_ERROR = seam.NO_RULE, seam.RECEIVED, seam.TRANSMIT_ERROR
_RECEIVE_ERROR, _DOMINANT_AFTER_FLAG = seam.RECEIVE_ERROR, seam.DOMINANT_AFTER_FLAG
_FLAG_TRANSMITTER, _FLAG_RECEIVER = seam.FLAG_BIT_ERROR_TRANSMITTER, seam.FLAG_BIT_ERROR_RECEIVER
_LONG_TRANSMITTER, _LONG_RECEIVER = seam.LONG_DOMINANT_TRANSMITTER, seam.LONG_DOMINANT_RECEIVER
_QUIET, _RECEIVED_LAST, _SENT = seam.QUIET, seam.RECEIVED_LAST, seam.SENT
_RECEIVING, _SENDING, _FAILED = seam.RECEIVING, seam.SENDING, seam.FAILED

# ErrorKind
_STUFF, _FORM, _ACK_ERROR, _BIT, _FAST_DATA_BIT, _CRC_ERROR = 1, 2, 3, 4, 5, 6

_FLAG_PART, _DELIMITER_PART, _OVERLOAD_PART = 0x11, 0x17, 0x1C  # as frame_reader.py's parts

_FD = 1 << 10  # of a record's info

KEEP_RATE, TO_DATA_RATE, TO_NOMINAL_RATE = range(3)
_TO_DATA_RATE, _TO_NOMINAL_RATE = TO_DATA_RATE, TO_NOMINAL_RATE


class Station:
    """The protocol machine of one node.

    `out` is the level it drives, `rate_change` what its clock must do at this sample point. `sof_seen`: an edge has
    ended its idle time. `just_free`: the present bit's sample has ended the intermission. `flagged` is true from its
    error or overload flag to the end of the intermission after it. `counted` is true once the node has counted the
    frame on the wire as received, `stored` once it has been given this frame. `levels` are those of `layout`, the frame
    that it sends or sent last.
    """

    def __cinit__(self, *_: object) -> None:
        """Compiled: nothing that C reads is None, not even in what was never initialised."""
        self._take_parts(NOBODY, Tally())

    def __init__(self, node: Node, tally: Tally) -> None:
        instance("node", node, Node)
        instance("tally", tally, Tally)
        self._take_parts(node, tally)

    def _take_parts(self, node: Node, tally: Tally) -> None:
        self.node, self.tally, self.box = node, tally, Mailbox()
        self.reader, self.layout = FrameReader(node.fd), KeptLayout()
        self.levels = self.layout.levels
        self.begin()

    def begin(self) -> None:
        """Start when the node joins the bus, or when the bus returns from whole frames."""
        node = self.node
        self.now_ns = self.sof_ns = 0
        self.state = _WAITING if node.waiting or not node.on_bus else _IDLE
        self.out = self.last_sample = self.flag_level = 1
        self.rate_change = self.index = self.run = self.left = self.dominant_run = 0
        self.fast = self.transmitting = self.just_free = self.finished = self.tec_due = False
        self.contending = node.contending
        self.sent = self.box
        # the last bit that the node waited for has been sampled, and an SOF comes before that bit is over
        self.rejoined = self.sof_seen = bool(node.waiting) and node.sequences >= node.waiting
        self.overload = self.flagged = self.counted = self.stored = False
        self.acknowledging = self.acknowledged = self.second_ack = False

    def begin_bit(self) -> None:
        """Start a bit of this node: complete what the last bit caused, then choose `out`."""
        if self.finished:
            self.deliver()
        if self.rejoined:
            self.rejoined = False
            self.state = _IDLE
            if self.node.waiting:
                self.node.joined(self.now_ns)
        if self.state == _SUSPEND and self.left == 0:
            self.state = _IDLE
        if self.state == _IDLE and not self.sof_seen:
            self.offer()
        self.just_free = False
        self.out = 1
        if self.state == _FRAME:
            if self.transmitting:
                # a second ACK bit makes an FD frame one bit longer than its sender laid it out
                self.out = self.levels[self.index] if self.index < len(self.levels) else 1
            elif self.reader.field == _ACK and self.acknowledging:
                self.out = 0
        elif self.state == _ACTIVE_FLAG or self.state == _OVERLOAD_FLAG:
            self.out = 0

    def sample(self, level: int) -> None:
        """Process the level of the bus at the node's sample point."""
        self.last_sample = level
        self.rate_change = 0
        state = self.state
        if state == _FRAME:
            self._frame_bit(level)
        elif state == _IDLE or state == _SUSPEND:
            self._idle_bit(level)
        elif state == _INTERMISSION:
            self._intermission_bit(level)
        elif state == _WAITING:
            self._waiting_bit(level)
        elif state == _DELIMITER:
            self._delimiter_bit(level)
        elif state == _PASSIVE_FLAG:
            self._passive_flag_bit(level)
        elif state == _FLAG_WAIT:
            self._after_flag_bit(level)
        else:
            self._dominant_flag_bit(level)

    def ready_to_send(self) -> bool:
        """Whether the node has an offer that may start in this bit."""
        node = self.node
        offer = node.offer
        if offer is None or not node.on_bus or node.listen_only:
            return False
        return offer.ready_ns <= self.now_ns and node.suspended_ns <= self.now_ns

    def transmits(self) -> bool:
        """Whether the node sends a frame, or an error flag that ends its own frame."""
        return self.transmitting and (self.finished or _FRAME <= self.state <= _OVERLOAD_FLAG)

    def activity(self) -> int:
        """The same as Bus.activity."""
        if self.state == _FRAME or self.finished:
            return _SENDING if self.transmitting else _RECEIVING
        if _ACTIVE_FLAG <= self.state <= _OVERLOAD_FLAG:
            return _FAILED
        if self.state == _INTERMISSION:
            return _SENT if self.transmitting or self.flagged else _RECEIVED_LAST
        return _QUIET

    def resting(self) -> bool:
        """Whether no frame or error is in progress at this node."""
        if self.finished or self.rejoined or self.sof_seen:
            return False
        return (
            self.state == _IDLE or self.state == _SUSPEND or (self.state == _WAITING and not self.node.on_bus)
        )

    def wait_for_bus(self) -> None:
        """Leave a frame or error in progress, and wait for 11 recessive bits."""
        self.state = _WAITING
        self.transmitting = self.flagged = self.sof_seen = False
        self.finished = self.just_free = self.stored = False
        self.run = 0

    def offer(self) -> None:
        """Begin to send, at a bit boundary, if the node is ready or has begun already."""
        box, self.contending = self.contending, None
        if box is not None:
            self._transmit(box)
        elif self.ready_to_send():
            self._transmit(self.node.offer)

    def _transmit(self, box: Mailbox | None) -> None:
        assert box is not None
        self.sent = self.node.contending = box
        self.sof_ns = self.now_ns
        if box.words[1] >> 32 & _FD:
            can_bits.show_error_state(box, self.node.passive, self.node.fd)
        self.layout.take(box, self.node.fd)
        self.levels = self.layout.levels
        self._begin_frame()
        self.transmitting = True
        self.sof_seen = False
        self.state = _FRAME

    def _begin_frame(self) -> None:
        self.reader.begin_for(self.node)
        self.index = 0
        self.acknowledging = self.acknowledged = self.second_ack = self.fast = self.flagged = False

    def begin_receiving(self) -> None:
        """Start to receive a frame."""
        self._begin_frame()
        self.transmitting = self.sof_seen = False
        self.state = _FRAME

    # between frames

    def _idle_bit(self, level: int) -> None:
        if level == 0:
            self.begin_receiving()
            self._frame_bit(0)  # the bit just sampled is its SOF
            return
        self.sof_seen = False
        if self.state == _SUSPEND:
            self.left -= 1

    def _intermission_bit(self, level: int) -> None:
        self.left -= 1
        if level == 0:
            if self.left > 0:
                self._overload()
            elif self.ready_to_send() and not (self.transmitting and self.node.passive):
                self._transmit(self.node.offer)  # the third bit is somebody's SOF, and counts as its own too
                self._take_bit(0, False)
            else:
                self.begin_receiving()
                self._frame_bit(0)
        elif self.left == 0:
            suspended = self.transmitting and self.node.passive
            self.transmitting = self.flagged = self.sof_seen = False
            self.state = _SUSPEND if suspended else _IDLE
            self.left = 8
            self.just_free = True

    def _waiting_bit(self, level: int) -> None:
        self.run = self.run + 1 if level else 0
        if self.run < 11:
            return
        self.run = 0
        node = self.node
        if node.on_bus:  # after a protocol exception
            self.rejoined = True
        elif node.waiting:
            node.sequences += 1
            self.rejoined = node.sequences >= node.waiting

    def deliver(self) -> None:
        """Give the node what the frame that has ended means to it."""
        self.finished = False
        if self.transmitting:
            self.tally.frames += 1
            self.tally.last_success_ns = self.now_ns
            if self.tally.tap is not None:
                self.tally.tap.transmitted(self.node, self.sent, self.now_ns)
            self.node.contending = None
            self.node.transmitted(self.sent, self.now_ns)
        elif not self.stored:
            self._hand_over()
        self.stored = False

    def _hand_over(self) -> None:
        """Give the node, or its sink, the frame that the station has received."""
        reader_state.store(self.reader, self.box.words)
        if self.node.sink is not None:
            self.node.frames_received += 1
            self.node.sink.deliver(self.box, self.now_ns, 0)
        else:
            self.node.received(self.box, self.now_ns)

    def bits_till_valid(self, left: int) -> int:
        """How many of the recessive bits up to the frame's end precede the one at which the node takes it as valid."""
        early = self.node.validates_early and not self.transmitting and not self.stored
        return left - 2 if early and left > 1 else left

    # inside a frame

    def _frame_bit(self, level: int) -> None:
        stuff_bit = self.reader.expects_stuff_bit()
        if not self.transmitting or level == self.out or self._tolerated(level, stuff_bit):
            self._take_bit(level, stuff_bit)

    def _take_bit(self, level: int, stuff_bit: bool) -> None:
        reader = self.reader
        self.index += 1
        tail = reader.field >= _CRC_DELIMITER and not stuff_bit
        outcome = reader.take(level)
        if tail:
            self._tail_bit(level)
        elif outcome != _TAKEN:
            self._react(outcome)

    def _react(self, outcome: int) -> None:
        if outcome == _FAST_FROM_HERE:
            self.fast = True
            self.rate_change = _TO_DATA_RATE
        elif outcome == _PROTOCOL_EXCEPTION:
            self.wait_for_bus()
        else:
            self._error(_STUFF if outcome == _STUFF_ERROR else _FORM, self.index - 1)

    def _tolerated(self, level: int, stuff_bit: bool) -> bool:
        """Whether a sender may read another level than it drives; if not, this handles the error."""
        field = self.reader.field
        if level == 0 and stuff_bit:
            # no counting up to RTR: after it comes IDE, which a base frame's sender drives dominant
            if _BASE <= field <= _RTR2 and (field != _IDE or self.levels[self.index + 1] == 1):
                self._error(_STUFF, self.index, exempt=True)
                return False
        elif level == 0:
            if _BASE <= field <= _RTR2:
                self._lose()
                return True
            if field == _ACK or (field == _ACK_DELIMITER and self.reader.fd):
                return True
            if field >= _CRC_DELIMITER:
                self._error(_FORM, self.index)
                return False
        self._error(_FAST_DATA_BIT if self.fast else _BIT, self.index)
        return False

    def _lose(self) -> None:
        field, left = self.reader.field, self.reader.left
        if field == _BASE:
            bit = 11 - left
        elif field == _EXT:
            bit = 31 - left
        else:
            bit = {_RTR: 11, _IDE: 12, _RTR2: 31}[field]
        self.lose_silently()
        if self.node.attentive or self.sent.single_shot:
            self.node.arbitration_lost(self.sent, bit, self.sof_ns)

    def lose_silently(self) -> None:
        """Continue as a receiver, for now without a call to the node."""
        self.transmitting = False
        self.node.contending = None
        self.node.arbitration_losses += 1

    def _tail_bit(self, level: int) -> None:
        if self.reader.field == _CRC_DELIMITER:
            if self.fast:
                self.fast = False
                self.rate_change = _TO_NOMINAL_RATE
            if level == 0:
                self._error(_FORM, self.index - 1)
                return
            self.acknowledging = self.reader.crc_ok and not self.transmitting and not self.node.listen_only
            self.reader.go_on(_ACK, 1)
        elif self.reader.field == _ACK:
            self._ack_bit(level)
        elif self.reader.field == _ACK_DELIMITER:
            self._ack_delimiter_bit(level)
        else:
            self._eof_bit(level)

    def _ack_bit(self, level: int) -> None:
        if self.transmitting:
            self.acknowledged = level == 0 or self.node.self_test
            if not self.acknowledged and not self.reader.fd:
                self._error(_ACK_ERROR, self.index - 1)
        elif self.acknowledging and level == 1:
            self._error(_BIT, self.index - 1)
        elif self.acknowledging:
            self._count_reception()
        self.reader.go_on(_ACK_DELIMITER, 1)

    def _count_reception(self) -> None:
        if self.counted:
            self.counted = False
        else:
            self.node.count(_RECEIVED, self.now_ns)

    def _ack_delimiter_bit(self, level: int) -> None:
        """Process a bit of the ACK delimiter; CAN FD tolerates an acknowledge one bit late or two bits long."""
        late = self.transmitting and not self.acknowledged
        if level == 0 and self.reader.fd and not self.second_ack:
            self.acknowledged = True
            self.second_ack = True
            self.reader.go_on(_ACK_DELIMITER, 1)
        elif late:
            self._error(_ACK_ERROR, self.index - 1)
        elif not self.reader.crc_ok and not self.transmitting:
            self._error(_CRC_ERROR, self.index - 1)
        elif level == 0:
            self._error(_FORM, self.index - 1)
        else:
            self.reader.go_on(_EOF, 7)

    def _eof_bit(self, level: int) -> None:
        if level == 0 and (self.reader.left > 0 or self.transmitting):
            self._error(_FORM, self.index - 1)
        elif self.reader.left == 0:
            self.end_frame()  # a receiver accepts even if this bit was dominant
            if level == 0:
                self._overload()
        elif self.reader.left == 1 and self.bits_till_valid(2) == 0:
            self.stored = True
            self._hand_over()

    def end_frame(self) -> None:
        """Continue with the intermission, after the last bit of EOF."""
        self.finished = True
        self.state = _INTERMISSION
        self.left = 3

    # errors

    def _error(self, kind: int, bit: int, exempt: bool = False) -> None:
        node = self.node
        passive = node.passive or node.listen_only
        rule = _TRANSMIT_ERROR if self.transmitting else _RECEIVE_ERROR
        self.tec_due = self.transmitting and passive and kind == _ACK_ERROR
        if exempt or self.tec_due or node.listen_only:
            rule = _NO_RULE
        if self.fast:
            self.fast = False
            self.rate_change = _TO_NOMINAL_RATE
        node.segment = reader_state.part(self.reader) if self.state == _FRAME else _DELIMITER_PART
        node.read_dominant = self.last_sample == 0
        self._begin_error_flag(passive)
        node.error(kind, bit, self.transmitting, rule, self.now_ns)
        node.contending = None  # a further error, in the delimiter, is not this frame's
        self._leave_if_off()

    def _begin_error_flag(self, passive: bool) -> None:
        if not self.tally.erring and not self.node.restricted:
            self.tally.erring = True
            self.tally.error_frames += 1
        self.overload = False
        self._begin_flag(_PASSIVE_FLAG if passive else _ACTIVE_FLAG)

    def _overload(self) -> None:
        self.overload = True
        self._begin_flag(_PASSIVE_FLAG if self.node.listen_only else _OVERLOAD_FLAG)

    def _begin_flag(self, state: int) -> None:
        self.state = _WAITING if self.node.restricted else state
        self.flagged = True
        self.left = 6
        self.run = 0
        self.dominant_run = 0

    def _count(self, rule: int) -> None:
        if not self.node.listen_only:
            self.node.segment = _OVERLOAD_PART if self.overload else _FLAG_PART
            self.node.count(rule, self.now_ns)
            self._leave_if_off()

    def _leave_if_off(self) -> None:
        if not self.node.on_bus:
            self.wait_for_bus()

    def _dominant_flag_bit(self, level: int) -> None:
        """Process a bit of an active error or overload flag; a bit error in it begins a new error flag."""
        self.left -= 1
        if self.left == 0:
            self.state = _FLAG_WAIT
        if level == 1:
            passive = self.node.passive
            self._count(_FLAG_TRANSMITTER if self.transmitting else _FLAG_RECEIVER)
            if self.state != _WAITING:
                self._begin_error_flag(passive)

    def _passive_flag_bit(self, level: int) -> None:
        """Process a bit of a passive error flag, which six equal bits complete: `run` of level `flag_level`."""
        self.run = self.run + 1 if self.run and level == self.flag_level else 1
        self.flag_level = level
        if level == 0 and self.tec_due:
            self.tec_due = False
            self._count(_TRANSMIT_ERROR)
        if self.run == 6 and self.state == _PASSIVE_FLAG:
            self.state = _FLAG_WAIT
            self.tec_due = False  # later flags are not the missing acknowledge's

    def _after_flag_bit(self, level: int) -> None:
        if level == 1:
            self.state = _DELIMITER
            self.left = 7
            return
        self.dominant_run += 1
        if self.dominant_run == 1 and not self.transmitting and not self.overload:
            self._count(_DOMINANT_AFTER_FLAG)
        if self.dominant_run % 8 == 0:
            self._count(_LONG_TRANSMITTER if self.transmitting else _LONG_RECEIVER)

    def _delimiter_bit(self, level: int) -> None:
        self.left -= 1
        if level == 0:
            if self.left:
                self._error(_FORM, self.index)
            else:
                self._overload()
        elif self.left == 0:
            self.tally.erring = False  # the error frame that all of them made is complete
            self.state = _INTERMISSION
            self.left = 3
