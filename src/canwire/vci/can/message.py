"""CAN messages: CANMSG, CANMSG2 and their cyclic forms.

Source: VCI V4 manual 7.3.14 to 7.3.18; cantype.h of VCI 4.1; reference/vci.md sections
3 and 5. The manual omits the reserved word of CANMSG2; with it, a message has 80 bytes.
"""

from __future__ import annotations

from typing import ClassVar, Self, Unpack

from canwire.packed.kinds import limited
from canwire.vci.can.msg_info import CanMsgInfo, InfoBits
from canwire.vci.structures.constants import CAN_EDLC_XLT, CAN_ELEN_XLT, CAN_SLEN_MAX
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError
from canwire.vci.structures.info_bits import info_member, shown_bits
from canwire.vci.structures.members import data_field, u8, u16, u32, x32
from canwire.vci.structures.structure import Structure, structure

_EDL, _FDR, _RTR, _DLC_SHIFT = 1 << 10, 1 << 11, 1 << 22, 16
_NO_DLC = 0xFFFF_FFFF ^ 0xF << _DLC_SHIFT


class Message(Structure):
    """The common part of the four kinds of message.

    `ab_data` is the whole data field, which can be written byte by byte as in C; `data` is the part that is valid
    according to `msg_info.dlc`. A constructor copies `msg_info` and also accepts its bits as keywords. `data` sets
    dlc, if that is not given, to the smallest sufficient length code, and edl for more than 8 bytes.
    Raises VciInvalidArgument for data longer than the field, or longer than 8 bytes with edl=0.
    """

    __slots__ = ("ab_data", "msg_id", "msg_info")
    ROOM: ClassVar[int] = CAN_SLEN_MAX
    msg_id: int
    msg_info: CanMsgInfo
    ab_data: bytearray

    def _fill(self, data: bytes, info: CanMsgInfo | None, bits: InfoBits) -> None:
        self.msg_info = CanMsgInfo(info.value if info else 0, **bits)
        self.ab_data = bytearray(self.ROOM)
        raw = self._fitting(data)
        if len(raw) > CAN_SLEN_MAX and bits.get("edl") == 0:
            raise VciError(VCI_E_INVALIDARG, f"{self.NAME}: more than 8 bytes need edl=1")
        if raw:
            self._put(raw)
            if "dlc" in bits:
                self.msg_info.dlc = bits["dlc"]

    def _put(self, raw: bytes) -> None:
        self.ab_data = bytearray(raw.ljust(self.ROOM, b"\0"))
        value = self.msg_info.value & _NO_DLC | CAN_ELEN_XLT[len(raw)] << _DLC_SHIFT
        self.msg_info.value = value | _EDL if len(raw) > CAN_SLEN_MAX else value

    def _fitting(self, data: bytes) -> bytes:
        try:
            return limited(data, self.ROOM)
        except (TypeError, ValueError):
            raise VciError(VCI_E_INVALIDARG, f"{self.NAME}.abData has {self.ROOM} bytes") from None

    @property
    def data(self) -> bytes:
        """The valid data bytes: their number follows from dlc, 8 at most without edl, 0 in a remote request.

        Setting them sets dlc to the smallest sufficient length code, pads with zeros, and sets edl for more than 8
        bytes.
        """
        info = self.msg_info.value
        if info & _RTR and not info & (_EDL | _FDR):
            return b""
        length = CAN_EDLC_XLT[info >> _DLC_SHIFT & 0xF]
        return bytes(self.ab_data[: length if info & _EDL else min(length, CAN_SLEN_MAX)])

    @data.setter
    def data(self, data: bytes) -> None:
        self._put(self._fitting(data))

    def __repr__(self) -> str:
        data = self.data
        shown = [
            f"{one.name}={one.show(value)}"
            for one in self._members
            if one.name not in ("msg_info", "ab_data", "reserved") and (value := getattr(self, one.name))
        ]
        if data:
            shown.append(f'data=bytes.fromhex("{data.hex()}")')
        implied = CAN_ELEN_XLT[len(data)]
        bits = CanMsgInfo(self.msg_info.value & _NO_DLC)
        if self.msg_info.dlc != implied:
            shown.append(f"dlc={self.msg_info.dlc}")
        return f"{type(self).__name__}({', '.join(shown + shown_bits(bits))})"


_DATA = (("abData", "data"),)


