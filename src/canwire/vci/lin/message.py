"""LIN messages: LINMSG.

Source: VCI V4 manual 7.4.6; lintype.h of VCI 4.1; reference/vci.md section 5.
"""

from __future__ import annotations

from typing import Self, Unpack

from canwire.packed.kinds import limited
from canwire.vci.lin.constants import LIN_MSGTYPE_DATA, LIN_MSGTYPE_TMOVR
from canwire.vci.lin.msg_info import LinInfoBits, LinMsgInfo
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError
from canwire.vci.structures.info_bits import info_member, shown_bits
from canwire.vci.structures.members import data_field, u32
from canwire.vci.structures.structure import Structure, structure

_ROOM = 8


@structure("LINMSG", init=False, also=(("abData", "data"),))
class LinMsg(Structure):
    """A LIN message of up to 8 bytes.

    `time` is the time of reception in ticks, 0 in a message to send. `ab_data` is the whole data field, which can be
    written byte by byte as in C; `data` is the part that is valid according to `msg_info.dlen`. A constructor copies
    `msg_info` and also accepts its bits as keywords. `data` sets dlen, if that is not given.
    Raises VciInvalidArgument for more than 8 bytes. Source: manual 7.4.6.

    >>> LinMsg(pid=0x50, data=b"ab", ecs=1)
    LinMsg(pid=0x50, data=bytes.fromhex("6162"), ecs=1)
    """

    time: int = u32("dwTime")
    msg_info: LinMsgInfo = info_member(LinMsgInfo)
    ab_data: bytearray = data_field(_ROOM)

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
        made = cls.__new__(cls)  # without __init__, for speed: each received message is made here
        made.time, info, raw = cls._unpack(data)
        made.msg_info, made.ab_data = LinMsgInfo(info), bytearray(raw)
        return made

    @property
    def data(self) -> bytes:
        """The valid data bytes: `dlen` bytes, 8 at most; none for a header alone or LIN_MSGTYPE_TMOVR.

        Setting them sets dlen and pads with zeros.
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
        shown += shown_bits(LinMsgInfo(pid=others.pid))
        if data:
            shown.append(f'data=bytes.fromhex("{data.hex()}")')
        others.pid = 0
        if others.dlen == len(data):
            others.dlen = 0
        return f"LinMsg({', '.join(shown + shown_bits(others))})"


def _fitting(data: bytes) -> bytes:
    try:
        return limited(data, _ROOM)
    except (TypeError, ValueError):
        raise VciError(VCI_E_INVALIDARG, f"LINMSG.abData has {_ROOM} bytes") from None
