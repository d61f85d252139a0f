"""The driver's transmit side: three buffers with a mailbox each, in the order of their identifiers."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.bus.can.node import Mailbox
from canwire.chips.mcp2515 import register_map as m
from canwire.drivers.mcp2515.access import Instructions
from canwire.drivers.mcp2515.frames import arbitration_key, frame_bytes
from canwire.drivers.reporting import ChipDriver
from canwire.errors import BadValue

if TYPE_CHECKING:
    from canwire.chips.host import Host

_CANINTF = m.CANINTF
_LONGEST_WAIT_BITS = 500  # three frames, the longest; what has not been sent by then is not on the wire
_FAILED = m.TX_TXERR | m.TX_MLOA


class TransmitBuffer:
    """One transmit buffer, and the driver's record of it."""

    def __init__(self, number: int, box: Mailbox) -> None:
        self.number = number
        self.bit = 1 << number
        self.control = m.TXBCTRL[number]
        self.flag = m.INT_TX[number]
        self.box = box
        self.in_chip = False
        self.given_up = False  # its abort was asked for
        self.lost = False  # arbitration, and told
        self.failed = False  # an error on the wire, and told
        self.rank = (0, 0)
        self.requested_ns = 0
        self.priority = 0


class Sender(ChipDriver):
    """Loads frames into the chip's buffers and finds out whether they were sent."""

    def __init__(self, host: Host | None, access: Instructions, now: Callable[[], int]) -> None:
        super().__init__(host, now, access.read)
        self.boxes = [self.normal, *(Mailbox() for _ in range(m.TX_BUFFERS - 1))]
        self.several = True
        self._buffers = [TransmitBuffer(number, one) for number, one in enumerate(self.boxes)]
        self._chip = access
        self._bit_ns = 0
        self._one_shot = False
        self._turn = 0

    def wake(self, at_ns: int) -> None:
        """A frame is to be sent: do not sleep."""
        raise NotImplementedError

    def on_wire(self) -> bool:
        """True if a frame was requested and has not failed yet, since the chip does not report the wire's state."""
        latest_ns = self._now() - _LONGEST_WAIT_BITS * self._bit_ns
        return any(
            buffer.in_chip
            and buffer.requested_ns >= latest_ns
            and self._read(buffer.control) & (m.TX_TXREQ | _FAILED) == m.TX_TXREQ
            for buffer in self._buffers
        )

    def _forget_buffers(self) -> None:
        """The chip was reset: its buffers are empty."""
        self._transmits = self._one_shot = False
        for buffer in self._buffers:
            buffer.in_chip = buffer.given_up = False
            buffer.priority = 0

    def _take_back(self) -> None:
        """The chip left the bus: cancel the frames in its buffers, which stay in the mailboxes."""
        for buffer in self._buffers:
            if buffer.in_chip:
                self._chip.modify(buffer.control, m.TX_TXREQ, 0)
                buffer.in_chip = False

    def _send_all(self) -> None:
        """Send all frames in mailboxes, once the chip can send again."""
        for buffer in self._buffers:
            if buffer.box.occupied and self._transmits:
                self._send(buffer)

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        if self._transmits:
            self.wake(at_ns)
            self._send(self._buffer_of(box))

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        buffer = self._buffer_of(box)
        if not box.occupied:
            return False
        if buffer.in_chip:
            buffer.given_up = True
            self._chip.modify(buffer.control, m.TX_TXREQ, 0)
            if self._read(buffer.control) & m.TX_TXREQ or self._read(_CANINTF) & buffer.flag:
                return False
        if box.occupied:  # nobody has told of it
            self._finished(buffer, False)
        return True

    def _buffer_of(self, box: Mailbox) -> TransmitBuffer:
        for buffer in self._buffers:
            if buffer.box is box:
                return buffer
        raise BadValue("this mailbox belongs to another driver")

    def _send(self, buffer: TransmitBuffer) -> None:
        """Put the mailbox's frame into its transmit buffer and request its transmission."""
        box = buffer.box
        self._chip.load_buffer(buffer.number, frame_bytes(box))
        buffer.given_up = buffer.lost = buffer.failed = False
        buffer.in_chip = True
        buffer.requested_ns = self._now()
        self._turn += 1
        buffer.rank = (arbitration_key(box), self._turn)
        if box.single_shot and not self._one_shot:
            self._one_shot = True
            self._chip.modify(m.CANCTRL, m.CTRL_OSM, m.CTRL_OSM)
        self._order()
        self._chip.request_to_send(buffer.bit)

    def _order(self) -> None:
        """Set TXP of the loaded buffers by the rank of their frames."""
        loaded = [buffer for buffer in self._buffers if buffer.in_chip]
        if len(loaded) > 1:
            loaded.sort(key=_rank)
        priority = m.TX_TXP
        for buffer in loaded:
            if buffer.priority != priority:
                buffer.priority = priority
                self._chip.modify(buffer.control, m.TX_TXP, priority)
            priority -= 1

    def _finished(self, buffer: TransmitBuffer, delivered: bool) -> None:
        """The frame in a mailbox was delivered or aborted; the next one may be loaded."""
        buffer.in_chip = False
        if self._one_shot and not any(other.in_chip and other.box.single_shot for other in self._buffers):
            self._one_shot = False
            self._chip.modify(m.CANCTRL, m.CTRL_OSM, 0)
        self.over(buffer.box, delivered)

    def _review(self, failed: bool = True) -> None:
        """Handle frames that lost arbitration or that the chip no longer tries, except those that `failed`."""
        again = 0
        for buffer in self._buffers:
            if not buffer.in_chip:
                continue
            control = self._read(buffer.control)
            self._look_for_loss(buffer, control)
            if control & m.TX_TXREQ or (control & m.TX_TXERR and not failed):
                continue
            if self._read(_CANINTF) & buffer.flag:
                continue
            if buffer.box.single_shot or buffer.given_up:
                self._finished(buffer, False)
            else:
                buffer.lost = buffer.failed = False
                again |= buffer.bit
        if again:
            self._chip.request_to_send(again)

    def _look_for_loss(self, buffer: TransmitBuffer, control: int) -> None:
        if control & m.TX_MLOA and not buffer.lost:
            buffer.lost = True
            self.arbitration_lost()


def _rank(buffer: TransmitBuffer) -> tuple[int, int]:
    return buffer.rank
