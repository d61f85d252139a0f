"""LINMSGINFO: the kind of a message, in 32 bits.

Source: VCI V4 manual 7.4.5; lintype.h of VCI 4.1; reference/vci.md section 4.
"""

from __future__ import annotations

from typing import ClassVar, TypedDict, Unpack

from canwire.vci.structures.info_bits import BitField, InfoWord
from canwire.vci.structures.members import x32
from canwire.vci.structures.structure import structure


class LinInfoBits(TypedDict, total=False):
    """LINMSGINFO.Bits, as keyword arguments."""

    pid: int
    type: int
    dlen: int
    ecs: int
    sor: int
    ovr: int
    ido: int
    res: int


_BITS = tuple(LinInfoBits.__annotations__)
_BYTES = (("bPid", "bytes_pid"), ("bType", "bytes_type"), ("bDlen", "bytes_dlen"), ("bFlags", "flags"))
_MISPRINT = ("Bytes.pid", "pid")


@structure(
    "LINMSGINFO",
    init=False,
    also=(
        *((f"Bits.{one}", one) for one in _BITS),
        *((f"Bytes.{c_name}", name) for c_name, name in _BYTES),
        _MISPRINT,
    ),
)
class LinMsgInfo(InfoWord):
    """The kind of a message, in one 32-bit `value`: bit fields, and the same bits as four bytes.

    `pid`: the protected identifier (LIN_PIDMASK_ID, LIN_PIDMASK_PARITY), 0xFF if the message is not about a frame;
    `type`: LIN_MSGTYPE_; `dlen`: the number of valid data bytes, for LIN_MSGTYPE_TMOVR of overflows of the counter;
    `ecs`: enhanced checksum of LIN 2; `sor`: this controller sent the response; `ovr`: the receive FIFO was full after
    this message; `ido`: send only the header. `flags` has the LIN_MSGFLAGS_.
    Raises VciInvalidArgument for a number that does not fit its field. Source: manual 7.4.5.
    """

    BITS: ClassVar[tuple[str, ...]] = _BITS
    IN_HEX: ClassVar[tuple[str, ...]] = ("pid",)
    value: int = x32("dwMsgInfo")

    pid = BitField(0, 8)
    type = BitField(8, 8)
    dlen = BitField(16, 8)
    ecs = BitField(24, 1)
    sor = BitField(25, 1)
    ovr = BitField(26, 1)
    ido = BitField(27, 1)
    res = BitField(28, 4)

    bytes_pid = BitField(0, 8)
    bytes_type = BitField(8, 8)
    bytes_dlen = BitField(16, 8)
    flags = BitField(24, 8)

    def __init__(self, value: int = 0, **bits: Unpack[LinInfoBits]) -> None:
        self._put(value, bits)
