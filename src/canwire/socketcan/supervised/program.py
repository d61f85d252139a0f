"""One thread of a program whose calls the server answers: its memory and descriptors. All methods may raise OSError."""

from __future__ import annotations

import errno
import os
import struct
from collections.abc import Iterator
from contextlib import contextmanager

from canwire.socketcan.ports import refuse
from canwire.socketcan.supervised.notices import fetched

_PARTS = struct.Struct("<QQ")
_MESSAGE = struct.Struct("<QIxxxxQQQQixxxx")
_MOST_PARTS = 1024
_LENGTH = struct.Struct("<I")


class Message:
    """A struct msghdr in the program's memory."""

    def __init__(self, program: Program, place: int) -> None:
        self._place = place
        fields = _MESSAGE.unpack(program.read(place, _MESSAGE.size))
        self.name, self.name_size, parts, count, self.control, self.control_size, _ = fields
        if count > _MOST_PARTS:
            raise refuse(errno.EMSGSIZE)
        self.parts = list(_PARTS.iter_unpack(program.read(parts, count * _PARTS.size)))

    def finish(self, program: Program, name_size: int, control_size: int, flags: int) -> None:
        """Write the results of receiving: sizes and flags."""
        program.write(self._place + 8, _LENGTH.pack(name_size))
        program.write(self._place + 40, struct.pack("<Qi", control_size, flags))


class Program:
    """A program whose `thread` is stopped in a call."""

    def __init__(self, thread: int) -> None:
        self._thread = thread

    @property
    def name(self) -> str:
        with open(f"/proc/{self._thread}/comm", encoding="utf-8", errors="replace") as file:
            return file.read().strip()

    def read(self, place: int, size: int) -> bytes:
        if not size:
            return b""
        with self._memory(os.O_RDONLY) as memory:
            try:
                found = os.pread(memory, size, place)
            except (OSError, OverflowError):
                raise refuse(errno.EFAULT) from None
        if len(found) < size:
            raise refuse(errno.EFAULT)
        return found

    def write(self, place: int, data: bytes) -> None:
        if not data:
            return
        with self._memory(os.O_RDWR) as memory:
            try:
                done = os.pwrite(memory, data, place)
            except (OSError, OverflowError):
                raise refuse(errno.EFAULT) from None
        if done < len(data):
            raise refuse(errno.EFAULT)

    @contextmanager
    def _memory(self, mode: int) -> Iterator[int]:
        descriptor = os.open(f"/proc/{self._thread}/mem", mode | os.O_CLOEXEC)
        try:
            yield descriptor
        finally:
            os.close(descriptor)

    def length_at(self, place: int) -> int:
        """The socklen_t at this address."""
        return int(_LENGTH.unpack(self.read(place, _LENGTH.size))[0])

    def put(self, place: int, length_place: int, data: bytes) -> None:
        """Write as much of the data as the program's length permits, and then its full length."""
        self.write(place, data[: self.length_at(length_place)])
        self.write(length_place, _LENGTH.pack(len(data)))

    def scatter(self, parts: list[tuple[int, int]], data: bytes) -> int:
        """Write data into these parts; returns how many bytes had room."""
        done = 0
        for place, size in parts:
            self.write(place, data[done : done + size])
            done = min(len(data), done + size)
        return done

    def gather(self, parts: list[tuple[int, int]]) -> bytes:
        return b"".join(self.read(place, size) for place, size in parts)

    def inode(self, descriptor: int) -> int:
        """The inode of a socket; 0 if the descriptor is no socket."""
        try:
            target = os.readlink(f"/proc/{self._thread}/fd/{descriptor}")
        except OSError:
            return 0
        return int(target[8:-1]) if target.startswith("socket:[") else 0

    def fetch(self, descriptor: int) -> int:
        """A copy of a descriptor of the program."""
        with open(f"/proc/{self._thread}/status", encoding="utf-8", errors="replace") as file:
            process = next(int(line.split()[1]) for line in file if line.startswith("Tgid:"))
        return fetched(process, descriptor)
