"""Structures: sizes, formats and field order copied from reference/vci.md section 5."""

from __future__ import annotations

import pickle
import re
import struct
from typing import Any
from uuid import UUID

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.vci.can import dtypes as can_dtypes
from canwire.vci.can import message as can_message
from canwire.vci.can import msg_info as can_msg_info
from canwire.vci.can import structures as can_structures
from canwire.vci.can.message import CanCyclicTxMsg, CanCyclicTxMsg2, CanMsg, CanMsg2, Message
from canwire.vci.can.msg_info import CanMsgInfo
from canwire.vci.can.presets import CAN_BTP_500KB
from canwire.vci.can.structures import (
    CanBtp,
    CanBtpPair,
    CanBtpTable,
    CanBtrTable,
    CanChanStatus,
    CanChanStatus2,
    CanInitLine2,
    CanLineStatus2,
    CanSchedulerStatus2,
)
from canwire.vci.structures import devices as structures
from canwire.vci.structures.devices import VciDeviceCaps, VciDeviceInfo, VciId
from canwire.vci.structures.errors import VciInvalidArgument
from canwire.vci.structures.structure import Structure
from tests.cases import each

BTP = "2I4H"
# C name: format, size, fields in order
LAYOUTS = {
    "VCIID": ("<q", 8, "AsInt64"),
    "VCIVERSIONINFO": ("<8I", 32, "VciMajorVersion VciMinorVersion VciRevNumber VciBuildNumber OsMajorVersion"
                       " OsMinorVersion OsBuildNumber OsPlatformId"),
    "VCIDEVICEINFO": ("<q16s2BH4B16s128s126sH", 304, "VciObjectId DeviceClass DriverMajorVersion"
                      " DriverMinorVersion DriverBuildVersion HardwareBranchVersion HardwareMajorVersion"
                      " HardwareMinorVersion HardwareBuildVersion UniqueHardwareId Description Manufacturer"
                      " DriverReleaseVersion"),
    "VCIDEVICECAPS": ("<H32H", 66, "BusCtrlCount BusCtrlTypes"),
    "BALFEATURES": ("<HHH32H", 70, "FwMajorVersion FwMinorVersion BusSocketCount BusSocketType"),
    "BALSOCKETINFO": ("<qHH", 12, "ObjectId BusType SocketNo"),
    "CANBTP": ("<2I4H", 16, "dwMode dwBPS wTS1 wTS2 wSJW wTDO"),
    "CANBTRTABLE": ("<BB64s64s", 130, "bCount bIndex abBtr0 abBtr1"),
    "CANBTPTABLE.asBTP": ("<" + 2 * BTP, 32, "sSdr sFdr"),
    "CANBTPTABLE": ("<BB" + 128 * BTP, 2050, "bCount bIndex asBTP"),
    "CANCAPABILITIES": ("<2H7I", 32, "wCtrlType wBusCoupling dwFeatures dwClockFreq dwTscDivisor dwCmsDivisor"
                        " dwCmsMaxTicks dwDtxDivisor dwDtxMaxTicks"),
    "CANCAPABILITIES2": ("<2H2I" + 4 * BTP + "8I", 108, "wCtrlType wBusCoupling dwFeatures dwCanClkFreq"
                         " sSdrRangeMin sSdrRangeMax sFdrRangeMin sFdrRangeMax dwTscClkFreq dwTscDivisor"
                         " dwCmsClkFreq dwCmsDivisor dwCmsMaxTicks dwDtxClkFreq dwDtxDivisor dwDtxMaxTicks"),
    "CANINITLINE": ("<4B", 4, "bOpMode bReserved bBtReg0 bBtReg1"),
    "CANINITLINE2": ("<4B2I" + 2 * BTP, 44, "bOpMode bExMode bSFMode bEFMode dwSFIds dwEFIds sBtpSdr sBtpFdr"),
    "CANLINESTATUS": ("<4BI", 8, "bOpMode bBtReg0 bBtReg1 bBusLoad dwStatus"),
    "CANLINESTATUS2": ("<4B" + 2 * BTP + "I", 40, "bOpMode bExMode bBusLoad bReserved sBtpSdr sBtpFdr dwStatus"),
    "CANCHANSTATUS": ("<4BIiiBB", 18, "sLineStatus fActivated fRxOverrun bRxFifoLoad bTxFifoLoad"),
    "CANCHANSTATUS2": ("<4B" + 2 * BTP + "I4B", 44, "sLineStatus fActivated fRxOverrun bRxFifoLoad bTxFifoLoad"),
    "CANSCHEDULERSTATUS": ("<B16s", 17, "bTaskStat abMsgStat"),
    "CANSCHEDULERSTATUS2": ("<4B" + 2 * BTP + "IB16s", 57, "sLineStatus bTaskStat abMsgStat"),
    "CANRTINFO": ("<3I2H", 16, "dwNumChannels dwActChannels dwLockStatus wRxFifoLoad wTxFifoLoad"),
    "CANMSGINFO": ("<I", 4, "dwMsgInfo"),
    "CANMSG": ("<3I8s", 20, "dwTime dwMsgId uMsgInfo abData"),
    "CANMSG2": ("<4I64s", 80, "dwTime _rsvd_ dwMsgId uMsgInfo abData"),
    "CANCYCLICTXMSG": ("<H2B2I8s", 20, "wCycleTime bIncrMode bByteIndex dwMsgId uMsgInfo abData"),
    "CANCYCLICTXMSG2": ("<H2B2I64s", 76, "wCycleTime bIncrMode bByteIndex dwMsgId uMsgInfo abData"),
}  # fmt: skip
# reference/vci.md section 9: what its rules do not give
IRREGULAR = {"_rsvd_": "reserved", "abData": "ab_data", "dwMsgInfo": "value"}
KINDS: dict[str, type[Structure]] = {
    kind.NAME: kind
    for module in (structures, can_structures, can_msg_info, can_message)
    for kind in vars(module).values()
    if isinstance(kind, type) and issubclass(kind, Structure) and hasattr(kind, "NAME")
}
MESSAGES: list[type[Message]] = [CanMsg, CanMsg2, CanCyclicTxMsg, CanCyclicTxMsg2]
NAMESPACE = {kind.__name__: kind for kind in KINDS.values()} | {"UUID": UUID}


