"""One node's protocol machine, bit by bit: what ISO 11898-1 calls medium access control.

A `Station` is handed the level at each of its sample points and says which level it drives in
its next bit. It knows no time but `now_ns`, which its owner (bit_level.py) keeps up to date; clocks, the
wire and disturbances live there. Counters and what follows from them live in the node.

Source: ISO 11898-1:2015 chapters 8 and 10; Bosch CAN FD 1.0; reference/can-protocol.md sections 1 to 7.
"""

from __future__ import annotations

from canwire.bus import can_bits
from canwire.bus.bit_layout import BitLayout
from canwire.bus.can_bits import (
    CRC15_POLY,
    CRC17_ISO_START,
    CRC17_POLY,
    CRC21_ISO_START,
    CRC21_POLY,
    NON_ISO,
    STUFF_COUNT_CODE,
)
from canwire.bus.node import (
    DOMINANT_AFTER_FLAG,
    FLAG_BIT_ERROR_RECEIVER,
    FLAG_BIT_ERROR_TRANSMITTER,
    LONG_DOMINANT_RECEIVER,
    LONG_DOMINANT_TRANSMITTER,
    NO_RULE,
    RECEIVE_ERROR,
    RECEIVED,
    TRANSMIT_ERROR,
    Mailbox,
    Node,
)
from canwire.values.dlc import dlc_to_length
from canwire.values import frame as codec
from canwire.values.frame import Frame

# states
IDLE, FRAME, ACTIVE_FLAG, PASSIVE_FLAG, FLAG_WAIT, DELIMITER, OVERLOAD_FLAG, INTERMISSION, SUSPEND, WAITING = range(10)
_IDLE, _FRAME, _ACTIVE_FLAG, _PASSIVE_FLAG, _FLAG_WAIT = IDLE, FRAME, ACTIVE_FLAG, PASSIVE_FLAG, FLAG_WAIT
_DELIMITER, _OVERLOAD_FLAG, _INTERMISSION, _SUSPEND, _WAITING = (
    DELIMITER, OVERLOAD_FLAG, INTERMISSION, SUSPEND, WAITING,
)  # fmt: skip

# fields of a frame, in the order of the wire
(_SOF, _BASE, _RTR, _IDE, _EXT, _RTR2, _FDF, _R0, _RES, _BRS, _ESI, _DLC, _DATA,
 _FD_CRC, _CRC, _CRC_DELIMITER, _ACK, _ACK_DELIMITER, _EOF) = range(19)  # fmt: skip

# ErrorKind
_STUFF, _FORM, _ACK_ERROR, _BIT, _FAST_DATA_BIT, _CRC_ERROR = 1, 2, 3, 4, 5, 6

KEEP_RATE, TO_DATA_RATE, TO_NOMINAL_RATE = range(3)
_TO_DATA_RATE, _TO_NOMINAL_RATE = TO_DATA_RATE, TO_NOMINAL_RATE


class Tap:
    """Somebody who watches the wire without being on it."""

    def transmitted(self, node: Node, box: Mailbox, at_ns: int) -> None:
        """The node's frame went through."""
        raise NotImplementedError


class Tally:
    """What has happened on one bus, counted once for all its stations."""

    def __init__(self) -> None:
        self.frames = 0
        self.error_frames = 0
        self.erring = 0
        self.last_success_ns = 0
        self.tap: Tap | None = None


