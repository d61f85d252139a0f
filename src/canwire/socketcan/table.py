"""The table in shared memory that the shim reads: all interfaces, and the settings of each socket.

shim/shim.h has the same layout in C. The server writes interfaces and makes slots. The shim itself stores options that
only affect the results of calls (timestamps, drop counts, sizes) in the slot, so that they apply to every process that
has the socket.
"""

from __future__ import annotations

import mmap
import os
import struct
from collections import Counter, deque
from typing import NamedTuple

MAGIC = 0x31304E4143574E43
MOST_INTERFACES = 16_384
FIRST_INDEX = 1001  # far from those of the kernel's own interfaces
MOST_SLOTS = 4096
UP, STUCK, GONE, OFF = 1, 2, 4, 8  # of an interface
USUAL_RECEIVE_BUFFER = 212_992  # bytes; net.core.rmem_default

_HEADER = struct.Struct("<QII16s")
_INTERFACE = struct.Struct("<16siiI")
_SLOT = struct.Struct("<iiiIIIIIIIQI28x")
_INTERFACES_AT = 64
_INTERFACE_SIZE = 64
_SLOTS_AT = _INTERFACES_AT + MOST_INTERFACES * _INTERFACE_SIZE
_SIZE = _SLOTS_AT + MOST_SLOTS * _SLOT.size
_COUNT_AT, _SLOTS_IN_USE_AT = 8, 12
_AT_REST = 64  # places that wait, so that who still looks at one that is gone does not find another there
_FLAGS_OFFSET = 24
_BOUND_OFFSET, _FD_OFFSET, _RECEIVE_OFFSET, _ERROR_OFFSET = 8, 16, 20, 48
_IDENTIFIERS_OFFSET = 52
_BROADCASTS_OFFSET, _WATCHED_OFFSET, _QUEUED_OFFSET, _RING_OFFSET = 64, 68, 72, 76
_STAMPS, _STAMPS_OFFSET = struct.Struct("<IIII"), 24
_NOW_AT, _EPOCH_AT, _TIMED_AT, _WATCHED_AT, _NETLINK_AT = 32, 40, 48, 52, 56
_LONG = struct.Struct("<Q")
_PAIR, _WORD = struct.Struct("<iI"), struct.Struct("<I")
_WORDS = struct.Struct("<II")


class Stamps(NamedTuple):
    """The control messages that a program wants with its messages: their types, 0: none."""

    plain: int
    stamping: int
    flags: int
    counts_drops: int