def flat(name: str) -> bytes:
    """Bytes of a structure in which no two neighbours are equal; BOOLs and texts are legal."""
    raw = bytearray((7 * at + 1) % 251 for at in range(LAYOUTS[name][1]))
    if name == "CANCHANSTATUS":
        raw[8:16] = bytes.fromhex("0100000000000000")
    elif name == "CANCHANSTATUS2":
        raw[40:42] = b"\1\0"
    elif name == "VCIDEVICEINFO":
        raw[48:176] = b"USB-to-CAN FD".ljust(128, b"\0")
        raw[176:302] = b"canwire \xa9".ljust(126, b"\0")
    return bytes(raw)


def test_no_structure_is_missing() -> None:
    assert set(KINDS) == set(LAYOUTS)


@each("name", LAYOUTS)
def test_layout(name: str) -> None:
    format_, size, fields = LAYOUTS[name]
    kind = KINDS[name]
    assert kind.SIZE == size == struct.calcsize(format_)
    assert [c_name for c_name, _ in kind.FIELDS][: len(fields.split())] == fields.split()
    assert kind().to_bytes() == bytes(size)
    assert all(hasattr(kind(), python) for _, python in kind.FIELDS)


def python_name(c_name: str) -> str:
    """Rules 3 and 4 of reference/vci.md section 9: without its prefix, in lower case with underscores."""
    bare = re.sub(r"^(dw|ab|as|[wbsfu])(?=[A-Z])", "", c_name)
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", bare).lower()


@each("name", LAYOUTS)
def test_python_names(name: str) -> None:
    declared = KINDS[name].FIELDS[: len(LAYOUTS[name][2].split())]
    assert [python for _, python in declared] == [
        IRREGULAR.get(c_name, python_name(c_name)) for c_name, _ in declared
    ]


