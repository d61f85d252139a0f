"""Assembly language programs find and call the driver, byte by byte. Source: INduCAN104 manual, annex A."""

# ruff: noqa: N802, N803 - the double has the manual's names
from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue
from canwire.acan import ACANHI, ACANID, ACANMB, ACANMBSZ, ACANTB, Action, HardConfig, Services
from canwire.acan.int2d import Int2d, find_driver
from canwire.acan.real_mode import MEGABYTE, ByteMemory, FarPointer, Registers

VECTOR = FarPointer(0x0000, 0x00B4)
PLACE = FarPointer(0x2000, 0x0010)  # of structures
BUFFER, FIFO, VARIABLE = FarPointer(0x3000, 0), FarPointer(0x3800, 0), FarPointer(0x4000, 0x0002)
PRESERVED = ("BX", "SI", "DI", "BP", "SP", "DS", "SS")


class Recorder:
    """A library that remembers how it was called, answers `answer`, and can be told to receive messages."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self.answer: Any = True
        self.hi: ACANHI | None = None
        self.blocks: list[ACANTB] = []
        self.received: list[ACANMB] = []

    def ACAN_GetDriverVersion(self) -> int:
        return 0x0102

    def ACAN_GetInitStatus(self) -> int:
        return 0x0100 if self.hi else 0

    def ACAN_SetHardConfig(self, lpHI: ACANHI) -> bool:
        self.calls.append(("ACAN_SetHardConfig", lpHI))
        self.hi = lpHI if self.answer else None
        return bool(self.answer)

    def ACAN_GetHardConfig(self, lpHI: ACANHI) -> bool:
        if self.hi:
            lpHI.assign(self.hi)
        return self.hi is not None

    def ACAN_BusControl(self, bsNewState: int) -> int:
        self.calls.append(("ACAN_BusControl", bsNewState))
        return (1 - bsNewState) << 8 | bsNewState

    def ACAN_Register(self, lpTB: ACANTB) -> bool:
        self.calls.append(("ACAN_Register", lpTB))
        if self.answer:
            self.blocks.append(lpTB)
        return bool(self.answer)

    def ACAN_AckEventCheck(self, lpTB: ACANTB) -> int:
        self.calls.append(("ACAN_AckEventCheck", lpTB))
        status, lpTB.wStatus = lpTB.wStatus, 0
        return status

    def ACAN_Deregister(self, lpTB: ACANTB) -> bool:
        self.calls.append(("ACAN_Deregister", lpTB))
        self.blocks.remove(lpTB)
        return True

    def ACAN_SendMessage(self, lpMsg: ACANMB, bPrio: int) -> bool:
        self.calls.append(("ACAN_SendMessage", lpMsg, bPrio))
        return bool(self.answer)

    def ACAN_RetrieveMessages(self, lpTB: ACANTB) -> int:
        self.calls.append(("ACAN_RetrieveMessages", lpTB))
        if lpTB.lpBuf is None:
            return -1
        taken, self.received = self.received[: lpTB.wCount], self.received[lpTB.wCount :]
        for number, message in enumerate(taken):
            lpTB.lpBuf[number * ACANMBSZ : (number + 1) * ACANMBSZ] = message.pack()
        lpTB.wRMBOccupation = len(self.received)
        return len(taken)


class Machine:
    """Memory, the driver in it, and the events it notified."""

    def __init__(self) -> None:
        self.memory = ByteMemory()
        self.library = Recorder()
        self.events: list[tuple[int, int]] = []
        services: Services = self.library
        self.driver = Int2d(
            services,
            self.memory,
            0xD7,
            trapped=[0x0D],
            notify_event=lambda tid, event: self.events.append((tid, event)),
        )

    def int2d(self, **registers: int) -> Registers:
        made = Registers(**registers)
        self.driver.interrupt(made)
        return made

    def call(self, service: int, at: FarPointer = PLACE, **registers: int) -> Registers:
        """A far call to the entry point; the registers it has to preserve are compared here."""
        made = Registers(BX=at.offset, ES=at.segment, SI=1, DI=2, BP=3, SP=4, DS=5, SS=6, CX=7, DX=0x0800)
        made.AH = 0xEE
        for name, value in {"AL": service, **registers}.items():
            setattr(made, name, value)
        before = {name: getattr(made, name) for name in PRESERVED}
        self.driver.call_far(made)
        assert {name: getattr(made, name) for name in PRESERVED} == before
        return made

    def status(self, at: FarPointer = PLACE) -> ACANTB:
        """The Task Block's head as the application sees it."""
        return ACANTB.unpack_head(self.memory.read(at, ACANTB.SIZE))