class Table:
    """Created at `path`; `prefix` begins the names of the programs' ends of socket pairs (at most 15 bytes)."""

    def __init__(self, path: str, prefix: bytes) -> None:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o600)
        try:
            os.ftruncate(descriptor, _SIZE)
            if hasattr(os, "posix_fallocate"):  # Linux: a full place is an error now, and no signal later
                os.posix_fallocate(descriptor, 0, _SIZE)
            self._memory = mmap.mmap(descriptor, _SIZE)
        finally:
            os.close(descriptor)
        _HEADER.pack_into(self._memory, 0, MAGIC, 0, 0, prefix)
        self._interfaces = 0
        self._resting: deque[int] = deque()  # places of interfaces that are gone
        self._uses = Counter[int]()
        self._watched: set[int] = set()  # slots of which poll has more to tell than the kernel
        self._free = list(range(MOST_SLOTS - 1, -1, -1))

    def keep_time(self, epoch_ns: int) -> None:
        """Use the time of `set_time` as the programs' time from now on."""
        _WORD.pack_into(self._memory, _TIMED_AT, 1)
        _LONG.pack_into(self._memory, _EPOCH_AT, epoch_ns)

    def set_time(self, now_ns: int) -> None:
        _LONG.pack_into(self._memory, _NOW_AT, now_ns)

    def set_netlink_port(self, port: int) -> None:
        """The port for programs' netlink sockets; 0: only the kernel."""
        _WORD.pack_into(self._memory, _NETLINK_AT, port)

    # interfaces

    def add_interface(self, name: str, mtu: int, flags: int) -> tuple[int, int] | None:
        """Add an interface; returns its place in the table and its unique index, None if all places are in use."""
        place = self._next_place()
        if place is None:
            return None
        index = FIRST_INDEX + place + MOST_INTERFACES * self._uses[place]
        self._uses[place] += 1
        at = _INTERFACES_AT + place * _INTERFACE_SIZE
        _INTERFACE.pack_into(self._memory, at, name.encode(), index, mtu, flags)
        _WORD.pack_into(self._memory, _COUNT_AT, self._interfaces)
        return place, index

    def remove_interface(self, place: int) -> None:
        """Mark an interface as GONE; its place is used again later."""
        self._resting.append(place)

    def _next_place(self) -> int | None:
        if self._interfaces < MOST_INTERFACES and len(self._resting) < _AT_REST:
            self._interfaces += 1
            return self._interfaces - 1
        return self._resting.popleft() if self._resting else None

    def set_flags(self, place: int, flags: int) -> None:
        """UP, STUCK, GONE, OFF."""
        _WORD.pack_into(self._memory, _INTERFACES_AT + place * _INTERFACE_SIZE + _FLAGS_OFFSET, flags)

    # slots

    def take_slot(self, protocol: int, type: int) -> int | None:
        """A slot for a new socket; None if all are in use."""
        if not self._free:
            return None
        slot = self._free.pop()
        self._count_slots()
        _SLOT.pack_into(
            self._memory, _at(slot), protocol, type, 0, 0, 0, USUAL_RECEIVE_BUFFER, 0, 0, 0, 0, 0, 0
        )
        return slot

    def free_slot(self, slot: int) -> None:
        """Free the slot of a socket without descriptors."""
        self.watch(slot, False)
        self._free.append(slot)
        self._count_slots()

    def _count_slots(self) -> None:
        """Without any, no call of a program has to ask whether it is about one."""
        _WORD.pack_into(self._memory, _SLOTS_IN_USE_AT, MOST_SLOTS - len(self._free))

    def bind(self, slot: int, interface: int) -> None:
        """Bind a socket to the interface with this index; 0: to all."""
        _PAIR.pack_into(self._memory, _at(slot) + _BOUND_OFFSET, interface, 1)

    def bound_to(self, slot: int) -> int:
        """The index of the interface that a socket is bound to; 0: to all, or not bound."""
        found: int = _PAIR.unpack_from(self._memory, _at(slot) + _BOUND_OFFSET)[0]
        return found

    def set_identifiers(self, slot: int, receives: int, sends: int) -> None:
        """Set the identifiers of an ISO-TP socket, with flags."""
        _WORDS.pack_into(self._memory, _at(slot) + _IDENTIFIERS_OFFSET, receives, sends)

    def unbind(self, slot: int) -> None:
        """Unbind a socket whose interface is gone."""
        _PAIR.pack_into(self._memory, _at(slot) + _BOUND_OFFSET, 0, 0)

    def allow_fd(self, slot: int, allowed: bool) -> None:
        _WORD.pack_into(self._memory, _at(slot) + _FD_OFFSET, int(allowed))

    def set_error(self, slot: int, error: int) -> None:
        """Set the error that SO_ERROR returns once, and that poll reports."""
        if error:
            self._watched.add(slot)
            _WORD.pack_into(self._memory, _WATCHED_AT, len(self._watched))
        _WORD.pack_into(self._memory, _at(slot) + _ERROR_OFFSET, error)

    def receive_buffer(self, slot: int) -> int:
        """The size of the receive buffer in bytes, as the program has set it; else the kernel's default."""
        found: int = _WORD.unpack_from(self._memory, _at(slot) + _RECEIVE_OFFSET)[0]
        return found

    # CAN_J1939

    def broadcasts(self, slot: int) -> bool:
        """True if SO_BROADCAST is set."""
        return _WORD.unpack_from(self._memory, _at(slot) + _BROADCASTS_OFFSET)[0] != 0

    def set_broadcasts(self, slot: int, on: bool) -> None:
        _WORD.pack_into(self._memory, _at(slot) + _BROADCASTS_OFFSET, int(on))

    def watch(self, slot: int, on: bool) -> None:
        """The socket has an error queue or a mapped ring, which poll has to check."""
        self._watched.add(slot) if on else self._watched.discard(slot)
        _WORD.pack_into(self._memory, _at(slot) + _WATCHED_OFFSET, int(on))
        _WORD.pack_into(self._memory, _WATCHED_AT, len(self._watched))

    def place_ring(self, slot: int, state_at: int) -> None:
        """Set the offset in bytes of the state of the last entry in its mapped ring; -1: no entry yet."""
        _WORD.pack_into(self._memory, _at(slot) + _RING_OFFSET, state_at + 1)

    def count_errors(self, slot: int, count: int) -> None:
        """Set the number of entries in its error queue."""
        _WORD.pack_into(self._memory, _at(slot) + _QUEUED_OFFSET, count)

    # of programs whose calls the server answers

    def protocol(self, slot: int) -> int:
        """CAN_RAW, CAN_BCM, CAN_ISOTP ..."""
        found: int = _WORD.unpack_from(self._memory, _at(slot))[0]
        return found

    def identifiers(self, slot: int) -> tuple[int, int]:
        """The identifiers of an ISO-TP socket: the received one and the sent one."""
        receives, sends = _WORDS.unpack_from(self._memory, _at(slot) + _IDENTIFIERS_OFFSET)
        return receives, sends

    def stamps(self, slot: int) -> Stamps:
        return Stamps(*_STAMPS.unpack_from(self._memory, _at(slot) + _STAMPS_OFFSET))

    def set_stamps(self, slot: int, stamps: Stamps) -> None:
        _STAMPS.pack_into(self._memory, _at(slot) + _STAMPS_OFFSET, *stamps)

    def set_receive_buffer(self, slot: int, size: int) -> None:
        """Set the size of the receive buffer in bytes, as SO_RCVBUF returns it."""
        _WORD.pack_into(self._memory, _at(slot) + _RECEIVE_OFFSET, size)

    def take_error(self, slot: int) -> int:
        """Return the error for SO_ERROR, and clear it."""
        found: int = _WORD.unpack_from(self._memory, _at(slot) + _ERROR_OFFSET)[0]
        self.set_error(slot, 0)
        return found

    def close(self) -> None:
        self._memory.close()


def _at(slot: int) -> int:
    return _SLOTS_AT + slot * _SLOT.size
