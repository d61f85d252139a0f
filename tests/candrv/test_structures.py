"""Structures lie in memory as a 32-bit compiler puts them. Source: CANDRV manual, appendix A and 8.5; rulings.md 16."""

from __future__ import annotations

import ctypes
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue, candrv
from canwire.candrv.structures import Structure

U32, I32, U8 = ctypes.c_uint32, ctypes.c_int32, ctypes.c_uint8


class Time(ctypes.LittleEndianStructure):
    _fields_ = [("low", U32), ("high", U32)]


class Filter(ctypes.LittleEndianStructure):
    _fields_ = [("code", U32), ("mask", U32)]


class Data(ctypes.LittleEndianStructure):
    _fields_ = [("fmt", U32), ("identifier", U32), ("rtr", U8), ("dlc", U8), ("msg", U8 * 8)]


class Event(ctypes.LittleEndianStructure):
    _fields_ = [
        *(("event", U32), ("time", Time), ("lost", U32), ("data", Data), ("arbitration", U32)),
    ]


class Properties(ctypes.LittleEndianStructure):
    _fields_ = [
        *(("version", U32), ("device_name", ctypes.c_uint16 * 100), ("min", U32), ("max", U32)),
        *(("nCommands", I32), ("commands", I32 * 10), ("nBaudrates", I32), ("baudrates", U32 * 50)),
        *(("chipset_flags", U32), ("nRegisters", I32)),
    ]


class Timeouts(ctypes.LittleEndianStructure):
    _fields_ = [
        ("ReadIntervalTimeout", U32),
        *((f"ReadTotalTimeout{one}", U32) for one in ("Multiplier", "Constant")),
        *((f"WriteTotalTimeout{one}", U32) for one in ("Multiplier", "Constant")),
    ]


# the same declarations once more, laid out by C's own rules
COMPILED: dict[type[Structure], type[ctypes.LittleEndianStructure]] = {
    candrv.CAN_TIME: Time,
    candrv.CAN_ACCEPTANCE_FILTER: Filter,
    candrv.CAN_TRANSMIT_DATA: Data,
    candrv.CAN_EVENT: Event,
    candrv.CAN_PROPERTIES: Properties,
    candrv.COMMTIMEOUTS: Timeouts,
}
SIZES = {
    candrv.CAN_TIME: 8,
    candrv.CAN_ACCEPTANCE_FILTER: 8,
    candrv.CAN_TRANSMIT_DATA: 20,
    candrv.CAN_EVENT: 40,
    candrv.CAN_PROPERTIES: 468,
    candrv.COMMTIMEOUTS: 20,
}
dwords = st.integers(0, 0xFFFF_FFFF)
ints = st.integers(-(1 << 31), (1 << 31) - 1)
octets = st.integers(0, 255)


def whole_dwords(memory: bytes) -> list[int]:
    return list(struct.unpack_from(f"<{len(memory) // 4}I", memory))


# letters of each length in UTF-16 and its limits; all of Unicode takes a third of a second to build
names = st.text("aZ09 \x01\x7f\x80\xe4\u20ac\ud7ff\ue000\uffff\U00010000\U0010ffff", max_size=49)
times = st.builds(candrv.CAN_TIME, dwords, dwords)
messages = st.builds(candrv.CAN_TRANSMIT_DATA, dwords, dwords, octets, octets, st.binary(max_size=8))
ANYTHING: dict[type[Structure], st.SearchStrategy[Any]] = {
    candrv.CAN_TIME: times,
    candrv.CAN_ACCEPTANCE_FILTER: st.builds(candrv.CAN_ACCEPTANCE_FILTER, dwords, dwords),
    candrv.CAN_TRANSMIT_DATA: messages,
    candrv.CAN_EVENT: st.builds(candrv.CAN_EVENT, dwords, times, dwords, messages, dwords),
    candrv.CAN_PROPERTIES: st.builds(
        candrv.CAN_PROPERTIES,
        *(dwords, names, dwords, dwords, ints, st.lists(ints, max_size=10), ints),
        *(st.binary(max_size=200).map(whole_dwords), dwords, ints),
    ),
    candrv.COMMTIMEOUTS: st.builds(candrv.COMMTIMEOUTS, *[dwords] * 5),
}
each = pytest.mark.parametrize("cls", COMPILED, ids=lambda cls: cls.__name__)


