"""Vendors' acceptance registers -> Acceptance: the positions of bits, and the meaning of a 1 in a mask.

VCI        code = id << 1 | remote                              mask 1 compares
SJA1000    ACR0..3 / AMR0..3, left-aligned, remote, data        mask 1 does not care
MCP2515    SIDH SIDL EID8 EID0, left-aligned, data              mask 1 compares
CANDRV     Align 0..3, data                                     MaskActive says
"""

from __future__ import annotations

from collections.abc import Iterable

from canwire.errors import BadFilter
from canwire.values.acceptance import (
    KEY_NO_BYTE_0,
    KEY_NO_BYTE_1,
    Acceptance,
    checked,
    id_pair,
)

_VCI_NEVER = 0x8000_0000
# CANDRV, Table 6: shift of identifier bits in code and mask by Align, for 11 and for 29 bits
_CANDRV_SHIFT = {0: (21, 3), 1: (0, 0), 2: (18, 0), 3: (21, 3)}


def vci(select_extended: bool, code: int, mask: int) -> Acceptance:
    """VCI's SetAccFilter for the 11-bit or the 29-bit filter: code = id << 1 | remote, mask 1 compares.

    Bits above the identifier are ignored, save that code bit 31, compared, shuts the filter:
    CAN_ACC_CODE_NONE with CAN_ACC_MASK_NONE. Raises BadFilter beyond 32 bits.
    Source: VCI V4 manual 5.2.4; reference/vci.md section 3, CAN_ACC_.
    """
    code, mask = checked("code", code, 32), checked("mask", mask, 32)
    if code & mask & _VCI_NEVER:
        return Acceptance.nothing()
    width = (1 << (29 if select_extended else 11)) - 1
    remote = (code & 1, mask & 1)
    return Acceptance(
        (id_pair(code >> 1 & width, mask >> 1 & width, extended=select_extended, remote=remote),)
    )


def sja1000_basic(acr: int, amr: int) -> Acceptance:
    """BasicCAN: ACR against ID.10-3, AMR bit 1 does not care; 29-bit frames are never stored.

    Source: SJA1000 data sheet 6.3.9; reference/sja1000.md section 9.
    """
    compared = ~checked("AMR", amr, 8) & 0xFF
    return Acceptance((id_pair(checked("ACR", acr, 8) << 3, compared << 3, extended=False),))


def sja1000_single(acr: bytes, amr: bytes) -> Acceptance:
    """PeliCAN, single filter: ACR0..ACR3 and AMR0..AMR3, four bytes each; AMR bit 1 does not care.

    11-bit frames are compared in identifier, remote bit and two data bytes, 29-bit ones in
    identifier and remote bit. A data byte that does not exist counts as matching.
    Source: SJA1000 data sheet 6.4.15.1; reference/sja1000.md section 9.
    """
    code, care = _registers(acr, amr)
    remote = (code >> 20 & 1, care >> 20 & 1)
    standard = id_pair(code >> 21, care >> 21, extended=False, remote=remote)
    remote = (code >> 2 & 1, care >> 2 & 1)
    extended = id_pair(code >> 3, care >> 3, extended=True, remote=remote)
    return Acceptance((*_with_data(standard, code & 0xFFFF, care & 0xFFFF), extended))


def sja1000_dual(acr: bytes, amr: bytes) -> Acceptance:
    """PeliCAN, dual filter: the two halves of ACR0..ACR3 and AMR0..AMR3; either accepts.

    For 11-bit frames each half holds the identifier and the remote bit, the first also the first
    data byte (its low nibble in ACR3); for 29-bit frames each half holds ID.28-13. A data byte
    that does not exist counts as matching.
    Source: SJA1000 data sheet 6.4.15.2; reference/sja1000.md section 9.
    """
    code, care = _registers(acr, amr)
    halves = [(code >> 16, care >> 16), (code & 0xFFFF, care & 0xFFFF)]
    first, second = (
        id_pair(half >> 5, cared >> 5, extended=False, remote=(half >> 4 & 1, cared >> 4 & 1))
        for half, cared in halves
    )
    # data byte 1: high nibble in ACR1.3-0, low nibble in ACR3.3-0
    byte_code = (code >> 16 & 0xF) << 4 | code & 0xF
    byte_care = (care >> 16 & 0xF) << 4 | care & 0xF
    extended = (id_pair(half << 13, cared << 13, extended=True) for half, cared in halves)
    return Acceptance((*_with_data(first, byte_code << 8, byte_care << 8), second, *extended))