def test_the_manuals_other_names_are_known() -> None:
    """reference/vci.md sections 5 and 10."""
    known = {f"{kind.NAME}.{c_name}": python for kind in KINDS.values() for c_name, python in kind.FIELDS}
    assert known["VCIVERSIONINFO.VciReleaseNumber"] == "vci_rev_number"
    assert known["BALSOCKETINFO.BusNo"] == "socket_no"
    assert known["CANCAPABILITIES.dwMaxCmsTicks"] == "cms_max_ticks"
    assert known["CANCAPABILITIES2.dwDtxClockFreq"] == "dtx_clk_freq"
    assert known["VCIID.AsLuid.LowPart"] == "low_part"
    assert known["CANMSGINFO.Bits.dlc"] == "dlc"
    assert known["CANMSGINFO.Bytes.bFlags2"] == "flags2"
    assert ("abData", "data") in CanMsg.FIELDS


@each("name", LAYOUTS)
def test_bytes_round_trip(name: str) -> None:
    raw = flat(name)
    for form in (raw, bytearray(raw), memoryview(raw)):
        read = KINDS[name].from_bytes(form)
        assert read.to_bytes() == raw
        assert read == KINDS[name].from_bytes(raw)
        assert read != KINDS[name]()


@each("name", LAYOUTS)
def test_copies_share_nothing(name: str) -> None:
    read = KINDS[name].from_bytes(flat(name))
    for again in (read.copy(), pickle.loads(pickle.dumps(read))):
        assert again == read
        assert again is not read
    line = CanInitLine2(btp_sdr=CanBtp(bps=1))
    line.copy().btp_sdr.bps = 2
    assert line.btp_sdr.bps == 1


@each("name", [name for name in LAYOUTS if KINDS[name] not in MESSAGES])
def test_repr_is_an_expression(name: str) -> None:
    read = KINDS[name].from_bytes(flat(name))
    assert eval(repr(read), NAMESPACE) == read
    assert repr(KINDS[name]()) == f"{KINDS[name].__name__}()"


@each("name", LAYOUTS)
def test_wrong_sizes_are_refused(name: str) -> None:
    kind = KINDS[name]
    for wrong in (b"", bytes(kind.SIZE - 1), bytes(kind.SIZE + 1), None):
        with pytest.raises(VciInvalidArgument, match=f"{name} takes {kind.SIZE} bytes"):
            kind.from_bytes(wrong)  # type: ignore[arg-type]


def test_known_bytes_of_init_line() -> None:
    line = CanInitLine2(
        op_mode=0x21, ex_mode=3, sf_mode=2, ef_mode=4, sf_ids=2048, ef_ids=0x01020304,
        btp_sdr=CAN_BTP_500KB, btp_fdr=CanBtp(1, 2, 3, 4, 5, 6),
    )  # fmt: skip
    assert line.to_bytes().hex(" ", 4) == (
        "21030204 00080000 04030201 00000000 20a10700 0e000200 01000000 01000000 02000000 03000400 05000600"
    )


def test_known_bytes_of_device_info() -> None:
    info = VciDeviceInfo(
        vci_object_id=VciId(0x10001),
        device_class=UUID("B9AAAF39-B9B9-4850-9402-7D8250C7B88F"),
        hardware_branch_version=1,
        hardware_major_version=2,
        unique_hardware_id=b"HW123456",
        description="USB-to-CAN FD",
        manufacturer="Gerät",
        driver_release_version=0x1234,
    )
    raw = info.to_bytes()
    assert raw[:24].hex() == "010001000000000039afaab9b9b95048" + "94027d8250c7b88f"
    assert raw[28:30] == b"\1\2"
    assert raw[32:48] == b"HW123456".ljust(16, b"\0")
    assert raw[48:62] == b"USB-to-CAN FD\0"
    assert raw[176:182] == b"Ger\xe4t\0"
    assert raw[302:] == b"\x34\x12"
    assert VciDeviceInfo.from_bytes(raw) == info