@pytest.fixture
def machine() -> Iterator[Machine]:
    made = Machine()
    assert made.driver.active
    return made


def block(**fields: Any) -> ACANTB:
    given_ = {
        "wTid": 7,
        "wEvent": 0x20,
        "bSCFilter": 0x83,
        "lpRMB": dword(FIFO),
        "wRMBSize": 16,
        "lpBuf": dword(BUFFER),
        "wCount": 2,
        "idTable": [ACANID(bAction=Action.NOTIFY | Action.QUEUE)],
    }
    return ACANTB(**{**given_, **fields})


def dword(at: FarPointer) -> int:
    return at.segment << 16 | at.offset


def asciiz(memory: ByteMemory, at: FarPointer) -> bytes:
    return memory.read(at, 80).partition(b"\0")[0]


# finding the driver


@pytest.mark.finding("acan A4")
@pytest.mark.conforms("AC-38")
def test_the_check_answers_with_the_signature(machine: Machine) -> None:
    found = machine.int2d(AX=0xD700)
    assert (found.AH, found.AL, found.CX) == (0xD7, 0xFF, 0x0100)
    text = FarPointer(found.DX, found.BX)
    assert machine.memory.read(text, 16) == b"Aton SysACAN    "
    assert asciiz(machine.memory, text + 16) == b"ATON Controller Area Network Driver"


@pytest.mark.conforms("AC-38")
def test_an_application_finds_the_driver(machine: Machine) -> None:
    assert machine.memory.read_pointer(VECTOR)
    assert find_driver(machine.memory, machine.driver.interrupt) == 0xD7


@pytest.mark.conforms("AC-38")
def test_without_driver_nothing_is_found() -> None:
    memory = ByteMemory()
    assert find_driver(memory, lambda _: pytest.fail("the vector is NULL")) is None
    memory.write_pointer(VECTOR, FarPointer(0xF000, 0x1234))
    assert find_driver(memory, lambda registers: None) is None


@pytest.mark.conforms("AC-38")
def test_another_resident_program_is_not_taken_for_acan(machine: Machine) -> None:
    other = FarPointer(0x0900, 0)
    machine.memory.write(other, b"RALF BRNSPOOL   ")

    def both(registers: Registers) -> None:
        if registers.AH == 0x10 and registers.AL == 0:
            registers.AL = 0xFF
            registers.DX, registers.BX = other
        machine.driver.interrupt(registers)

    assert find_driver(machine.memory, both) == 0xD7


@pytest.mark.conforms("AC-38")
@given(
    number=st.integers(0, 255).filter(lambda number: number != 0xD7),
    function=st.integers(0, 255),
    words=st.integers(0, 0xFFFF),
)
def test_other_multiplex_numbers_leave_registers_alone(number: int, function: int, words: int) -> None:
    driver = Int2d(Recorder(), ByteMemory(), 0xD7)
    registers = Registers(number << 8 | function, *[words] * 10)
    before = Registers(number << 8 | function, *[words] * 10)
    driver.interrupt(registers)
    assert registers == before


@pytest.mark.conforms("AC-38")
def test_the_entry_point_is_a_place_in_the_drivers_memory(machine: Machine) -> None:
    found = machine.int2d(AX=0xD701)
    assert found.AL == 0xFF
    assert FarPointer(found.DX, found.BX) == machine.driver.entry_point
    assert machine.memory.read(machine.driver.entry_point, 1) == b"\xcb"  # RETF


@pytest.mark.conforms("AC-38")
def test_trapped_interrupts_end_with_2dh(machine: Machine) -> None:
    found = machine.int2d(AX=0xD704)
    assert found.AL == 0x04
    listed = machine.memory.read(FarPointer(found.DX, found.BX), 6)
    handler = machine.memory.read_pointer(VECTOR)
    assert handler.segment == found.DX
    assert listed == b"\x0d" + handler.offset.to_bytes(2, "little") + b"\x2d" + handler.offset.to_bytes(
        2, "little"
    )
    assert machine.memory.read(handler, 1) == b"\xcf"  # IRET