def mcp2515(mask: int, filters: Iterable[int]) -> Acceptance:
    """One receive buffer of an MCP2515: RXMn and its RXFn, each SIDH << 24 | SIDL << 16 | EID8 << 8 | EID0.

    A mask bit of 1 compares. EXIDE (bit 19 of a filter) chooses the frame format; with 11-bit
    frames EID15..0 are compared with the first two data bytes (0 where they do not exist).
    Source: MCP2515 data sheet, message acceptance filters; reference/can-protocol.md section 10.
    """
    mask = checked("mask", mask, 32)
    pairs = []
    for value in filters:
        value = checked("filter", value, 32)
        if value >> 19 & 1:
            pairs.append(id_pair(_mcp2515_id(value), _mcp2515_id(mask), extended=True))
        else:
            code, care = id_pair(value >> 21, mask >> 21, extended=False)
            pairs.append((code | value & 0xFFFF, care | mask & 0xFFFF))
    return Acceptance(tuple(pairs))


def candrv(code: int, mask: int, align: int, mask_active: int, mode_2b: bool) -> Acceptance:
    """CANDRV's CAN_ACCEPTANCE_FILTER; mode_2b says that 29-bit frames are received, else 11-bit ones.

    mask_active 0: mask bit 1 accepts anything; 1: mask bit 1 must match. Align puts the values as
    in Table 6. 11-bit filters also compare the first two data bytes with bits 15..0 (Align 0, 2,
    3) if code or mask use these bits and the frame has the bytes (rulings.md 33a). Align 1 with
    29-bit frames supports identifiers up to 0x7FF only (rulings.md 19).
    Source: CANDRV manual 6 (MaskActive, Align), 7.9, 8.11.
    """
    code, mask = checked("code", code, 32), checked("mask", mask, 32)
    if align not in _CANDRV_SHIFT:
        raise BadFilter(f"align {align!r}: 0, 1, 2 or 3")
    if mask_active not in (0, 1):
        raise BadFilter(f"mask_active {mask_active!r}: 0 or 1")
    care = mask if mask_active else ~mask
    shift = _CANDRV_SHIFT[align][mode_2b]
    if mode_2b and align == 1:
        return Acceptance((id_pair(code & 0x7FF, care & 0x7FF | 0x1FFF_F800, extended=True),))
    width = 0x1FFF_FFFF if mode_2b else 0x7FF
    pair = id_pair(code >> shift & width, care >> shift & width, extended=mode_2b)
    names_data = code & 0xFFFF or care & 0xFFFF not in (0xFFFF, 0xFFF8)
    with_data = not mode_2b and align != 1 and names_data
    return Acceptance(tuple(_with_data(pair, code & 0xFFFF, care & 0xFFFF if with_data else 0)))


def _registers(acr: bytes, amr: bytes) -> tuple[int, int]:
    """ACR0..3 as one number, and the bits that are compared."""
    for name, registers in (("ACR", acr), ("AMR", amr)):
        if not isinstance(registers, (bytes, bytearray)) or len(registers) != 4:
            raise BadFilter(f"{name} {registers!r}: four bytes, {name}0 to {name}3")
    return int.from_bytes(acr, "big"), ~int.from_bytes(amr, "big") & 0xFFFF_FFFF


def _with_data(pair: tuple[int, int], data: int, care: int) -> list[tuple[int, int]]:
    """The pair with two data bytes compared, byte 0 in bits 15..8; bytes that do not exist match."""
    code, mask = pair
    if not care:
        return [pair]
    first, first_care = data & 0xFF00, care & 0xFF00
    pairs = [(code | KEY_NO_BYTE_0, mask | KEY_NO_BYTE_0)]
    if care & 0xFF:
        mask |= KEY_NO_BYTE_0 | KEY_NO_BYTE_1
        pairs += [(code | data, mask | care), (code | first | KEY_NO_BYTE_1, mask | first_care)]
    else:
        pairs.append((code | first, mask | first_care | KEY_NO_BYTE_0))
    return pairs


def _mcp2515_id(value: int) -> int:
    """SID10..0, EID17..16, EID15..0 of four registers -> 29 bits."""
    return (value >> 21 & 0x7FF) << 18 | (value >> 16 & 3) << 16 | value & 0xFFFF
