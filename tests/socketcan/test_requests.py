"""Requests of any values: an error of who asks, and of nobody else."""

from __future__ import annotations

import errno
import os
import random
import socket
import struct
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any, cast

import pytest

import canwire
from canwire import WantedMode
from canwire.socketcan.constants import CAN_BCM, CAN_ISOTP, CAN_J1939, CAN_RAW, SOCK_DGRAM, SOCK_RAW
from canwire.socketcan.launch import shim
from canwire.socketcan.requests.operations import Operation
from canwire.socketcan.server import Server
from canwire.socketcan.sockets.packet import PACKET
from canwire.socketcan.timed.timers import TimerDescriptors, TimerSignal
from tests.cases import each
from tests.hubs import LONG_S

REQUEST, ANSWER = struct.Struct("<Iiiii"), struct.Struct("<q")
KINDS = [(SOCK_RAW, CAN_RAW), (SOCK_DGRAM, CAN_BCM), (SOCK_DGRAM, CAN_ISOTP), (SOCK_DGRAM, CAN_J1939)]
KINDS += [(SOCK_RAW, PACKET << 16 | 0x0300)]
LEAST_ERRNO = -4095


class Served:
    """A server in this process, asked as the shim asks."""

    def __init__(self, folder: Path, time: str = "virtual") -> None:
        self.said: list[str] = []
        self._path = str(folder / "control")
        self._hub = canwire.connect(time=time)
        self._server = Server(self._hub, str(folder), shim(), {}, WantedMode(), 0, self.said.append)
        self._program = os.pipe(), os.pipe()
        ends = tuple(reading for reading, _ in self._program)
        self._thread = threading.Thread(target=self._server.run, args=(ends,))
        self._thread.start()

    def ask(self, operation: int, slot: int = 0, a: int = 0, b: int = 0, data: bytes = b"") -> int | None:
        """What it answers; None where it answers later. A descriptor is let go of."""
        with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as asks:
            asks.connect(self._path)
            asks.settimeout(LONG_S if operation in (Operation.OPEN_SOCKET, Operation.PLACE_FILES) else 0.05)
            asks.send(REQUEST.pack(operation, slot, a, b, 1) + data)
            try:
                answer, descriptors, _, _ = socket.recv_fds(asks, 1 << 17, 1)
            except TimeoutError:
                return None
        for descriptor in descriptors:
            os.close(descriptor)
        return int(ANSWER.unpack_from(answer)[0])

    def close(self) -> None:
        for _, writing in self._program:
            os.close(writing)
        self._thread.join(LONG_S)
        for reading, _ in self._program:
            os.close(reading)
        self._hub.close()
        assert not self._thread.is_alive()


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    pytest.importorskip("numpy")
    made = Served(tmp_path)
    try:
        yield made
    finally:
        made.close()


@pytest.mark.parametrize("folder", [-3, 2, 1 << 20])
def test_a_folder_that_there_is_not(served: Served, folder: int) -> None:
    """An IndexError ended the server, and with it every socket of the run."""
    assert served.ask(Operation.PLACE_FILES, a=folder) == -errno.EINVAL
    assert served.ask(Operation.PLACE_FILES, a=0) == 0


def test_a_program_with_a_name_that_no_file_has(served: Served) -> None:
    assert served.ask(Operation.NOTE, a=3, data=b"a\0b") == 0
    assert served.ask(Operation.PLACE_FILES, a=0) == 0


def test_a_descriptor_that_is_not_seccomp_s(served: Served) -> None:
    """It was watched, and each look found it readable and nothing in it."""
    reading, writing = os.pipe()
    os.write(writing, b"not a notification")
    try:
        assert served.ask(Operation.SUPERVISE, a=reading) == -errno.EINVAL
    finally:
        os.close(reading)
        os.close(writing)


@each("signal", [TimerSignal(65), TimerSignal(-1), TimerSignal(10, 0, -5)])
def test_a_timer_with_a_signal_that_there_is_not(signal: TimerSignal) -> None:
    """It ended the server when it went off."""
    with pytest.raises(OSError, match="no signal"):
        TimerDescriptors(cast("Any", None)).open(os.getpid(), False, signal)


def test_any_values_are_an_error_of_who_asks(served: Served) -> None:
    """`python -m tests.socketcan.test_requests SEED COUNT` asks more."""
    assert fuzzed(served, random.Random(32), 300) == []


def fuzzed(served: Served, chance: random.Random, count: int) -> list[str]:
    """What went wrong."""
    wrong: list[str] = []
    for type, protocol in KINDS * 2:
        if served.ask(Operation.OPEN_SOCKET, a=type, b=protocol) != 0:
            wrong.append(f"no socket {type}, {protocol}")
    asked = [one for one in Operation if one is not Operation.SUPERVISE]
    for _ in range(count):
        words = chance.choice(asked), chance.randrange(9), number(chance), number(chance)
        data = some_bytes(chance)
        answer = served.ask(*words, data)
        if answer is not None and answer < LEAST_ERRNO:
            wrong.append(f"{words} {data!r}: {answer}")
    if served.ask(Operation.PLACE_FILES, a=1) != 0:
        wrong.append("the server answers no more")
    return wrong + [said for said in served.said if "canwire's own fault" in said]


def number(chance: random.Random) -> int:
    """One that is meant, or on an edge, or any."""
    return chance.choice(
        [
            chance.randrange(-2, 30),
            chance.choice([100 + CAN_RAW, 100 + CAN_BCM, 100 + CAN_ISOTP, 100 + CAN_J1939, 263, 1001, 24]),
            chance.choice([-(1 << 31), (1 << 31) - 1, 1 << 16, 0x100, 0x118]),
            chance.randrange(-(1 << 31), 1 << 31),
        ]
    )


def some_bytes(chance: random.Random) -> bytes:
    """An address of an interface that there is, the head of a BCM message, words, or anything."""
    kind = chance.randrange(4)
    if kind == 0:
        return struct.pack("<Hxxi", 29, chance.choice([0, 1001, 1002])) + chance.randbytes(
            chance.randrange(20)
        )
    if kind == 1:
        head = chance.randrange(9), chance.choice([0, 3, 0x800, 0xFFF]), chance.randrange(3), 0, 0, 0, 1
        frames = chance.randrange(3)
        frame = struct.pack("<IB3x8s", number(chance) & 0xFFFF_FFFF, chance.randrange(10), b"fuzz")
        return struct.pack("<III4xqqqqII", *head, 0x123, frames) + frame * frames
    if kind == 2:
        return b"".join(struct.pack("<i", number(chance)) for _ in range(chance.randrange(8)))
    return chance.randbytes(chance.choice([0, 1, 3, 4, 8, 16, 24, 28, 72, 200, 5000]))


def main(words: list[str]) -> None:
    """Ask so many more, with this seed; prints what went wrong."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        served = Served(Path(folder))
        try:
            print(
                "\n".join(fuzzed(served, random.Random(int(words[0])), int(words[1]))) or "nothing went wrong"
            )
        finally:
            served.close()


if __name__ == "__main__":
    import sys

    main(sys.argv[1:])