@pytest.mark.parametrize("function", [3, 5, 0x10, 0xFF])
def test_functions_that_do_not_exist(machine: Machine, function: int) -> None:
    found = machine.int2d(AX=0xD700 | function, BX=1, CX=2, DX=3)
    assert found == Registers(AX=0xD700, BX=1, CX=2, DX=3)


@pytest.mark.conforms("AC-38")
def test_uninstalled_it_is_gone() -> None:
    memory, before = ByteMemory(), FarPointer(0xF000, 0x1234)
    memory.write_pointer(VECTOR, before)
    driver = Int2d(Recorder(), memory, 3, segment=0x0C40)
    registers = Registers(AX=0x0302)
    driver.interrupt(registers)
    assert (registers.AL, registers.BX) == (0x04, 0x0C40)
    assert memory.read_pointer(VECTOR) == before
    assert find_driver(memory, driver.interrupt) is None
    called = Registers(AX=0x0000)
    driver.call_far(called)
    assert called.AX == 0


@pytest.mark.conforms("AC-38")
def test_it_cannot_be_uninstalled_while_in_use(machine: Machine) -> None:
    machine.memory.write(PLACE, block().pack())
    assert machine.call(4).AX == 1
    assert machine.int2d(AX=0xD702).AL == 0x01
    assert machine.call(6).AX == 1
    machine.memory.write_pointer(VECTOR, FarPointer(0x0A00, 0))  # somebody chained himself in
    assert machine.int2d(AX=0xD702).AL == 0x01
    assert machine.driver.active


@pytest.mark.finding("acan A15.7")
@pytest.mark.parametrize("number", [0, 0x100])
def test_multiplex_numbers_are_bytes_and_not_0(number: int) -> None:
    """The manual's program takes AH == 0 for "not installed"."""
    with pytest.raises(BadValue, match="multiplex"):
        Int2d(Recorder(), ByteMemory(), number)


# services


@pytest.mark.conforms("AC-09", "AC-10", "AC-38")
@pytest.mark.parametrize("service", [0, 9])
def test_version(machine: Machine, service: int) -> None:
    answer = machine.call(service)
    assert (answer.AH, answer.AL, answer.DL, answer.DH) == (1, 2, 0, 0)
    machine.library.hi = ACANHI()
    assert machine.call(service).DH == 1


@pytest.mark.conforms("AC-38")
def test_hard_configure_and_status(machine: Machine) -> None:
    assert machine.call(2).AX == 0
    hi = HardConfig(0x040000, 0x1C0000).to_hi()
    machine.memory.write(PLACE, hi.pack())
    assert machine.call(1).AX == 1
    assert machine.library.calls == [("ACAN_SetHardConfig", hi)]
    elsewhere = FarPointer(0x5000, 0)
    answer = machine.call(2, elsewhere)
    assert (answer.AX, answer.DL) == (1, 0)
    assert machine.memory.read(elsewhere, 32) == hi.pack()


@pytest.mark.conforms("AC-38")
def test_a_configuration_that_is_refused(machine: Machine) -> None:
    machine.library.answer = False
    assert machine.call(1).AX == 0
    machine.memory.write(PLACE, b"\xaa" * 32)
    assert machine.call(2).AX == 0
    assert machine.memory.read(PLACE, 32) == b"\xaa" * 32


@pytest.mark.conforms("AC-38")
@pytest.mark.parametrize(("wanted", "final", "original"), [(1, 1, 0), (0, 0, 1), (0x55, 1, 0)])
def test_hard_control(machine: Machine, wanted: int, final: int, original: int) -> None:
    answer = machine.call(3, DL=wanted)
    assert (final, original) == (answer.AL, answer.AH)
    assert machine.library.calls == [("ACAN_BusControl", final)]


