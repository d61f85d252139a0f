"""The INT 2Dh interface over the library and a hub: an assembly language program sends and receives."""

from __future__ import annotations

import importlib
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest

from canwire import Frame, acan
from canwire.acan import ACANHI, ACANID, ACANMB, ACANMBSZ, ACANTB, Action, Condition, HardConfig
from canwire.acan.int2d import Int2d, find_driver
from canwire.acan.real_mode import ByteMemory, FarPointer, Registers
from tests.acan.bench import Peer

api = importlib.import_module("canwire.acan.api")

CONFIG, BLOCK, MESSAGE = FarPointer(0x2000, 0), FarPointer(0x2100, 0), FarPointer(0x2200, 0)
FIFO, BUFFER, VARIABLE = FarPointer(0x3000, 0), FarPointer(0x3100, 0), FarPointer(0x4000, 0)
LONG = 30  # seconds


class Program:
    """What an assembly language program does, and the events ADTM would give it."""

    def __init__(self) -> None:
        self.memory = ByteMemory()
        self.event = threading.Event()
        self.events: list[tuple[int, int]] = []
        self.driver = Int2d(api, self.memory, notify_event=self._notified)

    def call(self, service: int, at: FarPointer = CONFIG, **more: int) -> Registers:
        registers = Registers(AX=service, ES=at.segment, BX=at.offset)
        for name, value in more.items():
            setattr(registers, name, value)
        self.driver.call_far(registers)
        return registers

    def register(self) -> int:
        """A block for every message, with one channel for 123h."""
        channel = ACANID(0x1FFF_FFFF, 0x123 << 18, Action.CHANRCV, bLength=4, lpAddress=far(VARIABLE))
        block = ACANTB(
            wTid=3,
            wEvent=4,
            bSCFilter=0xFF,
            lpRMB=far(FIFO),
            wRMBSize=8,
            lpBuf=far(BUFFER),
            wCount=4,
            idTable=[ACANID(bAction=Action.NOTIFY | Action.QUEUE), channel],
        )
        self.memory.write(BLOCK, block.pack())
        return self.call(acan.ACAN_REGISTER, BLOCK).AX

    def start(self) -> None:
        self.memory.write(CONFIG, HardConfig().pack())
        assert self.call(acan.ACAN_HARD_CONFIGURE, CONFIG).AX == 1
        assert self.register() == 1
        assert self.call(acan.ACAN_HARD_CONTROL, DL=1).AX == 0x0001

    def wait(self) -> ACANTB:
        """Until notified; the block's head as it is in memory then."""
        assert self.event.wait(LONG)
        self.event.clear()
        return ACANTB.unpack_head(self.memory.read(BLOCK, ACANTB.SIZE))

    def message(self, number: int = 0, at: FarPointer = BUFFER) -> ACANMB:
        return ACANMB.unpack(self.memory.read(at + number * ACANMBSZ, ACANMBSZ))

    def _notified(self, tid: int, event: int) -> None:
        self.events.append((tid, event))
        self.event.set()


def far(at: FarPointer) -> int:
    return at.segment << 16 | at.offset


@pytest.fixture
def program(hub: Any) -> Iterator[Program]:
    api.use(hub)
    assert api.ACAN_Init()
    yield Program()
    api.use(None)


@pytest.mark.conforms("AC-38")
def test_the_driver_is_found_and_says_what_it_is(program: Program) -> None:
    assert find_driver(program.memory, program.driver.interrupt) == program.driver.multiplex
    found = program.call(acan.ACAN_GET_VERSION_1)
    assert (api.ACAN_GetDriverVersion(), acan.CANC_SJA1000, 0) == (found.AX, found.DL, found.DH)
    assert program.call(acan.ACAN_HARD_STATUS, CONFIG).AX == 0


@pytest.mark.conforms("AC-38")
def test_what_is_configured_is_read_back(program: Program) -> None:
    program.start()
    elsewhere = FarPointer(0x5000, 0)
    assert program.call(acan.ACAN_HARD_STATUS, elsewhere).AX == 1
    assert ACANHI.unpack(program.memory.read(elsewhere, ACANHI.SIZE)) == HardConfig().to_hi()
    assert program.call(acan.ACAN_GET_VERSION).DH == 1
    assert program.call(acan.ACAN_HARD_CONTROL, DL=0).AX == 0x0100