@each
@pytest.mark.conforms("FS-13", "FS-48")
def test_layout_is_a_compilers(cls: type[Structure]) -> None:
    compiled = COMPILED[cls]
    assert cls.SIZE == SIZES[cls] == ctypes.sizeof(compiled)
    assert {name: getattr(compiled, name).offset for name, *_ in compiled._fields_} == cls.OFFSETS


@each
@given(data=st.data())
def test_what_is_packed_comes_back(cls: type[Structure], data: st.DataObject) -> None:
    one = data.draw(ANYTHING[cls])
    memory = one.pack()
    assert len(memory) == cls.SIZE
    assert cls.unpack(memory) == one
    assert cls.unpack(bytearray(memory)).pack() == memory


@each
@given(data=st.data())
def test_any_memory_is_a_structure(cls: type[Structure], data: st.DataObject) -> None:
    memory = data.draw(st.binary(min_size=cls.SIZE, max_size=cls.SIZE))
    one = cls.unpack(memory)
    assert cls.unpack(one.pack()) == one


@given(data=st.data())
def test_a_compiler_reads_the_same_fields(data: st.DataObject) -> None:
    event = data.draw(ANYTHING[candrv.CAN_EVENT])
    read = Event.from_buffer_copy(event.pack())
    assert (read.event, read.time.low, read.time.high, read.lost) == (
        *(event.event, event.time.low, event.time.high, event.lost),
    )
    assert (read.data.identifier, read.data.rtr, read.data.dlc) == (
        *(event.data.identifier, event.data.rtr, event.data.dlc),
    )
    assert bytes(read.data.msg) == event.data.msg
    properties = data.draw(ANYTHING[candrv.CAN_PROPERTIES])
    told = Properties.from_buffer_copy(properties.pack())
    assert tuple(told.commands) == properties.commands
    assert tuple(told.baudrates) == properties.baudrates
    assert bytes(told.device_name).decode("utf-16-le").rstrip("\0") == properties.device_name.rstrip("\0")


@pytest.mark.conforms("FS-47")
def test_example_of_8_19() -> None:
    """cData with ID 0x123 and the bytes 0x11, 0x22."""
    data = candrv.CAN_TRANSMIT_DATA(fmt=candrv.CANBUS_TRANS_FMT_STD, identifier=0x123, dlc=2, msg=b"\x11\x22")
    assert data.pack() == bytes.fromhex("01000000 23010000 00 02 1122000000000000 0000")


def test_text_is_utf_16() -> None:
    memory = candrv.CAN_PROPERTIES(device_name="Gerät").pack()
    assert memory[4:16] == b"G\0e\0r\0\xe4\0t\0\0\0"


@each
@pytest.mark.parametrize("more", [-1, 1])
def test_other_sizes_are_refused(cls: type[Structure], more: int) -> None:
    with pytest.raises(BadValue, match=f"{cls.__name__} takes {cls.SIZE} bytes"):
        cls.unpack(bytes(cls.SIZE + more))


@pytest.mark.parametrize(
    ("cls", "name", "value"),
    [
        (candrv.CAN_TIME, "low", 1 << 32),
        (candrv.CAN_TIME, "high", -1),
        (candrv.CAN_TIME, "low", 1.5),
        (candrv.CAN_TRANSMIT_DATA, "dlc", 256),
        (candrv.CAN_TRANSMIT_DATA, "msg", bytes(9)),
        (candrv.CAN_TRANSMIT_DATA, "msg", "text"),
        (candrv.CAN_EVENT, "time", 5),
        (candrv.CAN_PROPERTIES, "nCommands", 1 << 31),
        (candrv.CAN_PROPERTIES, "commands", [0] * 11),
        (candrv.CAN_PROPERTIES, "baudrates", [-1]),
        (candrv.CAN_PROPERTIES, "baudrates", 7.0),
        (candrv.CAN_PROPERTIES, "device_name", "x" * 100),
        (candrv.CAN_PROPERTIES, "device_name", "\ud800"),
        (candrv.CAN_PROPERTIES, "device_name", "a\0b"),
    ],
)
def test_what_does_not_fit_is_refused(cls: type[Structure], name: str, value: Any) -> None:
    with pytest.raises(BadValue, match=f"{cls.__name__}.{name}"):
        cls(**{name: value})
    one = cls()
    before = one.pack()
    with pytest.raises(BadValue, match=name):
        setattr(one, name, value)
    assert one.pack() == before


def test_longest_name_fits() -> None:
    one = candrv.CAN_PROPERTIES(device_name="x" * 99)
    assert candrv.CAN_PROPERTIES.unpack(one.pack()).device_name == "x" * 99