@pytest.mark.conforms("AC-38")
def test_register_hands_memory_on_where_pointers_were(machine: Machine) -> None:
    channel = ACANID(0x1FFFFFFF, 0x40000, Action.CHANRCV, bLength=4, lpAddress=dword(VARIABLE))
    plain = ACANID(bAction=Action.QUEUE, bLength=3, lpAddress=dword(VARIABLE))
    machine.memory.write(PLACE, block(idTable=[channel, plain], dwRefData=0xCAFE).pack())
    assert machine.call(4).AX == 1
    [registered] = machine.library.blocks
    assert (registered.wTid, registered.bSCFilter, registered.dwRefData, registered.bNId) == (
        7,
        0x83,
        0xCAFE,
        2,
    )
    assert len(registered.lpRMB) == 16 * ACANMBSZ
    assert len(registered.lpBuf) == 2 * ACANMBSZ
    registered.idTable[0].lpAddress[:] = b"data"
    assert machine.memory.read(VARIABLE, 5) == b"data\0"
    machine.memory.write(VARIABLE, b"back")
    assert bytes(registered.idTable[0].lpAddress) == b"back"
    assert registered.idTable[1].lpAddress is None


@pytest.mark.conforms("AC-38")
def test_register_fails(machine: Machine) -> None:
    machine.memory.write(PLACE, block().pack())
    machine.library.answer = False
    assert machine.call(4).AX == 0
    machine.library.answer = True
    assert machine.call(4, FarPointer(0, 0)).AX == 0
    assert machine.call(4).AX == 1
    assert machine.call(4).AX == 0  # it is registered
    assert machine.call(4, FarPointer(0x2001, 0)).AX == 0  # the same place by another pointer
    assert len(machine.library.blocks) == 1


@pytest.mark.parametrize("kind", [1, 2, 99])
def test_ms_dos_knows_only_events(machine: Machine, kind: int) -> None:
    machine.memory.write(PLACE, block(bNotType=kind).pack())
    assert machine.call(4).AX == 0
    assert machine.library.calls == []


@pytest.mark.conforms("AC-27", "AC-38")
def test_what_the_driver_updates_appears_in_memory(machine: Machine) -> None:
    machine.memory.write(PLACE, block(dwFree=0x12345678).pack())
    machine.call(4)
    [registered] = machine.library.blocks
    registered.wStatus, registered.bREC, registered.bTEC, registered.bALC, registered.bECC = (
        0x8003,
        1,
        2,
        3,
        4,
    )
    registered.wRMBOccupation, registered.wRIndex, registered.wWIndex = 5, 6, 7
    registered.cbNotification(registered)
    assert machine.events == [(7, 0x20)]
    seen = machine.status()
    assert (seen.wStatus, seen.bREC, seen.bTEC, seen.bALC, seen.bECC) == (0x8003, 1, 2, 3, 4)
    assert (seen.wRMBOccupation, seen.wRIndex, seen.wWIndex) == (5, 6, 7)
    expected = block(
        dwFree=0x12345678,
        wStatus=0x8003,
        bREC=1,
        bTEC=2,
        bALC=3,
        bECC=4,
        wRMBOccupation=5,
        wRIndex=6,
        wWIndex=7,
    )
    assert machine.memory.read(PLACE, 80) == expected.pack()


@pytest.mark.conforms("AC-38")
def test_acknowledge(machine: Machine) -> None:
    machine.memory.write(PLACE, block().pack())
    machine.call(4)
    machine.library.blocks[0].wStatus = 0x8003
    machine.driver.refresh()
    assert machine.status().wStatus == 0x8003
    answer = machine.call(5)
    assert (answer.AL, answer.AH) == (0x03, 0x80)
    assert machine.status().wStatus == 0
    assert machine.call(5).AX == 0
    assert machine.call(5, BUFFER).AX == 0  # no Task Block


@pytest.mark.conforms("AC-38")
def test_free(machine: Machine) -> None:
    machine.memory.write(PLACE, block().pack())
    assert machine.call(6).AX == 0
    machine.call(4)
    registered = machine.library.blocks[0]
    assert machine.call(6).AX == 1
    assert machine.library.calls[-1] == ("ACAN_Deregister", registered)
    assert machine.call(6).AX == 0
    assert machine.call(4).AX == 1


@pytest.mark.conforms("AC-38")
def test_send(machine: Machine) -> None:
    message = ACANMB(0x048 << 18, bLength=1, bData=b"a")
    machine.memory.write(PLACE, message.pack())
    assert machine.call(7, CL=255).AX == 1
    assert machine.library.calls == [("ACAN_SendMessage", message, 255)]
    machine.library.answer = False
    assert machine.call(7, CL=0).AX == 0