class Station:
    """The protocol machine of one node.

    `out` is the level it drives, `rate_change` what its clock has to do at this sample point,
    `sof_seen` that an edge has ended its idle time.
    """

    def __init__(self, node: Node, tally: Tally) -> None:
        self.node = node
        self.tally = tally
        self.erring = False
        self.now_ns = 0
        self.sof_ns = 0
        self.state = _WAITING if node.waiting or not node.on_bus else _IDLE
        self.out = 1
        self.last_sample = 1
        self.rate_change = 0
        self.fast = False
        self.sof_seen = False
        self.transmitting = False
        self.index = 0
        self.run = 0
        self.box = Mailbox()
        self.contending = node.contending
        self.sent: Mailbox | None = None
        self.levels = b""
        self.finished = False
        self.rejoined = False
        self.overload = False
        self.tec_due = False
        self.left = 0
        self.dominant_run = 0
        self._begin_parse()

    def begin_bit(self) -> None:
        """A bit of this node starts: settle what the last one brought about, then choose `out`."""
        if self.finished:
            self._deliver()
        if self.rejoined:
            self.rejoined = False
            self.state = _IDLE
            if self.node.waiting:
                self.node.joined(self.now_ns)
        if self.state == _IDLE and not self.sof_seen:
            self._offer()
        self.out = 1
        if self.state == _FRAME:
            if self.transmitting:
                self.out = self.levels[self.index]
            elif self.field == _ACK and self.acknowledging:
                self.out = 0
        elif self.state == _ACTIVE_FLAG or self.state == _OVERLOAD_FLAG:
            self.out = 0

    def sample(self, level: int) -> None:
        """The bus has this level at the node's sample point."""
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
        else:
            self._flag_bit(level)

    def ready_to_send(self) -> bool:
        """An offer of the node's may start in this bit."""
        node = self.node
        offer = node.offer
        return (
            offer is not None
            and node.on_bus
            and not node.listen_only
            and offer.ready_ns <= self.now_ns
            and node.suspended_ns <= self.now_ns
        )

    def resting(self) -> bool:
        """Nothing of a frame or an error is under way here."""
        if self.finished or self.rejoined or self.sof_seen:
            return False
        return (
            self.state == _IDLE
            or self.state == _SUSPEND
            or (self.state == _WAITING and not self.node.on_bus)
        )

    def wait_for_bus(self) -> None:
        """Leave whatever was going on; the node looks for 11 recessive bits."""
        self._recovered()
        self.state = _WAITING
        self.transmitting = False
        self.finished = False
        self.run = 0

    def _offer(self) -> None:
        node = self.node
        box, self.contending = self.contending, None
        if box is not None:
            self._transmit(box)
        elif self.ready_to_send():
            self._transmit(node.offer)

    def _transmit(self, box: Mailbox) -> None:
        self.sent = self.node.contending = box
        self.sof_ns = self.now_ns
        frame = codec.frame_at(box.words, 0)
        if frame.fd:
            can_bits.show_error_state(box, self.node.passive, self.node.fd)
            frame = codec.frame_at(box.words, 0)
        layout = BitLayout(frame, fd_mode=self.node.fd)
        self.levels = bytes(layout.levels)
        self._begin_parse()
        self.transmitting = True
        self.state = _FRAME

    def _begin_parse(self) -> None:
        self.field = _SOF
        self.left_in_field = 1
        self.value = 0
        self.index = 0
        self.same = 0
        self.last = 1
        self.stuffing = True
        self.stuff_count = 0
        self.crc15 = 0
        iso = self.node.fd != NON_ISO
        self.crc17 = CRC17_ISO_START if iso else 0
        self.crc21 = CRC21_ISO_START if iso else 0
        self.identifier = 0
        self.extended = self.remote = self.fd = self.switch = self.esi = False
        self.dlc = 0
        self.data = bytearray()
        self.crc_ok = False
        self.acknowledging = False
        self.acknowledged = False
        self.second_ack = False
        self.fast = False

    def _start_receiving(self) -> None:
        """The bit just sampled is an SOF."""
        self._begin_parse()
        self.transmitting = False
        self.sof_seen = False
        self.state = _FRAME
        self._frame_bit(0)

    # between frames

    def _idle_bit(self, level: int) -> None:
        if level == 0:
            self._start_receiving()
            return
        self.sof_seen = False
        if self.state == _SUSPEND:
            self.left -= 1
            if self.left == 0:
                self.state = _IDLE

    def _intermission_bit(self, level: int) -> None:
        self.left -= 1
        if level == 0:
            if self.left > 0:
                self._overload()
            elif self.ready_to_send() and not (self.transmitting and self.node.passive):
                self._transmit(self.node.offer)  # the third bit is somebody's SOF, and counts as its own too
                self._frame_bit(0)
            else:
                self._start_receiving()
        elif self.left == 0:
            suspended = self.transmitting and self.node.passive
            self.transmitting = False
            self.state = _SUSPEND if suspended else _IDLE
            self.left = 8

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

    def _deliver(self) -> None:
        self.finished = False
        if self.transmitting:
            self.tally.frames += 1
            self.tally.last_success_ns = self.now_ns
            if self.tally.tap is not None:
                self.tally.tap.transmitted(self.node, self.sent, self.now_ns)
            self.node.transmitted(self.sent, self.now_ns)
        else:
            frame = Frame(
                self.identifier,
                bytes(self.data),
                extended=self.extended,
                remote=self.remote,
                fd=self.fd,
                bit_rate_switch=self.switch,
                error_state_indicator=self.esi,
                dlc=self.dlc,
            )
            codec.store_frame(frame, self.box.words, 0, 0, 0)
            if self.node.sink is not None:
                self.node.frames_received += 1
                self.node.sink.deliver(self.box, self.now_ns, 0)
            else:
                self.node.received(self.box, self.now_ns)

    # inside a frame

    def _frame_bit(self, level: int) -> None:
        stuff_bit = self.stuffing and self.same == 5
        if self.transmitting and level != self.out and not self._tolerated(level, stuff_bit):
            return
        self.index += 1
        if stuff_bit:
            self._stuff_bit(level)
            return
        if self.stuffing:
            self.same = self.same + 1 if level == self.last and self.same else 1
        if self.field <= _DATA:
            self._cover(level)
            if self.stuffing:
                self.crc15 = _shift(self.crc15, level, 15, CRC15_POLY)
        self.last, previous = level, self.last
        if self.field == _FD_CRC:
            self._fd_crc_bit(level, previous)
            return
        self.value = self.value << 1 | level
        self.left_in_field -= 1
        if self.field >= _CRC_DELIMITER:
            self._tail_bit(level)
        elif self.left_in_field == 0:
            self._field_done(self.value)

    def _cover(self, level: int) -> None:
        self.crc17 = _shift(self.crc17, level, 17, CRC17_POLY)
        self.crc21 = _shift(self.crc21, level, 21, CRC21_POLY)

    def _stuff_bit(self, level: int) -> None:
        if level == self.last:
            self._error(_STUFF, self.index - 1)
            return
        self.last = level
        self.same = 1
        self.stuff_count += 1
        if self.field <= _DATA:
            self._cover(level)
        if self.field == _CRC_DELIMITER:
            self.stuffing = False

    def _tolerated(self, level: int, stuff_bit: bool) -> bool:
        """A sender reads another level than it drives: False when that was an error."""
        field = self.field
        if level == 0:
            if _BASE <= field <= _RTR2:
                if stuff_bit:
                    self._error(_STUFF, self.index, exempt=True)
                    return False
                self._lose()
                return True
            if field == _ACK or (field == _ACK_DELIMITER and self.fd):
                return True
            if field >= _CRC_DELIMITER:
                self._error(_FORM, self.index)
                return False
        self._error(_FAST_DATA_BIT if self.fast else _BIT, self.index)
        return False

    def _lose(self) -> None:
        field, left = self.field, self.left_in_field
        if field == _BASE:
            bit = 11 - left
        elif field == _EXT:
            bit = 31 - left
        else:
            bit = {_RTR: 11, _IDE: 12, _RTR2: 31}[field]
        self.transmitting = False
        self.node.arbitration_losses += 1
        if self.node.attentive or self.sent.single_shot:
            self.node.arbitration_lost(self.sent, bit, self.sof_ns)

    def _next(self, field: int, bits: int) -> None:
        self.field = field
        self.left_in_field = bits
        self.value = 0

    def _field_done(self, value: int) -> None:
        field = self.field
        if field == _SOF:
            self._next(_BASE, 11)
        elif field == _BASE:
            self.identifier = value
            self._next(_RTR, 1)
        elif field == _RTR:
            self.remote = value == 1
            self._next(_IDE, 1)
        elif field == _IDE:
            self.extended = value == 1
            self._next(_EXT if value else _FDF, 18 if value else 1)
        elif field == _EXT:
            self.identifier = self.identifier << 18 | value
            self._next(_RTR2, 1)
        elif field == _RTR2:
            self.remote = value == 1
            self._next(_FDF, 1)
        else:
            self._control_done(field, value)

    def _control_done(self, field: int, value: int) -> None:
        if field == _FDF:
            self.fd = value == 1 and self.node.fd != 0
            if self.fd:
                self.remote = False
                self._next(_RES, 1)
            else:
                self._next(_R0 if self.extended else _DLC, 1 if self.extended else 4)
        elif field == _R0:
            self._next(_DLC, 4)
        elif field == _RES:
            if value:
                self.wait_for_bus()  # protocol exception
            else:
                self._next(_BRS, 1)
        elif field == _BRS:
            self.switch = value == 1
            if self.switch:
                self.fast = True
                self.rate_change = _TO_DATA_RATE
            self._next(_ESI, 1)
        elif field == _ESI:
            self.esi = value == 1
            self._next(_DLC, 4)
        else:
            self._body_done(field, value)

    def _body_done(self, field: int, value: int) -> None:
        if field == _DLC:
            self.dlc = value
            length = 0 if self.remote else dlc_to_length(value, fd=self.fd)
            if length:
                self._next(_DATA, 8 * length)
            else:
                self._begin_crc()
        elif field == _DATA:
            self.data = bytearray(value.to_bytes(dlc_to_length(self.dlc, fd=self.fd), "big"))
            self._begin_crc()
        else:
            self.crc_ok = value == self.crc15
            self.stuffing = self.same == 5  # one more stuff bit may follow the last CRC bit
            self._next(_CRC_DELIMITER, 1)

    def _begin_crc(self) -> None:
        if not self.fd:
            self._next(_CRC, 15)
            return
        self.stuffing = False
        short = len(self.data) <= 16
        coded = 4 if self.node.fd != NON_ISO else 0
        self.crc_width = 17 if short else 21
        self.crc_position = 0
        bits = coded + self.crc_width
        self._next(_FD_CRC, bits + (bits + 3) // 4)

    def _fd_crc_bit(self, level: int, previous: int) -> None:
        """Fixed stuff bits stand before every group of four bits, the inverse of their predecessor."""
        if self.crc_position % 5 == 0:
            if level == previous:
                self._error(_FORM, self.index - 1)
                return
        else:
            self.value = self.value << 1 | level
            iso = self.node.fd != NON_ISO
            if iso and self.crc_position < 5:
                self._cover(level)
        self.crc_position += 1
        self.left_in_field -= 1
        if self.left_in_field == 0:
            received = self.value & (1 << self.crc_width) - 1
            code = self.value >> self.crc_width
            counted = self.node.fd == NON_ISO or code == STUFF_COUNT_CODE[self.stuff_count & 7]
            self.crc_ok = counted and received == (self.crc17 if self.crc_width == 17 else self.crc21)
            self._next(_CRC_DELIMITER, 1)

    def _tail_bit(self, level: int) -> None:
        if self.field == _CRC_DELIMITER:
            if self.fast:
                self.fast = False
                self.rate_change = _TO_NOMINAL_RATE
            if level == 0:
                self._error(_FORM, self.index - 1)
                return
            self.acknowledging = self.crc_ok and not self.transmitting and not self.node.listen_only
            self._next(_ACK, 1)
        elif self.field == _ACK:
            self._ack_bit(level)
        elif self.field == _ACK_DELIMITER:
            self._ack_delimiter_bit(level)
        else:
            self._eof_bit(level)

    def _ack_bit(self, level: int) -> None:
        self._next(_ACK_DELIMITER, 1)
        if self.transmitting:
            self.acknowledged = level == 0
            if level == 1 and not self.fd:
                self._error(_ACK_ERROR, self.index - 1)
        elif self.acknowledging and level == 1:
            self._error(_BIT, self.index - 1)

    def _ack_delimiter_bit(self, level: int) -> None:
        """CAN FD tolerates an acknowledge that comes one bit late or lasts two bits."""
        late = self.transmitting and not self.acknowledged
        if level == 0 and self.fd and not self.second_ack:
            self.acknowledged = True
            self.second_ack = True
            self._next(_ACK_DELIMITER, 1)
        elif late:
            self._error(_ACK_ERROR, self.index - 1)
        elif not self.crc_ok and not self.transmitting:
            self._error(_CRC_ERROR, self.index - 1)
        elif level == 0:
            self._error(_FORM, self.index - 1)
        else:
            if not self.transmitting and not self.node.listen_only:
                self.node.count(RECEIVED, self.now_ns)
            self._next(_EOF, 7)

    def _eof_bit(self, level: int) -> None:
        if level == 0 and (self.left_in_field > 0 or self.transmitting):
            self._error(_FORM, self.index - 1)
        elif self.left_in_field == 0:
            self.finished = True  # a receiver accepts even if this bit was dominant
            self.state = _INTERMISSION
            self.left = 3
            if level == 0:
                self._overload()

    # errors

    def _error(self, kind: int, bit: int, exempt: bool = False) -> None:
        node = self.node
        passive = node.passive or node.listen_only
        rule = TRANSMIT_ERROR if self.transmitting else RECEIVE_ERROR
        self.tec_due = self.transmitting and passive and kind == _ACK_ERROR
        if exempt or self.tec_due or node.listen_only:
            rule = NO_RULE
        if self.fast:
            self.fast = False
            self.rate_change = _TO_NOMINAL_RATE
        if not self.erring:
            self.erring = True
            self.tally.erring += 1
            if self.tally.erring == 1:
                self.tally.error_frames += 1
        self.state = _PASSIVE_FLAG if passive else _ACTIVE_FLAG
        self.overload = False
        self.left = 6
        self.run = 0
        self.dominant_run = 0
        node.error(kind, bit, self.transmitting, rule, self.now_ns)
        self._leave_if_off()

    def _overload(self) -> None:
        self.state = _PASSIVE_FLAG if self.node.listen_only else _OVERLOAD_FLAG
        self.overload = True
        self.left = 6
        self.run = 0
        self.dominant_run = 0

    def _count(self, rule: int) -> None:
        if not self.node.listen_only:
            self.node.count(rule, self.now_ns)
            self._leave_if_off()

    def _leave_if_off(self) -> None:
        if not self.node.on_bus:
            self.wait_for_bus()

    def _flag_bit(self, level: int) -> None:
        if self.state == _PASSIVE_FLAG:
            self._passive_flag_bit(level)
        elif self.state == _FLAG_WAIT:
            self._after_flag_bit(level)
        else:
            self.left -= 1
            if self.left == 0:
                self.state = _FLAG_WAIT
            if level == 1:
                self._count(FLAG_BIT_ERROR_TRANSMITTER if self.transmitting else FLAG_BIT_ERROR_RECEIVER)

    def _passive_flag_bit(self, level: int) -> None:
        """Complete once six equal bits have been seen; `run` counts them, `last` is their level."""
        self.run = self.run + 1 if self.run and level == self.last else 1
        self.last = level
        if self.run == 6:
            self.state = _FLAG_WAIT
        if level == 0 and self.tec_due:
            self.tec_due = False
            self._count(TRANSMIT_ERROR)

    def _after_flag_bit(self, level: int) -> None:
        if level == 1:
            self.state = _DELIMITER
            self.left = 7
            return
        self.dominant_run += 1
        if self.dominant_run == 1 and not self.transmitting and not self.overload:
            self._count(DOMINANT_AFTER_FLAG)
        if self.dominant_run % 8 == 0:
            self._count(LONG_DOMINANT_TRANSMITTER if self.transmitting else LONG_DOMINANT_RECEIVER)

    def _delimiter_bit(self, level: int) -> None:
        self.left -= 1
        if level == 0:
            if self.left:
                self._error(_FORM, self.index)
            else:
                self._overload()
        elif self.left == 0:
            self._recovered()
            self.state = _INTERMISSION
            self.left = 3

    def _recovered(self) -> None:
        if self.erring:
            self.erring = False
            self.tally.erring -= 1


def _shift(register: int, bit: int, width: int, poly: int) -> int:
    fed_back = bit ^ register >> (width - 1)
    register = register << 1 & ((1 << width) - 1)
    return register ^ poly if fed_back else register
