"""ACAN identifiers: 32-bit words with the identifier's first bit on the bus in bit 28, whatever its format.

    bit             28          18 17                 0
    extended        ID28 .... ID18 ID17 ........... ID0
    standard        ID10 ..... ID0  0 ............... 0

A few bits, wherever the application wants them, name the machine that a message is for (MID); 0 there means all.
Source: INduCAN104 manual, "Messages identification".
"""

from __future__ import annotations

from dataclasses import dataclass

from canwire import BadValue

FIRST_BIT = 28
STANDARD_SHIFT = 18  # 29 - 11
LARGEST_STANDARD = 0x7FF
LARGEST_EXTENDED = 0x1FFF_FFFF
BROADCAST = 0


def acan_word(identifier: int, extended: bool = False) -> int:
    """The ACAN identifier (dwID, dwXor) of an 11-bit or 29-bit one; raises BadValue if it has more bits.

    >>> hex(acan_word(0x048))
    '0x1200000'
    """
    largest = LARGEST_EXTENDED if extended else LARGEST_STANDARD
    if not isinstance(identifier, int) or not 0 <= identifier <= largest:
        raise BadValue(f"identifier {identifier!r:.40}: a whole number from 0 to 0x{largest:X}")
    return identifier if extended else identifier << STANDARD_SHIFT


def plain_identifier(word: int, extended: bool = False) -> int:
    """The 11-bit or 29-bit identifier of an ACAN one. Bits that mean nothing in its format are passed over."""
    identifier = word & LARGEST_EXTENDED
    return identifier if extended else identifier >> STANDARD_SHIFT


def significant(word: int, extended: bool = False) -> int:
    """The word without the bits that mean nothing: what ACAN delivers, and wants to be sent."""
    return acan_word(plain_identifier(word, extended), extended)


@dataclass(frozen=True, slots=True)
class MachineField:
    """Where identifiers name machines: `width` bits, the lowest of them in bit `position` of the ACAN word.

    Left out, it is the manual's example: bits 20..18, the last three of a standard identifier, for machines 1..7.
    Raises BadValue if the bits are not all in an identifier.

    >>> hex(MachineField().sent_to(0x01200000, 5))
    '0x1340000'
    """

    position: int = STANDARD_SHIFT
    width: int = 3

    def __post_init__(self) -> None:
        top = self.position + self.width - 1
        if self.position < 0 or self.width < 1 or top > FIRST_BIT:
            raise BadValue(
                f"a MID of {self.width} bits from bit {self.position}: within bits 0 to {FIRST_BIT}"
            )

    @property
    def mask(self) -> int:
        """hi_mim and hi_bim: the field's bits set."""
        return ((1 << self.width) - 1) << self.position

    @property
    def machines(self) -> range:
        """The numbers a machine can have; 0 is nobody's."""
        return range(1, 1 << self.width)

    def word(self, machine: int) -> int:
        """hi_miv of a machine, hi_biv of `BROADCAST`; raises BadValue for a number that does not fit."""
        if not isinstance(machine, int) or not 0 <= machine < 1 << self.width:
            raise BadValue(f"machine {machine!r:.40}: a whole number from 0 to {(1 << self.width) - 1}")
        return machine << self.position

    def sent_to(self, word: int, machine: int) -> int:
        """That identifier with this destination."""
        return word & ~self.mask | self.word(machine)

    def destination(self, word: int) -> int:
        """The machine an identifier names; `BROADCAST` for all."""
        return (word & self.mask) >> self.position

    def concerns(self, word: int, machine: int) -> bool:
        """Whether that machine is meant: by its number, or with all others."""
        return self.destination(word) in (machine, BROADCAST)