@structure("CANMSG", init=False, also=_DATA)
class CanMsg(Message):
    """A CAN message of up to 8 bytes.

    `time` is in ticks: the time of reception, or the delay after the previous message to send. `msg_id` has 11 or 29
    bits, right-aligned. Source: manual 7.3.15.

    >>> CanMsg(msg_id=0x123, data=b"ab", srr=1)
    CanMsg(msg_id=0x123, data=bytes.fromhex("6162"), srr=1)
    """

    time: int = u32("dwTime")
    msg_id: int = x32("dwMsgId")
    msg_info: CanMsgInfo = info_member(CanMsgInfo)
    ab_data: bytearray = data_field(8)

    def __init__(
        self,
        *,
        time: int = 0,
        msg_id: int = 0,
        msg_info: CanMsgInfo | None = None,
        data: bytes = b"",
        **bits: Unpack[InfoBits],
    ) -> None:
        self.time, self.msg_id = time, msg_id
        self._fill(data, msg_info, bits)

    @classmethod
    def from_bytes(cls, data: bytes | bytearray | memoryview) -> Self:
        return cls.made(*cls._unpack(data))

    @classmethod
    def made(cls, time: int, msg_id: int, info: int, data: bytes) -> Self:
        """The message for these words of memory, unchecked; each received message is made here."""
        made = cls.__new__(cls)
        made.time, made.msg_id = time, msg_id
        made.msg_info, made.ab_data = CanMsgInfo.made(info), bytearray(data)
        return made


@structure("CANMSG2", init=False, also=_DATA)
class CanMsg2(Message):
    """A CAN message of up to 64 bytes. Members as in CanMsg; `reserved` is 0. Source: manual 7.3.16."""

    ROOM: ClassVar[int] = 64
    time: int = u32("dwTime")
    reserved: int = u32("_rsvd_")
    msg_id: int = x32("dwMsgId")
    msg_info: CanMsgInfo = info_member(CanMsgInfo)
    ab_data: bytearray = data_field(64)

    def __init__(
        self,
        *,
        time: int = 0,
        msg_id: int = 0,
        msg_info: CanMsgInfo | None = None,
        data: bytes = b"",
        **bits: Unpack[InfoBits],
    ) -> None:
        self.time, self.reserved, self.msg_id = time, 0, msg_id
        self._fill(data, msg_info, bits)

    @classmethod
    def from_bytes(cls, data: bytes | bytearray | memoryview) -> Self:
        return cls.made(*cls._unpack(data))

    @classmethod
    def made(cls, time: int, reserved: int, msg_id: int, info: int, data: bytes) -> Self:
        """The message for these words of memory, unchecked; each received message is made here."""
        made = cls.__new__(cls)
        made.time, made.reserved, made.msg_id = time, reserved, msg_id
        made.msg_info, made.ab_data = CanMsgInfo.made(info), bytearray(data)
        return made


class _Cyclic(Message):
    __slots__ = ("byte_index", "cycle_time", "incr_mode")
    cycle_time: int
    incr_mode: int
    byte_index: int

    def __init__(
        self,
        *,
        cycle_time: int = 0,
        incr_mode: int = 0,
        byte_index: int = 0,
        msg_id: int = 0,
        msg_info: CanMsgInfo | None = None,
        data: bytes = b"",
        **bits: Unpack[InfoBits],
    ) -> None:
        self.cycle_time, self.incr_mode, self.byte_index = cycle_time, incr_mode, byte_index
        self.msg_id = msg_id
        self._fill(data, msg_info, bits)


@structure("CANCYCLICTXMSG", init=False, also=_DATA)
class CanCyclicTxMsg(_Cyclic):
    """An entry of the cyclic transmit list, of up to 8 bytes.

    `cycle_time` is in ticks of the list, up to cms_max_ticks of the capabilities. `incr_mode` (CAN_CTXMSG_INC_) is the
    part that is incremented after each transmission; `byte_index` is the byte of the data, of two the lower one.
    Source: manual 7.3.17.
    """

    cycle_time: int = u16("wCycleTime")
    incr_mode: int = u8("bIncrMode")
    byte_index: int = u8("bByteIndex")
    msg_id: int = x32("dwMsgId")
    msg_info: CanMsgInfo = info_member(CanMsgInfo)
    ab_data: bytearray = data_field(8)


@structure("CANCYCLICTXMSG2", init=False, also=_DATA)
class CanCyclicTxMsg2(_Cyclic):
    """An entry of the cyclic transmit list, of up to 64 bytes; members as in CanCyclicTxMsg.

    Source: manual 7.3.18.
    """

    ROOM: ClassVar[int] = 64
    cycle_time: int = u16("wCycleTime")
    incr_mode: int = u8("bIncrMode")
    byte_index: int = u8("bByteIndex")
    msg_id: int = x32("dwMsgId")
    msg_info: CanMsgInfo = info_member(CanMsgInfo)
    ab_data: bytearray = data_field(64)
