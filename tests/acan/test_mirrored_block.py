"""ACANTB as drivers keep it up to date. Source: INduCAN104 manual, "Task block"."""

from __future__ import annotations

import contextlib
import queue
from typing import Any

import pytest

from canwire import BadValue, Frame
from canwire.acan.constants import (
    FF_EXTENDED,
    FF_RTR,
    IDA_CHANRCV,
    IDA_NOTIFY,
    IDA_QUEUEMSG,
    TBNT_CALLBACK,
    TBNT_EVENT,
    TBNT_POSTMESSAGE,
    TBS_MB,
    TBS_OVERFLOW,
)
from canwire.acan.identifiers import acan_word
from canwire.acan.messages import frame_of, message_of
from canwire.acan.mirrored_block import MirroredBlock
from canwire.acan.structures import ACANID, ACANMB, ACANMBSZ, ACANTB
from tests.cases import each

ALL = ACANID(0, 0, IDA_NOTIFY | IDA_QUEUEMSG)


def registered(fields: ACANTB) -> MirroredBlock:
    class Keeper:
        lock = contextlib.nullcontext()

    block = MirroredBlock(fields)
    block.attach(Keeper())  # type: ignore[arg-type]
    return block


def offer(block: MirroredBlock, *frames: Frame) -> None:
    for frame in frames:
        block.offer(frame, acan_word(frame.id, frame.extended))


@pytest.mark.conforms("AC-17")
@each(
    ("frame", "message"),
    [
        (Frame(0x7FF, b"ab"), ACANMB(0x1FFC_0000, 0, 2, b"ab")),
        (Frame(0x1, b""), ACANMB(0x0004_0000, 0, 0)),
        (Frame(0x1234_5678, b"12345678", extended=True), ACANMB(0x1234_5678, FF_EXTENDED, 8, b"12345678")),
        (Frame(0x7, remote=True, dlc=3), ACANMB(0x001C_0000, FF_RTR, 3)),
    ],
)
def test_frames_and_messages(frame: Frame, message: ACANMB) -> None:
    assert message_of(frame) == message
    assert frame_of(message) == frame


@pytest.mark.conforms("AC-17")
def test_bits_that_mean_nothing_are_passed_over_when_sent() -> None:
    assert frame_of(ACANMB(0xE000_0000 | 1 << 18 | 0x3_FFFF, 0x3F, 1, b"a")) == Frame(1, b"a")
    assert message_of(Frame(1, bytes(8), dlc=15)).bLength == 8
    with pytest.raises(BadValue, match="bLength"):
        frame_of(ACANMB(0, 0, 9))


@pytest.mark.conforms("AC-29", "AC-30")
@pytest.mark.parametrize("memory", [list, lambda: bytearray(3 * ACANMBSZ)])
def test_indices_and_occupation_go_round(memory: Any) -> None:
    fields = ACANTB(lpRMB=memory(), wRMBSize=3, lpBuf=memory(), wCount=2, idTable=[ALL])
    block = registered(fields)
    offer(block, *(Frame(number) for number in range(4)))
    assert (fields.wRMBOccupation, fields.wRIndex, fields.wWIndex) == (3, 0, 0)
    assert fields.wStatus == TBS_MB | TBS_OVERFLOW
    assert block.retrieve_into(fields.lpBuf, fields.wCount) == 2
    assert ids(fields.lpBuf, 2) == [0, 1]
    assert (fields.wRMBOccupation, fields.wRIndex, fields.wWIndex) == (1, 2, 0)
    offer(block, Frame(9))
    assert (fields.wRMBOccupation, fields.wRIndex, fields.wWIndex) == (2, 2, 1)
    assert ids(fields.lpRMB, 3) == [9, 1, 2]
    assert block.acknowledge() == TBS_MB | TBS_OVERFLOW
    assert fields.wStatus == 0
    assert block.retrieve_into(fields.lpBuf, fields.wCount) == 2
    assert ids(fields.lpBuf, 2) == [2, 9]
    assert block.retrieve_into(fields.lpBuf, fields.wCount) == 0