def test_text_ends_at_the_first_nul() -> None:
    raw = bytearray(VciDeviceInfo().to_bytes())
    raw[48:52] = b"ab\0c"
    assert VciDeviceInfo.from_bytes(raw).description == "ab"
    assert VciDeviceInfo.from_bytes(VciDeviceInfo(description="x" * 127).to_bytes()).description == "x" * 127


def test_hardware_id_is_a_serial_number_or_a_guid() -> None:
    """VCI V4 manual 7.1.3: text if the first two bytes are HW."""
    info = VciDeviceInfo(unique_hardware_id=b"HW123456")
    assert info.hardware_id == "HW123456"
    info.hardware_id = UUID(int=0x1234)
    assert info.unique_hardware_id == UUID(int=0x1234).bytes_le
    assert info.hardware_id == UUID(int=0x1234)
    info.hardware_id = "HW" + "9" * 14
    assert info.hardware_id == "HW" + "9" * 14
    for wrong in ("123456", "HW" + "9" * 15):
        with pytest.raises(VciInvalidArgument):
            info.hardware_id = wrong


@given(st.integers(0, 2**32 - 1), st.integers(-(2**31), 2**31 - 1))
def test_vciid_is_a_union(low: int, high: int) -> None:
    number = VciId()
    number.low_part = low
    number.high_part = high
    assert (number.low_part, number.high_part) == (low, high)
    assert number.as_int64 == high * 2**32 + low
    assert number.to_bytes() == struct.pack("<Ii", low, high)


def test_vciid_parts_have_limits() -> None:
    for part, wrong in (("low_part", -1), ("low_part", 2**32), ("high_part", 2**31), ("high_part", None)):
        with pytest.raises(VciInvalidArgument):
            setattr(VciId(), part, wrong)


def test_nested_structures_are_real() -> None:
    status = CanChanStatus2(line_status=CanLineStatus2(op_mode=1, btp_sdr=CanBtp(bps=500_000)))
    status.line_status.btp_sdr.ts1 = 14
    read = CanChanStatus2.from_bytes(status.to_bytes())
    assert (read.line_status.btp_sdr.bps, read.line_status.btp_sdr.ts1) == (500_000, 14)
    assert CanSchedulerStatus2().line_status is not CanSchedulerStatus2().line_status


def test_flags_are_booleans_of_one_or_four_bytes() -> None:
    assert CanChanStatus(activated=True).to_bytes()[8:16].hex() == "0100000000000000"
    assert CanChanStatus2(rx_overrun=True).to_bytes()[40:].hex() == "00010000"
    assert CanChanStatus.from_bytes(bytes(8) + b"\0\1" + bytes(8)).activated is True
    assert CanChanStatus().activated is False


def test_tables_are_filled_up() -> None:
    table = CanBtrTable(count=2, index=0xFF, btr0=b"\x31\x18", btr1=b"\x1c\x1c")
    assert table.btr0 == b"\x31\x18" + bytes(62)
    assert CanBtrTable.from_bytes(table.to_bytes()) == table
    assert table.to_bytes()[:5] == b"\2\xff\x31\x18\0"
    pairs = CanBtpTable(count=1, btp=[CanBtpPair(CAN_BTP_500KB, CanBtp(bps=2_000_000))])
    assert len(pairs.btp) == 64
    assert pairs.to_bytes()[18:26] == struct.pack("<II", 0, 2_000_000)
    caps = VciDeviceCaps(2, [0x0140, 0x0201])
    caps.bus_ctrl_types[1] = 0x0141
    assert caps.to_bytes()[:8] == bytes.fromhex("0200400141010000")
    assert repr(caps) == "VciDeviceCaps(bus_ctrl_count=2, bus_ctrl_types=[0x140, 0x141])"


