"""The ErrorKind that an SJA1000's error code capture means.

Source: SJA1000 data sheet, tables 20 and 21; reference/sja1000.md section 6.
"""

from __future__ import annotations

from canwire.chips.sja1000 import register_map as m
from canwire.values.event import ErrorKind

_KINDS = {m.ECC_BIT: ErrorKind.BIT, m.ECC_FORM: ErrorKind.FORM, m.ECC_STUFF: ErrorKind.STUFF}
_CRC_DELIMITER, _ACK_SLOT, _EOF, _ACK_DELIMITER = 0x18, 0x19, 0x1A, 0x1B


def error_kind(code: int) -> ErrorKind:
    """The kind of error; the chip has no separate codes for a missing acknowledgement and a wrong CRC."""
    kind = _KINDS.get(code & m.ECC_TYPE_MASK)
    segment = code & m.ECC_SEGMENT_MASK
    if kind is None:
        return ErrorKind.ACK if segment == _ACK_SLOT else ErrorKind.CRC
    if kind is ErrorKind.BIT and not code & m.ECC_RX and segment in (_CRC_DELIMITER, _ACK_DELIMITER, _EOF):
        return ErrorKind.FORM  # a sender's: there only recessive bits are allowed
    return kind
