"""LIN constants, structures and messages: values copied from reference/vci.md sections 2, 4 and 5."""

from __future__ import annotations

import pickle
import re
import struct

import numpy
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import vci
from canwire.vci import (
    LinCapabilities,
    LinInitLine,
    LinLineStatus,
    LinMonitorStatus,
    LinMsg,
    LinMsgInfo,
    Structure,
    VciInvalidArgument,
    controller_types,
)
from canwire.vci.lin import constants as lin_constants
from tests.cases import each

# reference/vci.md section 4, group by group; of the LIN_STATUS_ only OVRRUN and ININIT are in the header
LIN = {
    "LIN_OPMODE_": "SLAVE 0, MASTER 1, ERRORS 2",
    "LIN_FEATURE_": "MASTER 1, AUTORATE 2, ERRFRAME 4, BUSLOAD 8, SLEEP 0x10, WAKEUP 0x20",
    "LIN_BITRATE_": "UNDEF 65535, AUTO 0, MIN 1000, MAX 20000, 1000 1000, 1200 1200, 2400 2400, 4800 4800,"
    " 9600 9600, 10400 10400, 19200 19200, 20000 20000",
    "LIN_STATUS_": "OVRRUN 0x01, TXPEND 0x02, ERRLIM 0x04, BUSOFF 0x08, ININIT 0x10",
    "LIN_MSGTYPE_": "DATA 0, INFO 1, ERROR 2, STATUS 3, WAKEUP 4, SLEEP 5, TMOVR 6",
    "LIN_MSGFLAGS_": "ECS 1, SOR 2, OVR 4, IDO 8",
    "LIN_PIDMASK_": "ID 0x3F, PARITY 0xC0",
    "LIN_INFO_": "START 1, STOP 2, RESET 3",
    "LIN_ERROR_": "BIT 1, CHKSUM 2, PARITY 3, SLNORE 4, SYNC 5, NOBUS 6, OTHER 7, WAKEUP 8",
    "LIN_CTRL_": "UNKNOWN 0, GENERIC 1, SERIAL 2, MAXVAL 255",
    "VCI_LIN_": "UNKNOWN 0x200, GENERIC 0x201, SERIAL 0x202",
}
VALUES = {
    group + name: int(value, 0)
    for group, row in LIN.items()
    for name, value in (entry.split() for entry in row.split(","))
}

# structure: C name, format, size, fields in order with their names here
LAYOUTS: dict[type[Structure], tuple[str, str, int, str]] = {
    LinCapabilities: (
        "LINCAPABILITIES",
        "<3I",
        12,
        "dwFeatures features, dwClockFreq clock_freq, dwTscDivisor tsc_divisor",
    ),
    LinInitLine: ("LININITLINE", "<BBH", 4, "bOpMode op_mode, bReserved reserved, wBitrate bitrate"),
    LinLineStatus: (
        "LINLINESTATUS",
        "<2BHI",
        8,
        "bOpMode op_mode, bBusLoad bus_load, wBitrate bitrate, dwStatus status",
    ),
    LinMonitorStatus: (
        "LINMONITORSTATUS",
        "<2BHIiiB",
        17,
        "sLineStatus line_status, fActivated activated, fRxOverrun rx_overrun, bRxFifoLoad rx_fifo_load",
    ),
    LinMsgInfo: ("LINMSGINFO", "<I", 4, "dwMsgInfo value"),
    LinMsg: ("LINMSG", "<2I8s", 16, "dwTime time, uMsgInfo msg_info, abData ab_data"),
}
KINDS = list(LAYOUTS)


def flat(kind: type[Structure]) -> bytes:
    """Bytes of a structure in which no two neighbours are equal; BOOLs are legal."""
    raw = bytearray((7 * at + 1) % 251 for at in range(kind.SIZE))
    if kind is LinMonitorStatus:
        raw[8:16] = bytes.fromhex("0100000000000000")
    return bytes(raw)


