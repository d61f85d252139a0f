# cython: nonecheck=False
"""The SJA1000's receive FIFO: 64 bytes of RAM as a ring, one message after the other.

Source: data sheet 6.2.4, 6.3.8, 6.4.14 to 6.4.18; reference/sja1000.md section 8.
"""

from __future__ import annotations

from canwire import _mem
from canwire.chips.sja1000.register_map import RX_FIFO, RX_FIFO_SIZE

_BASE, _SIZE = RX_FIFO, RX_FIFO_SIZE
_EXTENDED, _REMOTE = 1 << 23, 1 << 22  # info bits of a record


class ReceiveFifo:
    """Messages in the chip's RAM, whose bytes are `cells[32]` to `cells[95]`.

    `start` is where the first one begins (RBSA), `count` how many there are (RMC), `used` their bytes. `compose`
    puts a frame together, `store` takes it in.
    """

    def __init__(self, cells: bytearray) -> None:
        self.start = 0
        self.count = 0
        self.used = 0
        self._cells = cells
        self._sizes = bytearray(_SIZE)
        self._first = 0  # in `_sizes`, of the first message
        self._message = bytearray(16)
        self._size = 0

    def compose(self, words: _mem.Words, pelican: bool) -> None:
        """Lay out the frame of a record in the form of the receive window."""
        message = self._message
        head = words[1]
        info = head >> 32
        identifier = head & 0x1FFFFFFF
        dlc = info >> 16 & 15
        remote = 1 if info & _REMOTE else 0
        length = 0 if remote else dlc if dlc < 8 else 8
        if not pelican:
            message[0] = identifier >> 3 & 0xFF
            message[1] = (identifier & 7) << 5 | remote << 4 | dlc
            at = 2
        elif info & _EXTENDED:
            message[0] = 0x80 | remote << 6 | dlc
            message[1] = identifier >> 21 & 0xFF
            message[2] = identifier >> 13 & 0xFF
            message[3] = identifier >> 5 & 0xFF
            message[4] = (identifier & 31) << 3 | remote << 2
            at = 5
        else:
            message[0] = remote << 6 | dlc
            message[1] = identifier >> 3 & 0xFF
            message[2] = (identifier & 7) << 5 | remote << 4
            at = 3
        data = words[2]
        for k in range(length):
            message[at + k] = data & 255
            data >>= 8
        self._size = at + length

    def store(self) -> bool:
        """Store the message composed last; False if it does not fit."""
        size = self._size
        if self.used + size > _SIZE:
            return False
        self._write(size)
        self._sizes[(self._first + self.count) & 63] = size
        self.count += 1
        self.used += size
        return True

    def show(self) -> None:
        """Write the message composed last after the others without keeping it; only the part that fits."""
        free = _SIZE - self.used
        self._write(self._size if self._size < free else free)

    def release(self) -> None:
        """Free the first message."""
        if self.count:
            size = self._sizes[self._first]
            self._first = (self._first + 1) & 63
            self.start = (self.start + size) & 63
            self.count -= 1
            self.used -= size

    def clear(self, start: int) -> None:
        """Remove all messages; the next one is stored at `start`. The bytes stay."""
        self.start = start & 63
        self.count = self.used = 0

    def cell(self, offset: int) -> int:
        """The address of a byte of the receive window."""
        return _BASE + ((self.start + offset) & 63)

    def _write(self, size: int) -> None:
        cells, message = self._cells, self._message
        at = self.start + self.used
        for k in range(size):
            cells[_BASE + ((at + k) & 63)] = message[k]
