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
        self._first_bytes = 0  # of the message composed last, up to its data, the first one lowest
        self._lead = 0  # how many these are
        self._data = 0
        self._size = 0

    def compose(self, words: _mem.Words, pelican: bool) -> None:
        """Lay out the frame of a record in the form of the receive window."""
        head = words[1]
        info = head >> 32
        identifier = head & 0x1FFFFFFF
        dlc = info >> 16 & 15
        remote = 1 if info & _REMOTE else 0
        if not pelican:
            first = identifier >> 3 & 0xFF
            first |= (identifier & 7) << 13 | remote << 12 | dlc << 8
            self._lead = 2
        elif info & _EXTENDED:
            first = identifier >> 13 & 0xFF
            first = first << 8 | (identifier >> 21 & 0xFF)
            first = first << 8 | 0x80 | remote << 6 | dlc
            rest = (identifier & 31) << 11 | remote << 10 | (identifier >> 5 & 0xFF)
            first |= rest << 24
            self._lead = 5
        else:
            first = (identifier & 7) << 13 | remote << 12 | (identifier >> 3 & 0xFF)
            first = first << 8 | remote << 6 | dlc
            self._lead = 3
        self._first_bytes = first
        self._data = words[2]
        self._size = self._lead + (0 if remote else dlc if dlc < 8 else 8)

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

    def _write(self, size: int) -> None:
        cells, base, lead = self._cells, _BASE, self._lead
        at = self.start + self.used
        bytes_left = self._first_bytes
        for k in range(at, at + (lead if lead < size else size)):
            cells[base + (k & 63)] = bytes_left & 255
            bytes_left >>= 8
        bytes_left = self._data
        for k in range(at + lead, at + size):
            cells[base + (k & 63)] = bytes_left & 255
            bytes_left >>= 8
