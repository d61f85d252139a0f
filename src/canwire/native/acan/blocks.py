"""Task blocks of a program in C: a thread of the program receives the driver's changes and writes them.

So only the program itself writes to its memory, and only while the block is registered.
"""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterator

from canwire.acan import ACANID, ACANTB
from canwire.acan.constants import Action
from canwire.acan.filters import Elsewhere
from canwire.native.acan.memory import read_memory

_HEAD = struct.Struct("<2I2HBB2x")  # process, messages of lpRMB, wRMBSize, lpRMB?, bSCFilter, bNId
_FILTER = struct.Struct("<QII2B6x")  # lpAddress, dwAnd, dwXor, bAction, bLength
_SHOWN = struct.Struct("<2I4H6B2x")  # struct acan_shown
_CHANNEL = struct.Struct("<2B8s")  # struct acan_moved
_MOST = 60_000  # bytes of one answer


class Blocks:
    """The blocks of a program, and which of them have changed since the last report to it."""

    def __init__(self) -> None:
        self.changed = threading.Condition()
        self._dirty: dict[Block, None] = {}
        self._over = False

    def touched(self, block: Block) -> None:
        """Record that a block has changed; the caller holds `changed`."""
        self._dirty[block] = None
        self.changed.notify_all()

    def forget(self, block: Block) -> None:
        with self.changed:
            self._dirty.pop(block, None)

    def end(self) -> None:
        with self.changed:
            self._over = True
            self.changed.notify_all()

    def wait(self) -> bytes | None:
        """Wait until blocks have changed and return them; None after `end`."""
        with self.changed:
            self.changed.wait_for(lambda: self._over or self._ready())
            if self._over:
                return None
            told = b""
            for block in list(self._ready()):
                if len(told) > _MOST:
                    break
                told += block.taken()
                del self._dirty[block]
            return told

    def _ready(self) -> list[Block]:
        """Return the changed blocks that have a number, which the program knows."""
        return [block for block in self._dirty if block.number]


class Block:
    """One task block: its structure in this process, and the changes to report to the program."""

    def __init__(self, blocks: Blocks, data: bytes) -> None:
        """`data` is the program's description of the block: _HEAD, and a _FILTER for each identifier."""
        process, _, size, room, conditions, count = _HEAD.unpack_from(data)
        self.number = 0
        self._blocks = blocks
        self._version = 0
        self._notified = False
        self._moved: dict[int, bytes] = {}
        self.fields = ACANTB(
            bSCFilter=conditions,
            wRMBSize=size,
            lpRMB=[] if room else None,
            bNId=count,
            idTable=list(self._filters(process, data)),
            hEvent=self,
        )
        self.fields.on_change = self._changed

    def set(self) -> None:
        """Notify the program: the block is the event that ACAN sets."""
        with self._blocks.changed:
            self._notified = True
            self._blocks.touched(self)

    def moved(self, channel: int, data: bytes) -> None:
        """Record that a channel has received this data."""
        with self._blocks.changed:
            before = self._moved.get(channel, b"")
            self._moved[channel] = data + before[len(data) :]
            self._blocks.touched(self)

    def numbered(self, number: int) -> bytes:
        """Record the block's number after its registration; return its fields."""
        with self._blocks.changed:
            self.number = number
            self._blocks.changed.notify_all()
            return self._show()

    def shown(self) -> bytes:
        """Return the driver's fields of the block."""
        with self._blocks.changed:
            return self._show()

    def taken(self) -> bytes:
        """Return `shown`, and whether to notify the application; the caller holds the lock of `changed`."""
        notified, self._notified = self._notified, False
        return self._show(notified)

    def take_moved(self) -> bytes:
        """Return the data that channels have received since the last call."""
        with self._blocks.changed:
            moved, self._moved = self._moved, {}
        return b"".join(_CHANNEL.pack(index, len(data), data) for index, data in moved.items())

    def _changed(self) -> None:
        with self._blocks.changed:
            self._version += 1
            self._state = self._read()
            self._blocks.touched(self)

    def _read(self) -> tuple[int, ...]:
        of = self.fields
        places = (of.wStatus, of.wRMBOccupation, of.wRIndex, of.wWIndex)
        return (*places, of.bREC, of.bTEC, of.bALC, of.bECC)

    def _show(self, notified: bool = False) -> bytes:
        return _SHOWN.pack(self.number, self._version, *self._state, notified, bool(self._moved))

    def _filters(self, process: int, data: bytes) -> Iterator[ACANID]:
        for index, one in enumerate(_FILTER.iter_unpack(data[_HEAD.size :])):
            address, and_mask, xor_value, action, length = one
            channel = bool(action & (Action.CHANRCV | Action.CHANSND)) and bool(address)
            memory = Variable(self, index, process, address, length) if channel else None
            yield ACANID(and_mask, xor_value, action, length, lpAddress=memory)


class Variable(Elsewhere):
    """The bytes of a channel in the memory of the program."""

    def __init__(self, block: Block, index: int, process: int, address: int, length: int) -> None:
        self._block, self._index = block, index
        self._place = process, address, length

    def read(self) -> bytes:
        return read_memory(*self._place)

    def write(self, data: bytes) -> None:
        self._block.moved(self._index, data)