BAD: list[tuple[Structure, str]] = [
    (
        CanInitLine2(op_mode=256),
        r"CANINITLINE2\.bOpMode \(op_mode\) is 256: not a whole number from 0 to 255",
    ),
    (CanInitLine2(sf_ids=-1), r"CANINITLINE2\.dwSFIds"),
    (CanInitLine2(btp_sdr=CanBtp(sjw=0x10000)), r"CANBTP\.wSJW \(sjw\)"),
    (CanInitLine2(btp_sdr=None), r"CANINITLINE2\.sBtpSdr .* not a CanBtp"),  # type: ignore[arg-type]
    (CanBtp(bps=1.5), r"CANBTP\.dwBPS"),  # type: ignore[arg-type]
    (CanBtp(mode="raw"), r"CANBTP\.dwMode"),  # type: ignore[arg-type]
    (CanBtrTable(btr0=bytes(65)), r"CANBTRTABLE\.abBtr0 .* at most 64 bytes"),
    (CanBtrTable(btr1=5), r"CANBTRTABLE\.abBtr1"),  # type: ignore[arg-type]
    (CanBtpTable(btp=[CanBtpPair()] * 65), r"CANBTPTABLE\.asBTP"),
    (CanBtpTable(btp=[CanBtp()]), r"CANBTPTABLE\.asBTP"),  # type: ignore[list-item]
    (VciDeviceCaps(bus_ctrl_types=[0x10000]), r"VCIDEVICECAPS\.BusCtrlTypes"),
    (VciDeviceCaps(bus_ctrl_types=[0] * 33), r"VCIDEVICECAPS\.BusCtrlTypes"),
    (VciDeviceInfo(description="x" * 128), r"VCIDEVICEINFO\.Description .* at most 127 characters"),
    (VciDeviceInfo(manufacturer="€"), r"VCIDEVICEINFO\.Manufacturer"),
    (VciDeviceInfo(manufacturer="a\0b"), r"VCIDEVICEINFO\.Manufacturer"),
    (VciDeviceInfo(device_class="no"), r"VCIDEVICEINFO\.DeviceClass"),  # type: ignore[arg-type]
    (VciId(2**63), r"VCIID\.AsInt64"),
    (CanChanStatus(activated="yes"), r"CANCHANSTATUS\.fActivated"),  # type: ignore[arg-type]
    (CanMsg(msg_id=10**5000), r"CANMSG\.dwMsgId"),
    (CanMsg(msg_id=2**32), r"CANMSG\.dwMsgId"),
    (CanMsg2(msg_info=CanMsgInfo(2**32)), r"CANMSG2\.uMsgInfo"),
]


@each(("bad", "message"), BAD)
def test_what_does_not_fit_is_named(bad: Structure, message: str) -> None:
    with pytest.raises(VciInvalidArgument, match=message):
        bad.to_bytes()


def test_misspelt_members_are_refused() -> None:
    with pytest.raises(AttributeError):
        CanBtp().bsp = 1  # type: ignore[attr-defined]
    with pytest.raises(AttributeError):
        CanMsg2().dta = b""  # type: ignore[attr-defined]


def test_equality_is_by_kind_and_value() -> None:
    assert CanBtp(bps=1) == CanBtp(bps=1) != CanBtp(bps=2)
    assert CanMsg() != CanCyclicTxMsg()
    assert CanBtp() != 0
    with pytest.raises(TypeError):
        hash(CanBtp())


# reference/vci.md section 3: lowest bit, width
BITS = {
    "type": (0, 8), "ssm": (8, 1), "hpm": (9, 1), "edl": (10, 1), "fdr": (11, 1), "esi": (12, 1), "res": (13, 3),
    "dlc": (16, 4), "ovr": (20, 1), "srr": (21, 1), "rtr": (22, 1), "ext": (23, 1), "afc": (24, 8),
    "bytes_type": (0, 8), "flags2": (8, 8), "flags": (16, 8), "accept": (24, 8),
}  # fmt: skip


@each("name", BITS)
def test_bits_of_message_info(name: str) -> None:
    low, width = BITS[name]
    highest = 2**width - 1
    info = CanMsgInfo(0xFFFF_FFFF)
    assert getattr(info, name) == highest
    setattr(info, name, 0)
    assert info.value == 0xFFFF_FFFF - (highest << low)
    info = CanMsgInfo()
    setattr(info, name, highest)
    assert info.value == highest << low
    for wrong in (highest + 1, -1, None):
        with pytest.raises(VciInvalidArgument, match=name):
            setattr(info, name, wrong)