# constants


@each("name", VALUES)
def test_constants(name: str) -> None:
    assert getattr(lin_constants, name) == getattr(vci, name) == VALUES[name]


def test_the_table_above_is_complete() -> None:
    assert {name for name in vars(lin_constants) if re.match("LIN_|VCI_LIN_", name)} == set(VALUES)


def test_status_bits_are_told_apart() -> None:
    bits = [value for name, value in VALUES.items() if name.startswith("LIN_STATUS_")]
    assert len(set(bits)) == len(bits)


def test_words_of_controllers() -> None:
    assert controller_types.vci_bus_type(vci.VCI_LIN_SERIAL) == vci.VCI_BUS_LIN
    assert controller_types.vci_ctl_type(vci.VCI_LIN_SERIAL) == vci.LIN_CTRL_SERIAL


# structures


@each("kind", KINDS)
def test_layout(kind: type[Structure]) -> None:
    name, format_, size, fields = LAYOUTS[kind]
    declared = [tuple(field.split()) for field in fields.split(",")]
    assert name == kind.NAME
    assert kind.SIZE == size == struct.calcsize(format_)
    assert list(kind.FIELDS[: len(declared)]) == declared
    assert kind().to_bytes() == bytes(size)
    assert all(hasattr(kind(), python) for _, python in kind.FIELDS)


@each("kind", KINDS)
def test_bytes_round_trip(kind: type[Structure]) -> None:
    raw = flat(kind)
    for form in (raw, bytearray(raw), memoryview(raw)):
        read = kind.from_bytes(form)
        assert read.to_bytes() == raw
        assert read == read.copy() == pickle.loads(pickle.dumps(read))
        assert read != kind()
    for wrong in (b"", raw[:-1], raw + b"\0"):
        with pytest.raises(VciInvalidArgument, match=f"{kind.NAME} takes {kind.SIZE} bytes"):
            kind.from_bytes(wrong)


@each("kind", [kind for kind in KINDS if kind is not LinMsg])
def test_repr_is_an_expression(kind: type[Structure]) -> None:
    read = kind.from_bytes(flat(kind))
    assert eval(repr(read), {each.__name__: each for each in KINDS}) == read
    assert repr(kind()) == f"{kind.__name__}()"


def test_known_bytes_of_structures() -> None:
    assert LinCapabilities(0x3F, 8_000_000, 8).to_bytes().hex(" ", 4) == "3f000000 00127a00 08000000"
    assert LinInitLine(op_mode=3, bitrate=vci.LIN_BITRATE_19200).to_bytes().hex() == "0300004b"
    line = LinLineStatus(op_mode=1, bus_load=25, bitrate=9600, status=vci.LIN_STATUS_ININIT)
    assert line.to_bytes().hex() == "0119802510000000"
    monitor = LinMonitorStatus(line, activated=True, rx_fifo_load=50)
    assert monitor.to_bytes().hex() == "0119802510000000" + "01000000" + "00000000" + "32"


def test_the_manuals_other_names_are_known() -> None:
    """reference/vci.md section 10; the manual's table of 7.4.5 has Bytes.pid where it means Bits.pid."""
    assert ("bReserved", "bus_load") in LinLineStatus.FIELDS
    assert ("Bytes.pid", "pid") in LinMsgInfo.FIELDS
    assert ("Bits.ido", "ido") in LinMsgInfo.FIELDS
    assert ("Bytes.bFlags", "flags") in LinMsgInfo.FIELDS
    assert ("abData", "data") in LinMsg.FIELDS


