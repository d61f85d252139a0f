"""The alignment of identifiers and acceptance filters in 32-bit words, and the frames that a filter accepts.

    Align   identifier       code and mask, 11 bits         identifier       code and mask, 29 bits
            of 11 bits                                      of 29 bits
    0       bits 10..0       31..21 and data in 15..0       28..0            31..3
    1       10..0            10..0, no data                 10..0            10..0, the other bits zero
    2       28..18           28..18 and data in 15..0       28..0            28..0
    3       31..21           31..21 and data in 15..0       31..3            31..3

Bits 15..0 of the mask say which bits of the first two data bytes of a standard frame are compared (7.9). A filter
ignores data if neither code nor mask selects a data bit, that is, if the code's data bits are all 0 and the mask's are
all equal. So the first example of 8.11 accepts any data in each of its three forms, and the registry's default accepts
any data. In the third form, 0xFF1FFFF8, bits 2..0 differ from the others; a filter of 29 bits has no meaning for them,
so that mask counts as equal, too. As in the controllers, bytes that a frame does not have are not compared.

The registry's defaults, code 0 and mask 0 with MaskActive 0, accept only identifier 0, according to table 5. A program
that wants to receive more must set a filter, as CanRead does; `everything()` returns the filter for all frames.
Source: CANDRV manual, 6.3 (MaskActive, Align), 7.9, 8.11; rulings.md 19, 33 and 33a.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import BadFilter, BadFrame
from canwire.candrv.structures import CAN_ACCEPTANCE_FILTER

if TYPE_CHECKING:
    from canwire.candrv.registry.settings import Settings

STANDARD_BITS, EXTENDED_BITS = 0x7FF, 0x1FFF_FFFF
ALL_BITS = 0xFFFF_FFFF
DATA_BITS = 0xFFFF
_UNIFORM = (0xFFFF, 0xFFF8)  # compared data bits of masks that do not select single data bits
ALIGNMENTS = (0, 1, 2, 3)

# table 6 by Align: the shift of identifiers to the left, for 11 and for 29 bits; then the shift of codes and masks
ID_SHIFT = ((0, 0), (0, 0), (18, 0), (21, 3))
FILTER_SHIFT = ((21, 3), (0, 0), (18, 0), (21, 3))


def identifier_width(extended: bool, align: int) -> int:
    """The mask of the bits that a right-aligned identifier may have."""
    return EXTENDED_BITS if extended and align != 1 else STANDARD_BITS


def aligned(identifier: int, extended: bool, align: int) -> int:
    """The aligned word for a frame's identifier, as programs see it."""
    return (identifier & identifier_width(extended, align)) << ID_SHIFT[align][extended]


def identifier_of(word: int, extended: bool, align: int) -> int:
    """The identifier in an aligned word; raises BadFrame if the word has bits outside the identifier."""
    shift, width = ID_SHIFT[align][extended], identifier_width(extended, align)
    if not 0 <= word <= ALL_BITS or word & ~(width << shift):
        kind = "an extended" if extended else "a standard"
        top = (width << shift).bit_length() - 1
        raise BadFrame(f"{word:#x}: {kind} identifier has bits {top}..{shift} with Align={align}")
    return word >> shift


class Filter:
    """The acceptance filter of a receive channel: code and mask, interpreted by Align and MaskActive. Immutable.

    Raises BadFilter for an invalid value.
    """

    __slots__ = (
        "_data",
        "_data_care",
        "_extended",
        "_extended_care",
        "_standard",
        "_standard_care",
        "align",
        "code",
        "mask",
        "mask_active",
    )

    def __init__(self, code: int = 0, mask: int = 0, align: int = 0, mask_active: int = 0) -> None:
        for name, value in (("code", code), ("mask", mask)):
            if not isinstance(value, int) or not 0 <= value <= ALL_BITS:
                raise BadFilter(f"{name} {value!r:.40}: a whole number of 32 bits")
        if align not in ALIGNMENTS:
            raise BadFilter(f"Align {align!r:.40}: 0, 1, 2 or 3")
        if mask_active not in (0, 1):
            raise BadFilter(f"MaskActive {mask_active!r:.40}: 0 or 1")
        self.code, self.mask = code, mask
        self.align, self.mask_active = align, mask_active
        care = mask if mask_active else ~mask & ALL_BITS
        shift, shift_extended = FILTER_SHIFT[align]
        self._standard_care = care >> shift & STANDARD_BITS
        self._standard = code >> shift & self._standard_care
        self._extended_care = care >> shift_extended & EXTENDED_BITS
        if align == 1:
            self._extended_care = care & STANDARD_BITS | EXTENDED_BITS & ~STANDARD_BITS
            code &= STANDARD_BITS
        self._extended = code >> shift_extended & self._extended_care
        names_data = code & DATA_BITS or care & DATA_BITS not in _UNIFORM
        self._data_care = care & DATA_BITS if align != 1 and names_data else 0
        self._data = code & self._data_care

    @classmethod
    def of(cls, structure: CAN_ACCEPTANCE_FILTER, align: int = 0, mask_active: int = 0) -> Filter:
        """The filter in a structure."""
        return cls(structure.code, structure.mask, align, mask_active)

    @classmethod
    def registered(cls, settings: Settings) -> Filter:
        """The filter of a new receive channel, from the device's registry entries."""
        code, mask = settings.acceptance_code, settings.acceptance_mask
        return cls(code, mask, settings.align, settings.mask_active)

    @classmethod
    def everything(cls, align: int = 0, mask_active: int = 0) -> Filter:
        """A filter that accepts all frames; with Align 1 it accepts extended frames only up to 0x7FF."""
        return cls(0, 0 if mask_active else ALL_BITS, align, mask_active)

    def accepts(self, identifier: int, extended: bool = False, data: bytes = b"") -> bool:
        """Whether a frame passes. `identifier` is right-aligned, as on the bus."""
        if extended:
            return identifier & self._extended_care == self._extended
        if identifier & self._standard_care != self._standard:
            return False
        return not self._data_care or self._data_passes(data)

    def _data_passes(self, data: bytes) -> bool:
        there = min(len(data), 2)
        first = int.from_bytes(data[:there], "big")
        absent = 8 * (2 - there)
        return (first << absent ^ self._data) & self._data_care >> absent << absent == 0

    def to_structure(self) -> CAN_ACCEPTANCE_FILTER:
        """Code and mask as a structure."""
        return CAN_ACCEPTANCE_FILTER(self.code, self.mask)

    def bits(self, extended: bool) -> str:
        """The identifier bits from the first one on: 0 and 1 must match, + matches both. CanCheck shows this text."""
        code, care = (
            (self._extended, self._extended_care) if extended else (self._standard, self._standard_care)
        )
        places = range(28 if extended else 10, -1, -1)
        return "".join(str(code >> place & 1) if care >> place & 1 else "+" for place in places)

    @property
    def data_bits(self) -> str:
        """The bits of a standard frame's first two data bytes, as in `bits`; "" with Align 1: it compares no data."""
        if self.align == 1:
            return ""
        care, code = self._data_care, self._data
        return "".join(str(code >> at & 1) if care >> at & 1 else "+" for at in range(15, -1, -1))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Filter) and self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def __repr__(self) -> str:
        return f"Filter(0x{self.code:08X}, 0x{self.mask:08X}, {self.align}, {self.mask_active})"

    def _key(self) -> tuple[int, ...]:
        return self.code, self.mask, self.align, self.mask_active, self._data_care
