"""The helper of a program on Windows, by a test in the program's place: what it says, and who is turned away."""

from __future__ import annotations

import os
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from uuid import UUID

import pytest

from canwire.native.helper.far import TOKEN
from tests.hubs import LONG_S, Served, status_of

SIGNALLED, OVER, RING, HEAR, FORGET = range(1, 6)
PROGRAM = "from canwire.native.helper.main import main; main()"
SECRET = bytes(range(32))
MAGIC = (0x000147574E414301).to_bytes(8, "little")  # ../../src/canwire/native/core/ring.c
IID_READER = UUID("19286603-A9CD-433A-A495-72E5C9D97A97")
IID_WRITER = UUID("E1CC08CE-99C0-483B-8E5F-4C43358E1CE2")


class Program:
    """It has started a helper that has called back."""

    def __init__(self, hub: str) -> None:
        with socket.create_server(("127.0.0.1", 0)) as listener:
            listener.settimeout(LONG_S)
            port = listener.getsockname()[1]
            settings = {**os.environ, "CANWIRE_HUB": hub, TOKEN: SECRET.hex()}
            self.helper = subprocess.Popen(
                [sys.executable, "-P", "-c", PROGRAM, str(os.getpid()), "far.exe", str(port)], env=settings
            )
            self.lifeline, _ = listener.accept()
        self.lifeline.settimeout(LONG_S)
        assert whole(self.lifeline, len(SECRET)) == SECRET
        (self.port,) = struct.unpack("<H", whole(self.lifeline, 2))
        self._calls = self.dial(SECRET + b"C")
        self.said = 0  # on the lifeline, as the last reply counts it

    def dial(self, hello: bytes) -> socket.socket:
        made = socket.create_connection(("127.0.0.1", self.port), LONG_S)
        made.sendall(hello)
        return made

    def call(self, method: str, number: int = 0, data: bytes = b"") -> tuple[int, int, bytes, list[str]]:
        """Its code, its number, its data, and what it passes on."""
        self._calls.sendall(struct.pack("<40sII", method.encode(), number, len(data)) + data)
        result, value, size, count, self.said = struct.unpack("<iIIII", whole(self._calls, 20))
        told = whole(self._calls, size)
        names = [whole(self._calls, 64).rstrip(b"\0").decode() for _ in range(count)]
        return result, value, told, names

    def say(self, what: int, number: int) -> None:
        self.lifeline.sendall(struct.pack("<II", what, number))

    def hear(self) -> tuple[int, int]:
        what, number = struct.unpack("<II", whole(self.lifeline, 8))
        return what, number

    def close(self) -> None:
        self._calls.close()
        self.lifeline.close()
        assert self.helper.wait(LONG_S) == 0


def whole(connection: socket.socket, size: int) -> bytes:
    parts = b""
    while len(parts) < size:
        more = connection.recv(size - len(parts))
        assert more, "the helper has closed it"
        parts += more
    return parts


@pytest.fixture
def program(hub: Served) -> Iterator[Program]:
    made = Program(hub.address)
    yield made
    made.close()


class End:
    """One end of a FIFO for eight elements of 16 bytes, which a call's answer gave to the program."""

    def __init__(self, answer: tuple[int, int, bytes, list[str]], *, peer: bool) -> None:
        result, self.number, data, names = answer
        assert result == 0
        self.begin, capacity, size, self.reads, _ = struct.unpack_from("<QIIII", data)
        assert capacity >= 8
        assert size == 16
        self.id = data[-8:]
        assert [name.split()[0] for name in names] == ["file", "signal"] + ["signal"] * peer
        self.file = Path(names[0].split()[1])
        self.own, self.peer = int(names[1].split()[1]), int(names[-1].split()[1])


def reader_of(program: Program) -> End:
    words = struct.pack("<HH", 8, 16) + IID_READER.bytes_le
    return End(program.call("vci.create_fifo", data=words), peer=True)


def writer_of(program: Program, fifo: bytes) -> End:
    return End(program.call("vci.access_fifo", data=fifo + IID_WRITER.bytes_le), peer=True)


def test_memory_is_a_file_and_signals_are_numbers(program: Program) -> None:
    assert program.call("vci.initialize")[0] == 0
    reader = reader_of(program)
    writer = writer_of(program, reader.id)
    with reader.file.open("rb") as memory, writer.file.open("rb") as same:
        memory.seek(reader.begin)
        assert memory.read(8) == MAGIC
        assert os.path.sameopenfile(memory.fileno(), same.fileno())
    program.say(HEAR, reader.own)
    program.say(RING, writer.peer)
    assert program.hear() == (SIGNALLED, reader.own)


def test_what_is_over_is_told_even_to_who_listens_late(program: Program) -> None:
    early, late = reader_of(program), reader_of(program)
    writer = writer_of(program, early.id)
    assert program.said == 0
    program.say(HEAR, early.own)
    program.say(RING, writer.peer)
    assert program.hear() == (SIGNALLED, early.own)  # so it listens by now
    program.call("vci.release", early.number)
    assert program.said == 2  # its program waits until it has heard this
    assert program.hear() == (OVER, early.own)
    program.call("vci.release", late.number)
    assert program.said == 3
    program.say(HEAR, late.own)
    assert {program.hear(), program.hear()} == {(OVER, late.own)}
    program.say(FORGET, late.own)  # and numbers that mean nothing any more are ignored
    program.say(RING, late.peer)
    program.say(HEAR, late.own)
    assert program.call("vci.initialize")[0] == 0


def test_a_list_of_devices_is_watched(program: Program, hub: Served) -> None:
    _, manager, _, _ = program.call("vci.get_device_manager")
    _, devices, _, _ = program.call("vci.VciDeviceManager.enum_devices", manager)
    result, _, _, names = program.call("vci.watch", devices, b"\1")
    assert result == 0
    number = int(names[0].removeprefix("signal "))
    program.say(HEAR, number)
    assert status_of("unplug", "HW000004", "--hub", hub.address) == 0
    assert program.hear() == (SIGNALLED, number)
    program.call("vci.release", devices)
    program.say(FORGET, number)  # after what it is of was closed
    assert program.call("vci.initialize")[0] == 0


def test_an_answer_has_its_interfaces_code(program: Program) -> None:
    assert program.call("vci.CanControl.reset_line", 77)[0] & 0xFFFFFFFF == 0xE0010004  # VCI_E_INVALIDARG
    assert program.call("nobodys.call")[0] == -1


def test_strangers_are_turned_away(program: Program) -> None:
    with program.dial(bytes(32) + b"C") as stranger:
        assert stranger.recv(1) == b""
    assert program.call("vci.initialize")[0] == 0


def test_it_ends_with_the_program(program: Program) -> None:
    program.lifeline.close()  # while another connection is still there
    assert program.helper.wait(LONG_S) == 0