def ids(memory: Any, count: int) -> list[int]:
    if isinstance(memory, list):
        return [message.dwID >> 18 for message in memory[:count]]
    packed = [memory[at : at + ACANMBSZ] for at in range(0, count * ACANMBSZ, ACANMBSZ)]
    return [ACANMB.unpack(one).dwID >> 18 for one in packed]


@pytest.mark.conforms("AC-35")
@each(
    ("field", "fields"),
    [
        ("bNId", {"bNId": 2, "idTable": [ALL]}),
        ("bNotType", {"bNotType": 3}),
        ("cbNotification", {"bNotType": TBNT_CALLBACK}),
        ("cbNotification", {"bNotType": TBNT_POSTMESSAGE}),
        ("cbNotification", {"bNotType": TBNT_POSTMESSAGE, "hwnd": 7}),
        ("cbNotification", {"bNotType": TBNT_EVENT, "cbNotification": 0x1234_5678}),
        ("hEvent", {"bNotType": TBNT_EVENT, "hEvent": 7}),
        ("wRMBSize", {"idTable": [ALL]}),
        ("lpRMB", {"idTable": [ALL], "wRMBSize": 1}),
        ("lpRMB", {"idTable": [ALL], "wRMBSize": 1, "lpRMB": bytearray(ACANMBSZ - 1)}),
        ("lpRMB", {"idTable": [ALL], "wRMBSize": 1, "lpRMB": bytes(ACANMBSZ)}),
        ("lpAddress", {"idTable": [ACANID(0, 0, IDA_CHANRCV, 1)]}),
        ("bLength", {"idTable": [ACANID(0, 0, IDA_CHANRCV, 0, lpAddress=bytearray(8))]}),
        ("bLength", {"idTable": [ACANID(0, 0, IDA_CHANRCV, 9, lpAddress=bytearray(9))]}),
        ("bAction", {"idTable": [ACANID(0, 0, 0x30, 1, lpAddress=bytearray(8))]}),
        ("bAction", {"idTable": [ACANID(0, 0, 0x01)]}),
    ],
)
def test_fields_that_cannot_be_are_named(field: str, fields: dict[str, Any]) -> None:
    with pytest.raises(BadValue, match=field):
        MirroredBlock(ACANTB(**fields))


@pytest.mark.conforms("AC-30")
@each("buffer", [None, bytearray(ACANMBSZ), bytes(9 * ACANMBSZ), 5])
def test_a_buffer_that_cannot_take_them_is_refused_and_nothing_is_lost(buffer: Any) -> None:
    block = registered(ACANTB(lpRMB=[], wRMBSize=3, idTable=[ALL]))
    offer(block, Frame(1), Frame(2))
    with pytest.raises(BadValue, match="lpBuf"):
        block.retrieve_into(buffer, 2)
    assert block.occupation == 2


@pytest.mark.conforms("AC-25")
def test_the_three_ways_to_tell() -> None:
    told: list[Any] = []
    posted: queue.SimpleQueue[Any] = queue.SimpleQueue()
    event = ACANTB(cbNotification=lambda block: told.append(block))
    called = ACANTB(bNotType=TBNT_CALLBACK, cbNotification=told.append, dwRefData="reference")
    window = ACANTB(bNotType=TBNT_POSTMESSAGE, hwnd=posted, nMsg=0x400, dwRefData=77, wStatus=2)
    post = ACANTB(bNotType=TBNT_POSTMESSAGE, cbNotification=lambda *what: told.append(what), nMsg=1, hwnd=5)
    for fields in (event, called, window, post):
        MirroredBlock(fields).notify()
    assert told == [event, "reference", (5, 1, 0, 0)]
    assert posted.get(timeout=0) == (posted, 0x400, 2, 77)
