"""The INduCAN104: an SJA1000 on a PC/104 board, whose jumpers set its address and its interrupt line.

Source: INduCAN104 manual ("Hardware description"). Its drawing labels an E12 too, but its list of levels
ends with IRQ 11; we follow the list.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

from canwire.boards.isa import FLOATING, IsaBus, IsaPlace
from canwire.errors import BadValue
from canwire.values.isa_address import (
    REGISTERS,
    USUAL_BASE,
    checked_base,
    checked_byte,
    port_of,
    register_at,
)

KIND = "inducan104"
IRQS = (3, 4, 5, 7, 9, 10, 11)
USUAL_IRQ = 5
OSCILLATOR_HZ = 16_000_000
_FIRST_LINE = 5  # E20 is compared with A5
_WORDS = {"P": True, "NP": False}


class Jumpers(NamedTuple):
    """The jumpers E24..E20, compared with A9..A5; True is present (P) and means 0. As delivered: 280h."""

    e24: bool = False
    e23: bool = True
    e22: bool = False
    e21: bool = True
    e20: bool = True

    @classmethod
    def for_base(cls, base: int) -> Jumpers:
        """The jumpers of this address; raises BadValue."""
        checked_base(base)
        lines = range(_FIRST_LINE + len(cls._fields) - 1, _FIRST_LINE - 1, -1)
        return cls(*(not base >> line & 1 for line in lines))

    @classmethod
    def parse(cls, text: str) -> Jumpers:
        """Parse a row of the manual's table, "NP P NP P P", E24 first; raises BadValue."""
        words = text.split()
        if len(words) != len(cls._fields) or not set(words) <= set(_WORDS):
            raise BadValue(f"jumpers {text!r}: P (present) or NP for each of E24 E23 E22 E21 E20")
        return cls(*(_WORDS[word] for word in words))

    @property
    def address(self) -> int:
        """The address that the jumpers select, which need not be possible for a board."""
        address = 0
        for present in self:
            address = address << 1 | (not present)
        return address << _FIRST_LINE

    @property
    def base(self) -> int:
        """The board's address; raises BadValue for the eight combinations below 100h, which are the PC's own."""
        try:
            return checked_base(self.address)
        except BadValue as error:
            raise BadValue(f"jumpers E24..E20 {self}: {error}") from None

    def __str__(self) -> str:
        return " ".join("P" if present else "NP" for present in self)


def checked_irq(irq: int) -> int:
    """Return the interrupt line if a jumper can set it; raises BadValue."""
    if isinstance(irq, bool) or irq not in IRQS:
        raise BadValue(f"IRQ {irq!r}: {', '.join(map(str, IRQS[:-1]))} or {IRQS[-1]}; usually {USUAL_IRQ}")
    return irq


def checked_place(base: int | None = None, irq: int | None = None, shared_irq: bool = False) -> IsaPlace:
    """Address and interrupt line if jumpers can set them, None: as delivered; raises BadValue."""
    return IsaPlace(
        checked_base(USUAL_BASE if base is None else base),
        checked_irq(USUAL_IRQ if irq is None else irq),
        shared_irq,
    )


class Controller(Protocol):
    """The interface of the SJA1000 that the board needs. `on_interrupt` is called when INT becomes active."""

    on_interrupt: Callable[[], None] | None

    @property
    def interrupt(self) -> bool: ...
    def read(self, address: int) -> int: ...
    def write(self, address: int, value: int) -> None: ...


class InduCan104:
    """One board: an SJA1000 that is reached through ports.

    It uses the chip's `on_interrupt`. A program that serves the interrupt sets `on_irq`, or plugs the board into an
    IsaBus and connects to that bus's interrupt line. Raises BadValue for an address or a line that jumpers cannot set.
    """

    def __init__(self, base: int, irq: int, chip: Controller, *, shared_irq: bool = False) -> None:
        self.place = checked_place(base, irq, shared_irq)
        self.chip = chip
        self.on_irq: Callable[[], None] | None = None
        chip.on_interrupt = self._request

    @property
    def jumpers(self) -> Jumpers:
        """The positions of E24..E20 for its address."""
        return Jumpers.for_base(self.place.base)

    @property
    def irq_pending(self) -> bool:
        """True while the board requests an interrupt that no handler has served."""
        return bool(self.chip.interrupt)

    @property
    def led(self) -> bool:
        """The yellow LED: on while the interrupt line is active."""
        return self.irq_pending

    def read_port(self, port: int) -> int:
        """Read a register, with the effect that reading has on the chip; 0xFF at a port that is not the board's."""
        register = register_at(port, self.place.base)
        return FLOATING if register is None else self.chip.read(register)

    def write_port(self, port: int, value: int) -> None:
        """Write a register; ignored at a port that is not the board's. Raises BadValue for a value that is no byte."""
        checked_byte(value, port)
        register = register_at(port, self.place.base)
        if register is not None:
            self.chip.write(register, value)

    def _request(self) -> None:
        if self.on_irq is not None:
            self.on_irq()


class BoardPorts:
    """read(address) and write(address, value) of a board's registers, 0..127, through the machine's ports."""

    def __init__(self, isa: IsaBus, base: int) -> None:
        self._isa = isa
        self._ports = tuple(port_of(register, base) for register in range(REGISTERS))

    def read(self, address: int) -> int:
        return self._isa.read(self._ports[address])

    def write(self, address: int, value: int) -> None:
        self._isa.write(self._ports[address], value)
