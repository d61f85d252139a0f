"""CANMSGINFO: what kind of message it is, in 32 bits.

Source: VCI V4 manual (seed 004) 7.3.14; cantype.h of VCI 4.1; reference/vci.md section 3.
"""

from __future__ import annotations

import operator
from typing import Self, TypedDict, Unpack, overload

from canwire.vci.errors import VCI_E_INVALIDARG, VciError
from canwire.vci.members import x32
from canwire.vci.structure import Structure, structure


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


class _Bits:
    """Some bits of CANMSGINFO.value. Setting them to more than they hold raises VciInvalidArgument."""

    __slots__ = ("highest", "name", "shift")

    def __init__(self, shift: int, width: int) -> None:
        self.shift = shift
        self.highest = (1 << width) - 1

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, info: None, owner: type) -> Self: ...
    @overload
    def __get__(self, info: CanMsgInfo, owner: type) -> int: ...
    def __get__(self, info: CanMsgInfo | None, owner: type) -> Self | int:
        return self if info is None else info.value >> self.shift & self.highest

    def __set__(self, info: CanMsgInfo, bits: int) -> None:
        try:
            number = operator.index(bits)
        except TypeError:
            number = -1
        if not 0 <= number <= self.highest:
            raise VciError(VCI_E_INVALIDARG, f"CANMSGINFO's {self.name} is from 0 to {self.highest}")
        info.value = info.value & ~(self.highest << self.shift) | number << self.shift


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
class CanMsgInfo(Structure):
    """What kind of message it is, over one 32-bit `value`: bit fields, and the same bits as four bytes.

    `type` CAN_MSGTYPE_; `ssm` single shot, `hpm` high priority, `edl` CAN FD, `fdr` fast data, `esi`
    sender was error passive; `dlc` data length code; `ovr` messages were lost before this one, `srr`
    self-reception, `rtr` remote request, `ext` 29-bit identifier; `afc` CAN_ACCEPT_.
    Raises VciInvalidArgument for a field that gets more than it holds. Source: manual 7.3.14.
    """

    value: int = x32("dwMsgInfo")

    type = _Bits(0, 8)
    ssm = _Bits(8, 1)
    hpm = _Bits(9, 1)
    edl = _Bits(10, 1)
    fdr = _Bits(11, 1)
    esi = _Bits(12, 1)
    res = _Bits(13, 3)
    dlc = _Bits(16, 4)
    ovr = _Bits(20, 1)
    srr = _Bits(21, 1)
    rtr = _Bits(22, 1)
    ext = _Bits(23, 1)
    afc = _Bits(24, 8)

    bytes_type = _Bits(0, 8)
    flags2 = _Bits(8, 8)
    flags = _Bits(16, 8)
    accept = _Bits(24, 8)

    def __init__(self, value: int = 0, **bits: Unpack[InfoBits]) -> None:
        self.value = value
        for name, given in bits.items():
            if name not in _BITS:
                raise TypeError(f"CANMSGINFO has no bit field {name!r}")
            setattr(self, name, given)

    def __repr__(self) -> str:
        return f"CanMsgInfo({', '.join(shown_bits(self))})"


def shown_bits(info: CanMsgInfo) -> list[str]:
    """The bit fields that are not 0, as keyword arguments."""
    return [f"{name}={value}" for name in _BITS if (value := getattr(info, name))]