@given(st.integers(0, 2**32 - 1))
def test_message_info_repr_is_an_expression(value: int) -> None:
    assert eval(repr(CanMsgInfo(value)), NAMESPACE) == CanMsgInfo(value)


def test_message_info_by_keywords() -> None:
    assert CanMsgInfo(type=2, dlc=15, ext=1, afc=255).value == 0xFF8F0002
    assert CanMsgInfo(0xFF, type=1).value == 1
    assert CanMsgInfo(ext=True, dlc=numpy.uint8(8)) == CanMsgInfo(0x880000)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="no bit field 'flags'"):
        CanMsgInfo(flags=1)  # type: ignore[call-arg]


def test_known_bytes_of_messages() -> None:
    """CANMSG2's reserved word puts dwMsgId at 8, uMsgInfo at 12, abData at 16."""
    named: dict[str, Any] = {"msg_id": 0x123, "data": b"\x11\x22", "ext": 1, "srr": 1}
    tail = bytes.fromhex("230100000000a2001122")
    assert CanMsg(time=0x01020304, **named).to_bytes() == b"\4\3\2\1" + tail + bytes(6)
    assert CanMsg2(time=0x01020304, **named).to_bytes() == b"\4\3\2\1" + bytes(4) + tail + bytes(62)
    head = bytes.fromhex("00100301")
    cyclic: dict[str, Any] = {"cycle_time": 0x1000, "incr_mode": 3, "byte_index": 1, **named}
    assert CanCyclicTxMsg(**cyclic).to_bytes() == head + tail + bytes(6)
    assert CanCyclicTxMsg2(**cyclic).to_bytes() == head + tail + bytes(62)


@each("kind", MESSAGES)
def test_length_follows_the_data(kind: type[Message]) -> None:
    build: Any = kind
    for length in range(kind.ROOM + 1):
        message = build(data=bytes(range(1, length + 1)))
        assert len(message.data) >= length
        assert message.data[:length] == bytes(range(1, length + 1))
        assert not any(message.data[length:])
        assert len(message.ab_data) == kind.ROOM
        assert message.msg_info.edl == (length > 8)
    with pytest.raises(VciInvalidArgument, match=f"{kind.NAME}.abData has {kind.ROOM} bytes"):
        build(data=bytes(kind.ROOM + 1))
    with pytest.raises(VciInvalidArgument):
        build(data=5)


@each(
    ("bits", "length"),
    [
        ({"dlc": 8}, 8),
        ({"dlc": 15}, 8),
        ({"dlc": 15, "edl": 1}, 64),
        ({"dlc": 9, "edl": 1}, 12),
        ({"dlc": 3, "fdr": 1}, 3),
        ({"dlc": 4, "rtr": 1}, 0),
        ({"dlc": 4, "rtr": 1, "edl": 1}, 4),
        ({"dlc": 4, "rtr": 1, "fdr": 1}, 4),
    ],
)
def test_valid_data(bits: dict[str, int], length: int) -> None:
    """VCI V4 manual 7.3.14: more than 8 bytes need edl; edl or fdr make rtr void."""
    info = CanMsgInfo()
    for name, value in bits.items():
        setattr(info, name, value)
    assert len(CanMsg2(msg_info=info).data) == length
    assert len(CanMsg(msg_info=info).data) == min(length, 8)


def test_given_lengths_are_kept() -> None:
    assert CanMsg(dlc=4, rtr=1).msg_info.dlc == 4
    assert CanMsg(dlc=2, data=b"abcd").data == b"ab"
    assert CanMsg(dlc=2, data=b"abcd").ab_data == b"abcd\0\0\0\0"
    assert CanMsg2(dlc=15, data=bytes(9)).msg_info == CanMsgInfo(dlc=15, edl=1)
    with pytest.raises(VciInvalidArgument, match="edl=1"):
        CanMsg2(data=bytes(9), edl=0)