@each(
    ("bad", "message"),
    [
        (LinInitLine(bitrate=65536), r"LININITLINE\.wBitrate \(bitrate\) is 65536"),
        (LinInitLine(op_mode=256), r"LININITLINE\.bOpMode"),
        (LinCapabilities(features=1 << 32), r"LINCAPABILITIES\.dwFeatures"),
        (LinMonitorStatus(None), r"LINMONITORSTATUS\.sLineStatus .* not a LinLineStatus"),  # type: ignore[arg-type]
        (LinMsg(time=-1), r"LINMSG\.dwTime"),
        (LinMsg(msg_info=LinMsgInfo(1 << 32)), r"LINMSG\.uMsgInfo"),
    ],
)
def test_what_does_not_fit_is_named(bad: Structure, message: str) -> None:
    with pytest.raises(VciInvalidArgument, match=message):
        bad.to_bytes()


# message info: lowest bit, width

BITS = {
    "pid": (0, 8), "type": (8, 8), "dlen": (16, 8), "ecs": (24, 1), "sor": (25, 1), "ovr": (26, 1), "ido": (27, 1),
    "res": (28, 4),
    "bytes_pid": (0, 8), "bytes_type": (8, 8), "bytes_dlen": (16, 8), "flags": (24, 8),
}  # fmt: skip


@each("name", BITS)
def test_bits_of_message_info(name: str) -> None:
    low, width = BITS[name]
    highest = 2**width - 1
    info = LinMsgInfo(0xFFFF_FFFF)
    assert getattr(info, name) == highest
    setattr(info, name, 0)
    assert info.value == 0xFFFF_FFFF - (highest << low)
    info = LinMsgInfo()
    setattr(info, name, highest)
    assert info.value == highest << low
    for wrong in (highest + 1, -1, None):
        with pytest.raises(VciInvalidArgument, match=name):
            setattr(info, name, wrong)


@each("name", ["ecs", "sor", "ovr", "ido"])
def test_flags_are_the_bits_of_their_byte(name: str) -> None:
    info = LinMsgInfo()
    setattr(info, name, 1)
    assert info.flags == getattr(vci, f"LIN_MSGFLAGS_{name.upper()}")


def test_message_info_by_keywords() -> None:
    assert LinMsgInfo(pid=0x50, type=2, dlen=8, ecs=1, ido=1).value == 0x09080250
    assert LinMsgInfo(0xFF, pid=1).value == 1
    assert LinMsgInfo(ovr=True, dlen=numpy.uint8(8)) == LinMsgInfo(0x04080000)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="no bit field 'flags'"):
        LinMsgInfo(flags=1)  # type: ignore[call-arg]


# identifier and protected identifier: reference/lin-protocol.md section 3
@each(("identifier", "pid"), [(0x00, 0x80), (0x10, 0x50), (0x22, 0xE2), (0x3C, 0x3C)])
def test_parts_of_the_protected_identifier(identifier: int, pid: int) -> None:
    assert LinMsgInfo(pid=pid).pid & vci.LIN_PIDMASK_ID == identifier
    assert LinMsgInfo(pid=pid).pid & vci.LIN_PIDMASK_PARITY == pid - identifier


# messages


def test_known_bytes_of_a_message() -> None:
    message = LinMsg(time=0x01020304, pid=0x50, data=b"\x4a\x55\x93\xe5", ecs=1, sor=1)
    assert message.to_bytes().hex(" ", 4) == "04030201 50000403 4a5593e5 00000000"


def test_length_follows_the_data() -> None:
    for length in range(9):
        message = LinMsg(data=bytes(range(1, length + 1)))
        assert message.data == bytes(range(1, length + 1))
        assert message.msg_info.dlen == length
        assert len(message.ab_data) == 8
    for wrong in (bytes(9), 5):
        with pytest.raises(VciInvalidArgument, match=r"LINMSG\.abData has 8 bytes"):
            LinMsg(data=wrong)  # type: ignore[arg-type]
        with pytest.raises(VciInvalidArgument):
            message.data = wrong  # type: ignore[assignment]