@pytest.mark.conforms("AC-38")
def test_a_received_message_arrives_in_memory(program: Program, peer: Peer) -> None:
    program.start()
    peer.send(Frame(0x123, b"data"))
    seen = program.wait()
    assert program.events[0] == (3, 4)
    assert seen.wStatus & acan.TBS_MB
    assert seen.wRMBOccupation == 1
    expected = ACANMB(0x123 << 18, 0, 4, b"data")
    assert program.message(at=FIFO) == expected
    assert program.memory.read(VARIABLE, 5) == b"data\0"
    assert program.call(acan.ACAN_ACK, BLOCK).AL & acan.TBS_MB
    assert program.call(acan.ACAN_RECEIVE, BLOCK).AX == 1
    assert program.message() == expected
    assert program.call(acan.ACAN_RECEIVE, BLOCK).AX == 0
    assert program.call(acan.ACAN_ACK, BLOCK).AX == 0
    assert program.call(acan.ACAN_FREE, BLOCK).AX == 1


@pytest.mark.conforms("AC-38")
def test_a_sent_message_arrives_at_others(program: Program, peer: Peer) -> None:
    program.start()
    program.memory.write(MESSAGE, ACANMB(0x1234_5678, acan.FF_EXTENDED, 2, b"hi").pack())
    assert program.call(acan.ACAN_SEND, MESSAGE, CL=1).AX == 1
    got = peer.receive()
    assert (got.id, got.extended, got.data) == (0x1234_5678, True, b"hi")


@pytest.mark.conforms("AC-38")
@pytest.mark.finding("acan A5")
def test_memory_is_current_without_any_call(program: Program, peer: Peer) -> None:
    """A filter that queues but does not notify, and a program that polls its Task Block."""
    program.memory.write(CONFIG, HardConfig().pack())
    assert program.call(acan.ACAN_HARD_CONFIGURE, CONFIG).AX == 1
    block = ACANTB(lpRMB=far(FIFO), wRMBSize=8, idTable=[ACANID(bAction=Action.QUEUE)])
    program.memory.write(BLOCK, block.pack())
    assert program.call(acan.ACAN_REGISTER, BLOCK).AX == 1
    assert program.call(acan.ACAN_HARD_CONTROL, DL=1).AX == 0x0001
    peer.send(Frame(1), Frame(2))
    ends_s = time.monotonic() + LONG
    while ACANTB.unpack_head(program.memory.read(BLOCK, ACANTB.SIZE)).wRMBOccupation < 2:
        assert time.monotonic() < ends_s
        time.sleep(0.001)  # the program polls: nothing signals it
    seen = ACANTB.unpack_head(program.memory.read(BLOCK, ACANTB.SIZE))
    assert (seen.wStatus & acan.TBS_MB, seen.wWIndex, program.events) == (acan.TBS_MB, 2, [])


def test_a_block_that_cannot_be_registered(program: Program) -> None:
    both = ACANID(bAction=Action.CHANRCV | Action.CHANSND, bLength=4, lpAddress=far(VARIABLE))
    program.memory.write(BLOCK, ACANTB(idTable=[both]).pack())
    assert program.call(acan.ACAN_REGISTER, BLOCK).AX == 0
    assert program.register() == 1
    assert program.register() == 0


@pytest.mark.conforms("N-11")
def test_disturbed_messages_take_it_off_the_bus_and_memory_says_so(program: Program, hub: Any) -> None:
    """Each attempt costs 8 of TEC, and at 256 it is off the bus."""
    program.start()
    off = hub.bus("can0").faults.inject("bit", frame_id=1, times=None)
    program.memory.write(MESSAGE, ACANMB(1 << 18).pack())
    seen = Condition(0)
    while not seen & Condition.BUSOFF:
        program.call(acan.ACAN_SEND, MESSAGE, CL=1)
        program.wait()
        seen |= Condition(program.call(acan.ACAN_ACK, BLOCK).AH)
    assert seen == Condition.BUSERR | Condition.ERRLIM | Condition.ERRPAS | Condition.BUSOFF
    assert off.struck == 32