def test_data_field_as_in_c() -> None:
    message = CanMsg(msg_id=1, dlc=2)
    message.ab_data[0] = 0xAA
    message.ab_data[1] = 0xBB
    assert message.data == b"\xaa\xbb"
    message.data = b"xyz"
    assert (message.msg_info.dlc, bytes(message.ab_data)) == (3, b"xyz" + bytes(5))
    message.ab_data = bytearray(b"w")
    assert message.to_bytes()[12:] == b"w" + bytes(7)
    message.ab_data = bytearray(9)
    with pytest.raises(VciInvalidArgument, match=r"CANMSG\.abData"):
        message.to_bytes()


def test_given_message_info_is_copied() -> None:
    info = CanMsgInfo(ext=1)
    message = CanMsg(msg_info=info, data=b"ab", srr=1)
    assert message.msg_info == CanMsgInfo(ext=1, srr=1, dlc=2)
    assert info == CanMsgInfo(ext=1)


@given(st.sampled_from(MESSAGES), st.data())
def test_messages_round_trip(kind: type[Message], data: st.DataObject) -> None:
    raw = data.draw(st.binary(min_size=kind.SIZE, max_size=kind.SIZE))
    read = kind.from_bytes(raw)
    assert read.to_bytes() == raw
    assert read == read.copy() == kind.from_bytes(bytearray(raw))


@given(
    st.sampled_from(MESSAGES),
    st.integers(0, 2**29 - 1),
    st.binary(max_size=8),
    st.fixed_dictionaries(
        {}, optional={name: st.integers(0, 1) for name in ("ext", "srr", "edl", "fdr", "ovr")}
    ),
)
def test_message_repr_is_an_expression(
    kind: type[Message], msg_id: int, data: bytes, bits: dict[str, int]
) -> None:
    build: Any = kind
    message = build(msg_id=msg_id, data=data, **bits)
    assert eval(repr(message), NAMESPACE) == message


def test_message_reprs() -> None:
    assert repr(CanMsg(time=5, msg_id=0x123, data=b"\x11", ext=1)) == (
        'CanMsg(time=5, msg_id=0x123, data=bytes.fromhex("11"), ext=1)'
    )
    assert repr(CanMsg(msg_id=1, rtr=1, dlc=4)) == "CanMsg(msg_id=0x1, dlc=4, rtr=1)"
    assert repr(CanCyclicTxMsg2(cycle_time=10)) == "CanCyclicTxMsg2(cycle_time=10)"


@pytest.mark.parametrize(
    ("dtype", "kind"), [(can_dtypes.canmsg_dtype(), CanMsg), (can_dtypes.canmsg2_dtype(), CanMsg2)]
)
def test_arrays_read_as_the_structures(
    dtype: numpy.dtype[numpy.void], kind: type[CanMsg] | type[CanMsg2]
) -> None:
    message = kind(time=1, msg_id=0x123, data=b"\x11\x22", ext=1)
    assert dtype.itemsize == kind.SIZE
    record = numpy.frombuffer(message.to_bytes(), dtype)[0]
    assert (record["dwTime"], record["dwMsgId"], record["uMsgInfo"]) == (1, 0x123, message.msg_info.value)
    assert bytes(record["abData"]) == bytes(message.ab_data)
    assert list(dtype.names or ()) == [name for name, _ in kind.FIELDS][: len(dtype.names or ())]


def test_short_messages_are_seen_in_long_records() -> None:
    dtype = can_dtypes.canmsg_view_dtype()
    assert dtype.itemsize == CanMsg2.SIZE
    message = CanMsg2(time=7, msg_id=5, data=bytes(range(64)))
    record = numpy.frombuffer(message.to_bytes(), dtype)[0]
    assert (record["dwTime"], record["dwMsgId"], record["uMsgInfo"]) == (7, 5, message.msg_info.value)
    assert bytes(record["abData"]) == bytes(range(8))
