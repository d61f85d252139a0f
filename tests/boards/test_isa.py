"""Several boards in one PC: addresses, interrupt lines, and who is in whose way."""

from __future__ import annotations

import pytest

from canwire.boards.inducan104 import InduCan104
from canwire.boards.isa import IsaBus, IsaPlace
from canwire.errors import BadValue, InUse, NoSuchBoard
from tests.cases import each


class Chip:
    """Registers that are nothing but memory."""

    def __init__(self) -> None:
        self.registers = bytearray(128)
        self.interrupt = False
        self.on_interrupt = None

    def read(self, address: int) -> int:
        return self.registers[address]

    def write(self, address: int, value: int) -> None:
        self.registers[address] = value


def board(base: int = 0x280, irq: int = 5, *, shared: bool = False) -> InduCan104:
    return InduCan104(base, irq, Chip(), shared_irq=shared)


def request(card: InduCan104) -> None:
    card.chip.interrupt = True  # type: ignore[misc]
    assert card.chip.on_interrupt is not None
    card.chip.on_interrupt()


@pytest.mark.conforms("AC-01", "AC-02")
def test_boards_by_address() -> None:
    machine = IsaBus()
    one, two = board(), board(0x300, 10)
    machine.plug("one", one)
    machine.plug("two", two)
    assert dict(machine.cards) == {"one": one, "two": two}
    machine.write(0x280, 0x11)
    machine.write(0xF1F, 0x22)
    assert (one.chip.read(0), two.chip.read(127)) == (0x11, 0x22)
    assert (machine.read(0x280), machine.read(0xF1F), machine.read(0x31F)) == (0x11, 0x22, 0)


def test_empty_ports() -> None:
    machine = IsaBus()
    assert machine.read(0x280) == 0xFF
    machine.plug("one", board())
    assert [machine.read(port) for port in (0x27F, 0x2A0, 0, 0xFFFF)] == [0xFF] * 4
    machine.write(0x2A0, 0x11)
    machine.unplug("one")
    assert machine.read(0x280) == 0xFF


@pytest.mark.parametrize("port", [-1, 0x10000])
def test_ports_that_do_not_exist(port: int) -> None:
    with pytest.raises(BadValue, match="0 to 0xFFFF"):
        IsaBus().read(port)
    with pytest.raises(BadValue, match="0 to 0xFFFF"):
        IsaBus().write(port, 0)


@pytest.mark.parametrize("value", [-1, 0x100])
def test_values_that_are_no_bytes(value: int) -> None:
    with pytest.raises(BadValue, match="for port 080h: 0 to 0xFF"):
        IsaBus().write(0x80, value)


@pytest.mark.conforms("AC-04")
def test_one_address_for_two() -> None:
    machine = IsaBus()
    machine.plug("HW000001", board())
    with pytest.raises(InUse) as error:
        machine.plug("HW000002", board(irq=3))
    assert str(error.value) == (
        "HW000002 and HW000001 are both at 280h; give one of them another base address"
    )
    assert list(machine.cards) == ["HW000001"]
    machine.unplug("HW000001")
    machine.plug("HW000002", board(irq=3))


@pytest.mark.conforms("AC-03")
@each(("first", "second"), [(False, False), (True, False), (False, True)])
def test_one_interrupt_line_for_two(first: bool, second: bool) -> None:
    machine = IsaBus()
    machine.plug("HW000001", board(shared=first))
    with pytest.raises(InUse) as error:
        machine.plug("HW000002", board(0x300, shared=second))
    assert str(error.value) == (
        "HW000002 and HW000001 both use IRQ 5; give one of them another, or install both as shared (5*)"
    )


@pytest.mark.conforms("AC-05")
def test_a_shared_interrupt_line() -> None:
    machine, served = IsaBus(), []
    one, two = board(shared=True), board(0x300, shared=True)
    machine.plug("one", one)
    machine.plug("two", two)
    machine.connect(5, lambda: served.append("one's driver"))
    machine.connect(5, lambda: served.append("two's driver"))
    machine.connect(7, lambda: served.append("never"))
    request(two)
    assert served == ["one's driver", "two's driver"]
    assert (machine.irq_pending(5), machine.irq_pending(7)) == (True, False)
    assert (one.led, two.led) == (False, True)


@pytest.mark.conforms("AC-03")
def test_handlers_come_and_go() -> None:
    machine, served = IsaBus(), []
    card = board()
    machine.plug("one", card)

    def serve() -> None:
        served.append(1)
        machine.disconnect(5, serve)

    machine.connect(5, serve)
    request(card)
    request(card)
    machine.disconnect(5, serve)
    machine.disconnect(3, serve)
    assert served == [1]
    machine.connect(5, serve)
    machine.unplug("one")
    request(card)  # pulled out: its line ends in the air
    assert served == [1]
    assert not machine.irq_pending(5)


def test_names() -> None:
    machine = IsaBus()
    machine.plug("one", board())
    with pytest.raises(InUse, match="a board one is plugged in already"):
        machine.plug("one", board(0x300, 3))
    with pytest.raises(NoSuchBoard, match="no board 'two' to unplug; plugged in: one"):
        machine.unplug("two")


def test_resources() -> None:
    assert IsaPlace(0x280, 5).resources == (("I/O", "280h-29Fh"), ("IRQ", "5"))
    assert IsaPlace(0x3E0, 11, True).resources == (("I/O", "3E0h-3FFh"), ("IRQ", "11*"))