@pytest.mark.conforms("AC-38")
def test_receive(machine: Machine) -> None:
    messages = [ACANMB(number << 18, bLength=1, bData=bytes([number])) for number in (1, 2, 3)]
    machine.memory.write(PLACE, block().pack())
    machine.call(4)
    machine.library.received = list(messages)
    assert machine.call(8).AX == 2
    assert machine.memory.read(BUFFER, 3 * ACANMBSZ) == messages[0].pack() + messages[1].pack() + bytes(
        ACANMBSZ
    )
    assert machine.status().wRMBOccupation == 1
    other = FarPointer(0x6000, 0)  # lpBuf and wCount may change from call to call
    machine.memory.write(PLACE, block(lpBuf=dword(other), wCount=8).pack())
    assert machine.call(8).AX == 1
    assert machine.memory.read(other, ACANMBSZ) == messages[2].pack()
    assert machine.call(8).AX == 0


@pytest.mark.conforms("AC-38")
def test_receive_fails(machine: Machine) -> None:
    assert machine.call(8).AX == 0xFFFF
    machine.memory.write(PLACE, block().pack())
    machine.call(4)
    machine.memory.write(PLACE, block(lpBuf=0).pack())
    assert machine.call(8).AX == 0xFFFF
    machine.memory.write(PLACE, block(lpBuf=0xFFFF_0000, wCount=8).pack())
    assert machine.call(8).AX == 0xFFFF


@pytest.mark.parametrize("service", [1, 2, 4, 7])
def test_structures_that_are_not_in_memory(machine: Machine, service: int) -> None:
    assert machine.call(service, FarPointer(0xFFFF, 0x000A)).AX == 0
    assert machine.call(service, FarPointer(0, 0)).AX == 0
    assert machine.library.calls == []


@pytest.mark.parametrize("service", [10, 0x80, 0xFF])
def test_services_that_do_not_exist(machine: Machine, service: int) -> None:
    assert machine.call(service).AX == 0
    assert machine.library.calls == []


@pytest.mark.conforms("AC-38")
@given(service=st.integers(0, 255), contents=st.binary(min_size=64, max_size=256))
def test_any_bytes_do_no_harm(service: int, contents: bytes) -> None:
    machine = Machine()
    machine.memory.write(PLACE, contents)
    machine.call(service)
    machine.call(service, FarPointer(0xFFFF, 0x0000))


# real mode


def test_far_pointers() -> None:
    assert FarPointer(0x1234, 0x0005).linear == 0x12345
    assert FarPointer(0xFFFF, 0x0010).linear == 0  # no line A20
    assert FarPointer.of(0x1234_0005) == FarPointer(0x1234, 0x0005)
    assert FarPointer(1, 0xFFFF) + 1 == FarPointer(1, 0)
    assert not FarPointer(0, 0)
    assert FarPointer(0, 1)
    assert str(FarPointer(0xC00, 0x10)) == "0C00:0010"


@given(segment=st.integers(0, 0xFFFF), offset=st.integers(0, 0xFFFF), data=st.binary(min_size=1, max_size=16))
def test_memory(segment: int, offset: int, data: bytes) -> None:
    memory, at = ByteMemory(), FarPointer(segment, offset)
    if at.linear + len(data) > MEGABYTE:
        with pytest.raises(BadValue, match="over the end"):
            memory.write(at, data)
        return
    memory.write(at, data)
    assert memory.read(at, len(data)) == data
    same = FarPointer(at.linear >> 4, at.linear & 15)
    assert bytes(memory.view(same, len(data))) == data


def test_pointers_lie_in_memory_offset_first() -> None:
    memory = ByteMemory()
    memory.write_pointer(FarPointer(0, 8), FarPointer(0x1234, 0x5678))
    assert memory.read(FarPointer(0, 8), 4) == bytes.fromhex("78563412")
    assert memory.read_pointer(FarPointer(0, 8)) == FarPointer(0x1234, 0x5678)


def test_registers_and_their_halves() -> None:
    registers = Registers(AX=0x1234)
    assert (registers.AH, registers.AL) == (0x12, 0x34)
    registers.AL, registers.DH = 0xFF, 0x80
    assert (registers.AX, registers.DX) == (0x12FF, 0x8000)
    for name, value in [("AL", 0x100), ("AH", -1), ("CX", 0x10000), ("BX", "1")]:
        with pytest.raises(BadValue, match=name):
            setattr(registers, name, value)
