"""ACAN identifiers: 32-bit words. Bit 28 is the first bit of the identifier on the bus, in both formats.

    bit             28          18 17                 0
    extended        ID28 .... ID18 ID17 ........... ID0
    standard        ID10 ..... ID0  0 ............... 0

An application chooses a few bits that hold the number of the machine a message is for (MID); 0 means all machines.
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
    """The ACAN identifier (dwID, dwXor) for an 11-bit or 29-bit identifier; raises BadValue if it has more bits.

    >>> hex(acan_word(0x048))
    '0x1200000'
    """
    largest = LARGEST_EXTENDED if extended else LARGEST_STANDARD
    if not isinstance(identifier, int) or not 0 <= identifier <= largest:
        raise BadValue(f"identifier {identifier!r:.40}: a whole number from 0 to 0x{largest:X}")
    return identifier if extended else identifier << STANDARD_SHIFT


def plain_identifier(word: int, extended: bool = False) -> int:
    """The 11-bit or 29-bit identifier in an ACAN word. Bits without a meaning in its format are ignored."""
    identifier = word & LARGEST_EXTENDED
    return identifier if extended else identifier >> STANDARD_SHIFT


def significant(word: int, extended: bool = False) -> int:
    """The ACAN word with all bits at 0 that have no meaning in its format, as ACAN delivers it."""
    return acan_word(plain_identifier(word, extended), extended)


@dataclass(frozen=True, slots=True)
class MachineField:
    """The bits of an identifier that hold a machine's number: `width` bits from bit `position` of the ACAN word up.

    The default is the manual's example: bits 20..18, the last three of a standard identifier, for machines 1..7.
    Raises BadValue if a bit is outside the identifier.

    >>> hex(MachineField().sent_to(0x01200000, 5))
    '0x1340000'
    """

    position: int = STANDARD_SHIFT
    width: int = 3

    def __post_init__(self) -> None:
        top = self.position + self.width - 1
        if self.position < 0 or self.width < 1 or top > FIRST_BIT:
            raise BadValue(
                f"a MID of {self.width} bits from bit {self.position}: it must be within bits 0 to {FIRST_BIT}"
            )

    @property
    def mask(self) -> int:
        """hi_mim and hi_bim: the field's bits set."""
        return ((1 << self.width) - 1) << self.position

    @property
    def machines(self) -> range:
        """The numbers that a machine can have; 0 is the broadcast number."""
        return range(1, 1 << self.width)

    def word(self, machine: int) -> int:
        """hi_miv of a machine, hi_biv of `BROADCAST`; raises BadValue for a number that does not fit."""
        if not isinstance(machine, int) or not 0 <= machine < 1 << self.width:
            raise BadValue(f"machine {machine!r:.40}: a whole number from 0 to {(1 << self.width) - 1}")
        return machine << self.position

    def sent_to(self, word: int, machine: int) -> int:
        """The ACAN word with this machine as its destination; raises BadValue for a number that does not fit."""
        return word & ~self.mask | self.word(machine)

    def destination(self, word: int) -> int:
        """The machine that an ACAN word addresses; `BROADCAST` for all machines."""
        return (word & self.mask) >> self.position

    def concerns(self, word: int, machine: int) -> bool:
        """Whether the word addresses that machine, alone or as a broadcast."""
        return self.destination(word) in (machine, BROADCAST)
