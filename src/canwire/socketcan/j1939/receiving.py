"""The receiving end of a message of several frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from canwire.socketcan.j1939.addresses import Timers
from canwire.socketcan.j1939.codes import (
    LARGEST_ETP,
    LARGEST_TP,
    MOST_IN_BLOCK,
    PACKET,
    SMALLEST_TP,
    Abort,
    Kind,
    packets,
)
from canwire.socketcan.j1939.message import Message
from canwire.socketcan.j1939.transfer import CONTROL_S, DATA_S, Transfer, reversed_message


@dataclass(frozen=True)
class Announced:
    """The contents of an RTS or BAM: bytes, packets, and the largest number of packets in one block."""

    size: int
    total: int
    block: int


def announced(kind: Kind, data: bytes) -> Announced:
    """The contents of the frame's eight bytes."""
    if kind.extended:
        size = int.from_bytes(data[1:5], "little")
        return Announced(size, packets(size), MOST_IN_BLOCK)
    return Announced(int.from_bytes(data[1:3], "little"), data[3], min(data[3], data[4]))


def refusal(kind: Kind, size: int, largest: int) -> Abort | None:
    """The reason to refuse a message of this size, or None; `largest`: the most bytes that a program can receive."""
    if not (LARGEST_TP < size <= LARGEST_ETP if kind.extended else SMALLEST_TP <= size <= LARGEST_TP):
        return Abort.FAULT
    return Abort.RESOURCE if size > largest else None


class Receiving(Transfer):
    """`wanted` returns whether a socket wants it. `data` is what has arrived; `stamp_ns` is that of the last frame."""

    def __init__(
        self,
        timers: Timers,
        kind: Kind,
        message: Message,
        what: Announced,
        put: Callable[[Message], object],
        over: Callable[[int], object],
        wanted: Callable[[], bool],
    ) -> None:
        super().__init__(timers, kind, message, put, over)
        self._wanted = wanted
        self._what = what
        self._received = self._last = 0  # packets
        self._offset: int | None = None if kind.extended else 0
        self.data = bytearray()
        self.stamp_ns = 0
        self.on_offset: Callable[[], object] = lambda: None

    @property
    def size(self) -> int:
        return self._what.size

    @property
    def received_size(self) -> int:
        return len(self.data)

    def begin(self) -> None:
        if self.message.is_broadcast:
            self._last = self._what.total
            self._await(DATA_S)
        else:
            self._clear_to_send()

    def control(self, data: bytes) -> None:
        self._put(reversed_message(self._control_frame(data)))

    def offset(self, data: bytes) -> None:
        """Process the packet offset of ETP: the number of the packet before the next one."""
        self._offset = int.from_bytes(data[2:5], "little")
        self._await(DATA_S)
        self.on_offset()

    def take(self, data: bytes, stamp_ns: int) -> None:
        """Process a data frame."""
        if len(data) != 8:
            self.fail(Abort.UNEXPECTED_DATA)
            return
        if self._offset is None or self._received >= self._what.total:
            self.fail(Abort.FAULT)
            return
        number = data[0] - 1 + self._offset
        if not 0 <= number < self._what.total:
            self.fail(Abort.FAULT)
            return
        self._await(DATA_S)
        if number == self._received:  # others are left out, and the timeout tells
            self._take_packet(data[1:], stamp_ns)

    def _take_packet(self, data: bytes, stamp_ns: int) -> None:
        self.data += data[: min(PACKET, self._what.size - len(self.data))]
        self.stamp_ns = stamp_ns
        self._received += 1
        if self._received >= self._what.total:
            self._finish()
        elif self._received >= self._last:
            self._clear_to_send()

    def _clear_to_send(self) -> None:
        if not self._wanted():
            self.fail(Abort.OTHER)
            return
        count = min(self._what.total - self._received, self._what.block, MOST_IN_BLOCK)
        self._last = self._received + count
        number = self._received + 1
        width = 3 if self.kind.extended else 1
        self._offset = None if self.kind.extended else 0
        self._await(CONTROL_S)
        self.control(bytes((self.kind.cts, count)) + number.to_bytes(width, "little"))

    def _finish(self) -> None:
        if not self.message.is_broadcast:
            if not self._wanted():
                self.fail(Abort.OTHER)
                return
            if self.kind.extended:
                whole = self._what.size.to_bytes(4, "little")
            else:
                whole = self._what.size.to_bytes(2, "little") + bytes((self._what.total,))
            self.control(bytes((self.kind.eom,)) + whole)
        self.end(0)
