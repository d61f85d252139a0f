"""LIN messages: LINMSGINFO and LINMSG, and the numpy dtypes of the latter.

Source: VCI V4 manual (seed 004) 7.4.5 and 7.4.6; lintype.h of VCI 4.1; reference/vci.md sections 4 and 5.
"""

from __future__ import annotations

import operator
from functools import cache
from typing import TYPE_CHECKING, Self, TypedDict, Unpack

from canwire.vci.can.dtypes import load_numpy
from canwire.vci.lin.constants import LIN_MSGTYPE_DATA, LIN_MSGTYPE_TMOVR
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError
from canwire.vci.structures.info_bits import BitField
from canwire.vci.structures.members import limited, member, show_octets, u32, x32
from canwire.vci.structures.structure import Structure, structure

if TYPE_CHECKING:
    import numpy

_ROOM = 8


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
class LinMsgInfo(Structure):
    """What kind of message it is, over one 32-bit `value`: bit fields, and the same bits as four bytes.

    `pid` protected identifier: LIN_PIDMASK_ID and LIN_PIDMASK_PARITY, 0xFF if the message is about no frame;
    `type` LIN_MSGTYPE_; `dlen` valid bytes of data, of LIN_MSGTYPE_TMOVR how often the counter ran over; `ecs`
    enhanced checksum of LIN 2; `sor` this controller sent the response; `ovr` the receive FIFO was full after
    this message; `ido` send the header alone. `flags` holds LIN_MSGFLAGS_.
    Raises VciInvalidArgument for a field that gets more than it holds. Source: manual 7.4.5.
    """

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
        self.value = value
        for name, given in bits.items():
            if name not in _BITS:
                raise TypeError(f"LINMSGINFO has no bit field {name!r}")
            setattr(self, name, given)

    def __repr__(self) -> str:
        return f"LinMsgInfo({', '.join(_shown_bits(self))})"


def _shown_bits(info: LinMsgInfo) -> list[str]:
    """The bit fields that are not 0, as keyword arguments; the identifier in hex."""
    given = [(name, getattr(info, name)) for name in _BITS]
    return [f"{name}={value:#x}" if name == "pid" else f"{name}={value}" for name, value in given if value]


@structure("LINMSG", init=False, also=(("abData", "data"),))
class LinMsg(Structure):
    """A LIN message of up to 8 bytes.

    `time` in ticks: received, when; to send, 0. `ab_data` is the whole data field, to be written byte by byte
    as in C; `data` the part that `msg_info.dlen` makes valid. A constructor copies `msg_info` and takes its bits
    as keywords too. With `data` it sets dlen, if that is not given.
    Raises VciInvalidArgument for more than 8 bytes. Source: manual 7.4.6.

    >>> LinMsg(pid=0x50, data=b"ab", ecs=1)
    LinMsg(pid=0x50, data=bytes.fromhex("6162"), ecs=1)
    """

    time: int = u32("dwTime")
    msg_info: LinMsgInfo = member(
        c_name="uMsgInfo",
        format="I",
        wants="a LinMsgInfo of 32 bits",
        default=LinMsgInfo,
        encode=operator.attrgetter("value"),
        decode=LinMsgInfo,
    )
    ab_data: bytearray = member(
        c_name="abData",
        format=f"{_ROOM}s",
        wants=f"at most {_ROOM} bytes",
        default=lambda: bytearray(_ROOM),
        encode=lambda value: limited(value, _ROOM),
        decode=bytearray,
        show=show_octets,
    )

    def __init__(
        self,
        *,
        time: int = 0,
        msg_info: LinMsgInfo | None = None,
        data: bytes = b"",
        **bits: Unpack[LinInfoBits],
    ) -> None:
        self.time = time
        self.msg_info = LinMsgInfo(msg_info.value if msg_info else 0, **bits)
        self.ab_data = bytearray(_ROOM)
        raw = _fitting(data)
        if raw:
            self._put(raw)
            if "dlen" in bits:
                self.msg_info.dlen = bits["dlen"]

    @classmethod
    def from_bytes(cls, data: bytes | bytearray | memoryview) -> Self:
        made = cls.__new__(cls)  # by hand: every received message comes this way
        made.time, info, raw = cls._unpack(data)
        made.msg_info, made.ab_data = LinMsgInfo(info), bytearray(raw)
        return made

    @property
    def data(self) -> bytes:
        """The valid data bytes: as many as dlen says, 8 at most; none of a header alone, nor of LIN_MSGTYPE_TMOVR.

        Setting them sets dlen and fills up with zeros.
        """
        info = self.msg_info
        header_alone = info.ido and info.type == LIN_MSGTYPE_DATA
        if header_alone or info.type == LIN_MSGTYPE_TMOVR:
            return b""
        return bytes(self.ab_data[: min(info.dlen, _ROOM)])

    @data.setter
    def data(self, data: bytes) -> None:
        self._put(_fitting(data))

    def _put(self, raw: bytes) -> None:
        self.ab_data = bytearray(raw.ljust(_ROOM, b"\0"))
        self.msg_info.dlen = len(raw)

    def __repr__(self) -> str:
        data, others = self.data, LinMsgInfo(self.msg_info.value)
        shown = [f"time={self.time}"] if self.time else []
        shown += _shown_bits(LinMsgInfo(pid=others.pid))
        if data:
            shown.append(f'data=bytes.fromhex("{data.hex()}")')
        others.pid = 0
        if others.dlen == len(data):
            others.dlen = 0
        return f"LinMsg({', '.join(shown + _shown_bits(others))})"


def _fitting(data: bytes) -> bytes:
    try:
        return limited(data, _ROOM)
    except (TypeError, ValueError):
        raise VciError(VCI_E_INVALIDARG, f"LINMSG.abData takes {_ROOM} bytes") from None


@cache
def linmsg_dtype() -> numpy.dtype[numpy.void]:
    """LINMSG: dwTime (ticks), uMsgInfo, abData[8]; 16 bytes."""
    return load_numpy().dtype([("dwTime", "<u4"), ("uMsgInfo", "<u4"), ("abData", "u1", _ROOM)])


@cache
def linmsg_view_dtype() -> numpy.dtype[numpy.void]:
    """LINMSG's fields where the 80-byte records of a monitor's FIFO have them."""
    return load_numpy().dtype(
        {
            "names": ["dwTime", "uMsgInfo", "abData"],
            "formats": ["<u4", "<u4", ("u1", _ROOM)],
            "offsets": [0, 12, 16],
            "itemsize": 80,
        }
    )
