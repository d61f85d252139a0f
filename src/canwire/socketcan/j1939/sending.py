"""The sending end of a message of several frames: to one controller (TP.CM_RTS, ETP) or to all (TP.CM_BAM)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from canwire.socketcan.j1939.addresses import Timers
from canwire.socketcan.j1939.codes import (
    BAM,
    DPO,
    ETP,
    LARGEST_TP,
    MOST_IN_BLOCK,
    PACKET,
    PAD,
    TP,
    Abort,
    packets,
)
from canwire.socketcan.j1939.message import Message
from canwire.socketcan.j1939.transfer import CONTROL_S, DATA_S, GAP_S, HOLD_S, OWN_S, Transfer

_WINDOW = 32  # data frames that wait for the bus


class Sending(Transfer):
    """`scheduled` is called for each block that the other side has acknowledged."""

    def __init__(
        self,
        timers: Timers,
        message: Message,
        put: Callable[[Message], object],
        over: Callable[[int], object],
        scheduled: Callable[[], object],
    ) -> None:
        kind = ETP if len(message.data) > LARGEST_TP else TP
        super().__init__(timers, kind, message, put, over)
        self._scheduled = scheduled
        self._total = packets(len(message.data))
        self._acknowledged = self._sent = self._last = self._offset = 0  # packets
        self._unconfirmed = 0
        self._cleared = False  # by a CTS after which no data frame was on the bus

    @property
    def acknowledged_size(self) -> int:
        """The number of bytes that have arrived."""
        return min(self._acknowledged * PACKET, len(self.message.data))

    def begin(self) -> None:
        size = len(self.message.data)
        if self.message.is_broadcast:
            self.control(bytes((BAM,)) + size.to_bytes(2, "little") + bytes((self._total,)))
            self._last = self._total
            self._timers.call_in(GAP_S, self._next_broadcast)
            self._await(OWN_S)
        elif self.kind.extended:
            self.control(bytes((self.kind.rts,)) + size.to_bytes(4, "little"))
            self._await(CONTROL_S)
        else:
            self.control(bytes((self.kind.rts,)) + size.to_bytes(2, "little") + bytes((self._total,)) * 2)
            self._await(CONTROL_S)

    def control(self, data: bytes) -> None:
        self._put(self._control_frame(data))

    def clear_to_send(self, data: bytes) -> None:
        """Process a CTS: number of packets and first packet; 0 packets: wait for the next CTS."""
        number = int.from_bytes(data[2:5], "little") if self.kind.extended else data[2]
        most = MOST_IN_BLOCK if self.kind.extended else self._total
        if self._cleared:
            self.fail(Abort.DUPLICATE)
        elif not data[1]:
            self._await(HOLD_S)
        elif not 0 < number <= self._total or data[1] > most:
            self.fail(Abort.FAULT)
        else:
            self._start_block(number - 1, data[1])

    def acknowledged(self) -> None:
        """The whole message has arrived."""
        self._acknowledged = self._total
        self.end(0)

    def confirm(self, pgn: int) -> None:
        """A frame of this message was on the bus."""
        if pgn != self.kind.data:
            return
        self._cleared = False
        self._unconfirmed = max(0, self._unconfirmed - 1)
        if self.message.is_broadcast:
            if self._sent == self._total and not self._unconfirmed:
                self.acknowledged()
            return
        whole_block = self._sent == self._last and not self._unconfirmed
        self._await(CONTROL_S if whole_block else DATA_S)
        self._go_on()

    def _start_block(self, begin: int, count: int) -> None:
        self._cleared = True
        self._acknowledged = self._sent = begin
        self._last = min(begin + count, self._total)
        self._await(CONTROL_S)
        if begin:
            self._scheduled()
        if self.kind.extended:
            self._offset = begin
            self.control(bytes((DPO, self._last - begin)) + begin.to_bytes(3, "little"))
        self._go_on()

    def _go_on(self) -> None:
        while self._sent < self._last and self._unconfirmed < _WINDOW and not self._ended:
            self._send_packet()

    def _next_broadcast(self) -> None:
        if not self._ended:
            self._send_packet()
            if self._sent < self._total:
                self._timers.call_in(GAP_S, self._next_broadcast)

    def _send_packet(self) -> None:
        begin = self._sent * PACKET
        number = self._sent - self._offset + 1
        data = bytes((number,)) + self.message.data[begin : begin + PACKET]
        self._sent += 1
        self._unconfirmed += 1
        self._await(OWN_S)
        self._put(replace(self.message, pgn=self.kind.data, data=data.ljust(8, bytes((PAD,)))))