@each(
    ("info", "length"),
    [
        (LinMsgInfo(dlen=3), 3),
        (LinMsgInfo(dlen=9), 8),
        (LinMsgInfo(dlen=4, ido=1), 0),
        (LinMsgInfo(dlen=2, type=vci.LIN_MSGTYPE_ERROR), 2),
        (LinMsgInfo(dlen=2, type=vci.LIN_MSGTYPE_ERROR, ido=1), 2),
        (LinMsgInfo(dlen=3, type=vci.LIN_MSGTYPE_TMOVR), 0),
    ],
)
def test_valid_data(info: LinMsgInfo, length: int) -> None:
    """VCI V4 manual 7.4.5: ido means something for data alone; TMOVR counts in dlen."""
    assert len(LinMsg(msg_info=info).data) == length


def test_given_lengths_are_kept() -> None:
    assert LinMsg(dlen=4, ido=1).msg_info.dlen == 4
    assert LinMsg(dlen=2, data=b"abcd").data == b"ab"
    assert LinMsg(dlen=2, data=b"abcd").ab_data == b"abcd\0\0\0\0"


def test_data_field_as_in_c() -> None:
    message = LinMsg(pid=0x50, dlen=2)
    message.ab_data[0] = 0xAA
    message.ab_data[1] = 0xBB
    assert message.data == b"\xaa\xbb"
    message.data = b"xyz"
    assert (message.msg_info.dlen, bytes(message.ab_data)) == (3, b"xyz" + bytes(5))
    message.ab_data = bytearray(9)
    with pytest.raises(VciInvalidArgument, match=r"LINMSG\.abData"):
        message.to_bytes()


def test_given_message_info_is_copied() -> None:
    info = LinMsgInfo(ecs=1)
    message = LinMsg(msg_info=info, data=b"ab", pid=0x50)
    assert message.msg_info == LinMsgInfo(ecs=1, pid=0x50, dlen=2)
    assert info == LinMsgInfo(ecs=1)


@given(st.binary(min_size=16, max_size=16))
def test_messages_round_trip(raw: bytes) -> None:
    read = LinMsg.from_bytes(raw)
    assert read.to_bytes() == raw
    assert read == read.copy() == LinMsg.from_bytes(bytearray(raw))


@given(
    st.integers(0, 2**32 - 1),
    st.binary(max_size=8),
    st.fixed_dictionaries(
        {},
        optional={name: st.integers(0, 1) for name in ("ecs", "sor", "ovr", "res")}
        | {name: st.integers(0, 5) for name in ("pid", "type")},
    ),
)
def test_message_repr_is_an_expression(time: int, data: bytes, bits: dict[str, int]) -> None:
    message = LinMsg(time=time, data=data, **bits)  # type: ignore[arg-type]
    assert eval(repr(message), {"LinMsg": LinMsg}) == message


def test_message_reprs() -> None:
    assert repr(LinMsg(time=5, pid=0x50, data=b"\x11", ecs=1)) == (
        'LinMsg(time=5, pid=0x50, data=bytes.fromhex("11"), ecs=1)'
    )
    assert repr(LinMsg(pid=0x50, dlen=4, ido=1)) == "LinMsg(pid=0x50, dlen=4, ido=1)"
    assert repr(LinMsg()) == "LinMsg()"


def test_misspelt_members_are_refused() -> None:
    with pytest.raises(AttributeError):
        LinMsg().dta = b""  # type: ignore[attr-defined]
    with pytest.raises(TypeError, match="no bit field 'dlc'"):
        LinMsg(dlc=1)  # type: ignore[call-arg]


def test_arrays_read_as_the_structure() -> None:
    dtype = vci.linmsg_dtype()
    message = LinMsg(time=1, pid=0x50, data=b"\x11\x22", ecs=1)
    assert dtype.itemsize == LinMsg.SIZE
    assert list(dtype.names or ()) == ["dwTime", "uMsgInfo", "abData"]
    record = numpy.frombuffer(message.to_bytes(), dtype)[0]
    assert (record["dwTime"], record["uMsgInfo"]) == (1, message.msg_info.value)
    assert bytes(record["abData"]) == bytes(message.ab_data)
