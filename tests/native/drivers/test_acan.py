"""ACAN in C: messages, channels, task blocks and callbacks, with a node outside; and what goes wrong."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

import pytest

import canwire
from canwire import Frame
from tests.candrv.bench import Peer
from tests.native.drivers.conftest import PROGRAMS, Build, Machine

ASKED = (0x201 << 18).to_bytes(4, "little") + bytes(
    [0, 2]
)  # a channel's request: the answer's identifier, format, length


@pytest.fixture
def peer(machine: Machine) -> Iterator[Peer]:
    with canwire.connect(machine.address) as hub, contextlib.closing(Peer(hub, rate=500_000)) as made:
        yield made


@pytest.mark.conforms("N-42", "N-45")
def test_an_application_as_the_manual_has_it(build: Build, machine: Machine, peer: Peer) -> None:
    program = machine.start(build(PROGRAMS / "acan.c", "acan"))
    assert program.stdout is not None
    assert program.stdout.readline() == "send\n", program.communicate()
    peer.send(
        Frame(0x123, b"\x11\x55"),
        Frame(0x124, b"not notified"[:8]),
        Frame(0x123),
        Frame(0x100, b"abc"),
        Frame(0x200, ASKED),
        Frame(0x123, remote=True, dlc=0),
    )
    sent = [peer.receive() for _ in range(7)]
    out, errors = program.communicate("\n", timeout=60)
    assert (program.returncode, out) == (0, "ACAN did what it says\n"), errors
    assert set(sent) == {  # in the order of their priorities, as far as they waited for each other
        Frame(0x201, b"\x12\x34"),
        Frame(0x321, b"12345678"),
        Frame(0x1ABCDEF0, b"\x09", extended=True),
        Frame(0x123, b"\x07"),
        Frame(0x555),
    }
