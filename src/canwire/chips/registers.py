"""A chip's registers as data: address, access, reset values, bits; and the interface to access them.

A map (chips/sja1000/register_map.py) is a tuple of `Register`; the chip model in the same folder gives writes their
effects. Code that only reads and writes registers (a driver, a port on a real machine) needs `RegisterAccess`
alone.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntFlag
from typing import Protocol

from canwire.errors import BadValue


class Access(IntFlag):
    """The accesses that a register permits in one operating mode of its chip; NONE: it does not exist there."""

    NONE = 0
    READ = 1
    WRITE = 2
    READ_WRITE = 3


class RegisterAccess(Protocol):
    """Access to a chip's registers; addresses are the chip's own, values 0..255."""

    def read(self, address: int) -> int: ...
    def write(self, address: int, value: int) -> None: ...


@dataclass(frozen=True, slots=True)
class Bit:
    """A bit, or a field of `width` bits whose lowest is `position`; `meanings` names a field's values."""

    name: str
    position: int
    width: int = 1
    meanings: tuple[tuple[int, str], ...] = ()

    @property
    def mask(self) -> int:
        return ((1 << self.width) - 1) << self.position

    def describe(self, value: int) -> str:
        """This field of a register's value as text; a single bit that is 0 and has no meaning is ""."""
        here = value >> self.position & (1 << self.width) - 1
        for number, meaning in self.meanings:
            if number == here:
                return f"{self.name}={meaning}"
        if self.width == 1:
            return self.name if here else ""
        return f"{self.name}={here}"


@dataclass(frozen=True, slots=True)
class Register:
    """One register at one address.

    `operating` and `reset` are what the chip's two modes allow there. `after_hardware` and `after_software` are what
    a reset leaves: eight characters, most significant bit first, each 0, 1 or x (unchanged). `title` says in
    a few words what it is; `bits` are in data-sheet order, most significant first.
    """

    name: str
    address: int
    operating: Access
    reset: Access
    title: str = ""
    bits: tuple[Bit, ...] = ()
    after_hardware: str = "xxxxxxxx"
    after_software: str = "xxxxxxxx"

    def access(self, resetting: bool) -> Access:
        return self.reset if resetting else self.operating

    def describe(self, value: int) -> str:
        """A value as text, by its bits; "" if the text would add nothing to the number."""
        return " ".join(text for text in (bit.describe(value) for bit in self.bits) if text)


def after_reset(pattern: str, before: int) -> int:
    """A register's value after a reset whose pattern is that of `Register.after_hardware`."""
    value = 0
    for place, character in zip(range(7, -1, -1), pattern, strict=True):
        bit = before >> place & 1 if character == "x" else int(character)
        value |= bit << place
    return value


class RegisterFile:
    """One map of a chip: its registers by address, name and mode."""

    def __init__(self, registers: Iterable[Register]) -> None:
        self.registers = tuple(registers)
        self._names = {register.name: register for register in self.registers}

    def named(self, name: str) -> Register:
        """The register of that name; raises BadValue."""
        found = self._names.get(name)
        if found is None:
            raise BadValue(f"register {name!r}: there is {', '.join(self._names)}")
        return found

    def at(self, address: int, resetting: bool, access: Access = Access.READ) -> Register | None:
        """The register that is read (or written) at an address in one mode; None if there is none."""
        for register in self.registers:
            if register.address == address and register.access(resetting) & access:
                return register
        return None

    def readable(self, resetting: bool) -> tuple[Register, ...]:
        """All registers that can be read in one mode, in data-sheet order."""
        return tuple(register for register in self.registers if register.access(resetting) & Access.READ)
