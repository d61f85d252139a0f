"""CANMSGINFO: the kind of a message, in 32 bits.

Source: VCI V4 manual 7.3.14; cantype.h of VCI 4.1; reference/vci.md section 3.
"""

from __future__ import annotations

from typing import ClassVar, Self, TypedDict, Unpack

from canwire.vci.structures.info_bits import BitField, InfoWord
from canwire.vci.structures.members import x32
from canwire.vci.structures.structure import structure


class InfoBits(TypedDict, total=False):
    """CANMSGINFO.Bits, as keyword arguments."""

    type: int
    ssm: int
    hpm: int
    edl: int
    fdr: int
    esi: int
    res: int
    dlc: int
    ovr: int
    srr: int
    rtr: int
    ext: int
    afc: int


_BITS = tuple(InfoBits.__annotations__)
_BYTES = (("bType", "bytes_type"), ("bReserved", "flags2"), ("bFlags2", "flags2"), ("bFlags", "flags"))


@structure(
    "CANMSGINFO",
    init=False,
    also=(
        *((f"Bits.{one}", one) for one in _BITS),
        *((f"Bytes.{c_name}", name) for c_name, name in (*_BYTES, ("bAccept", "accept"))),
    ),
)
class CanMsgInfo(InfoWord):
    """The kind of a message, in one 32-bit `value`: bit fields, and the same bits as four bytes.

    `type`: CAN_MSGTYPE_; `ssm`: single shot; `hpm`: high priority; `edl`: CAN FD; `fdr`: fast data; `esi`: the sender
    was error passive; `dlc`: data length code; `ovr`: messages were lost before this one; `srr`: self-reception;
    `rtr`: remote request; `ext`: 29-bit identifier; `afc`: CAN_ACCEPT_.
    Raises VciInvalidArgument for a number that does not fit its field. Source: manual 7.3.14.
    """

    BITS: ClassVar[tuple[str, ...]] = _BITS
    value: int = x32("dwMsgInfo")

    type = BitField(0, 8)
    ssm = BitField(8, 1)
    hpm = BitField(9, 1)
    edl = BitField(10, 1)
    fdr = BitField(11, 1)
    esi = BitField(12, 1)
    res = BitField(13, 3)
    dlc = BitField(16, 4)
    ovr = BitField(20, 1)
    srr = BitField(21, 1)
    rtr = BitField(22, 1)
    ext = BitField(23, 1)
    afc = BitField(24, 8)

    bytes_type = BitField(0, 8)
    flags2 = BitField(8, 8)
    flags = BitField(16, 8)
    accept = BitField(24, 8)

    def __init__(self, value: int = 0, **bits: Unpack[InfoBits]) -> None:
        self._put(value, bits)

    @classmethod
    def made(cls, value: int) -> Self:
        """The word with this value, unchecked."""
        made = cls.__new__(cls)
        made.value = value
        return made
