"""A writer's block is the FIFO's memory: what a program writes into an element is what is sent."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from canwire import vci
from canwire.vci.fifo.elements import CAN_MSG2S, CAN_MSGS, Plain
from tests.vci.fifo.test_fifo import Pair

FORMS = {"CANMSG": (CAN_MSGS, vci.CanMsg), "CANMSG2": (CAN_MSG2S, vci.CanMsg2)}
forms = pytest.mark.parametrize("form", list(FORMS))


@pytest.mark.conforms("X4-10")
@pytest.mark.finding("dialects 2")
@forms
def test_what_is_written_into_an_element_is_sent(form: str) -> None:
    """Field by field, as the manual's listing and C++ programs do."""
    elements, kind = FORMS[form]
    pair: Any = Pair(elements)
    block, _ = pair.writer.acquire_write()
    message = block[0]
    message.time, message.msg_id = 5, 0x200
    message.msg_info.bytes_type = vci.CAN_MSGTYPE_DATA
    message.msg_info.flags = message.msg_info.flags2 = 0
    message.msg_info.dlc, message.msg_info.ext = 3, 1
    message.ab_data[0], message.ab_data[1:3] = 0x11, b"\x22\x33"
    pair.writer.release_write(1)
    assert pair.reader.get_data_entry() == kind(time=5, msg_id=0x200, data=b"\x11\x22\x33", ext=1)


@forms
def test_an_element_reads_what_lies_there(form: str) -> None:
    elements, kind = FORMS[form]
    pair: Any = Pair(elements)
    block, _ = pair.writer.acquire_write()
    first, again = block[0], block[0]
    block[0] = kind(time=1, msg_id=0x123, data=b"abc", srr=1)
    assert first is again
    assert isinstance(first, kind)
    assert (first.time, first.msg_id, first.data, first.msg_info.srr) == (1, 0x123, b"abc", 1)
    assert first == kind(time=1, msg_id=0x123, data=b"abc", srr=1)
    assert repr(first) == repr(kind(time=1, msg_id=0x123, data=b"abc", srr=1))
    block.records["dwMsgId"][0] = 0x321
    assert first.msg_id == 0x321


@forms
def test_an_element_takes_whole_fields(form: str) -> None:
    elements, _ = FORMS[form]
    pair: Any = Pair(elements)
    block, _ = pair.writer.acquire_write()
    block[0].msg_info = vci.CanMsgInfo(dlc=2, rtr=0)
    block[0].ab_data = b"\x01\x02"
    block[1].data = b"12345678"
    block[-3] = block[1]
    pair.writer.release_write(3)
    assert [pair.reader.get_data_entry().data for _ in range(3)] == [b"\1\2", b"12345678", b"12345678"]


def test_canmsg2s_reserved_word_and_long_data() -> None:
    pair: Any = Pair(CAN_MSG2S)
    block, _ = pair.writer.acquire_write()
    block[0].reserved = 0xFFFF_FFFF
    assert block[0].reserved == 0xFFFF_FFFF
    block[0].reserved = 0
    block[0].data = bytes(range(64))
    pair.writer.release_write(1)
    assert pair.reader.get_data_entry() == vci.CanMsg2(data=bytes(range(64)))


@forms
def test_an_element_refuses_what_does_not_fit(form: str) -> None:
    elements, kind = FORMS[form]
    pair: Any = Pair(elements)
    message = pair.writer.acquire_write()[0][0]
    for name, wrong in (
        ("time", -1),
        ("msg_id", 1 << 32),
        ("msg_id", "1"),
        ("ab_data", bytes(kind.ROOM + 1)),
        ("ab_data", 5),
        ("data", bytes(65)),
    ):
        with pytest.raises(vci.VciInvalidArgument):
            setattr(message, name, wrong)
    with pytest.raises(vci.VciInvalidArgument):
        message.msg_info.dlc = 16
    assert message == kind()


@forms
def test_an_element_dies_with_its_block_and_a_copy_does_not(form: str) -> None:
    elements, kind = FORMS[form]
    pair: Any = Pair(elements)
    block, _ = pair.writer.acquire_write()
    block[0] = kind(msg_id=7, data=b"7")
    message, info = block[0], block[0].msg_info
    kept = message.copy()
    pair.writer.release_write(1)

    def write() -> None:
        message.msg_id = 8

    for use in (lambda: block[0], lambda: message.msg_id, lambda: message.ab_data, lambda: info.dlc, write):
        with pytest.raises(vci.VciError, match="this block of a FIFO was released") as raised:
            use()
        assert raised.value.code == vci.VCI_E_INVHANDLE
    assert type(kept) is kind
    assert kept == copy.deepcopy(kept) == pair.reader.get_data_entry() == kind(msg_id=7, data=b"7")


def test_an_element_may_be_put_into_another_fifo() -> None:
    pair: Any = Pair(CAN_MSGS)
    other: Any = Pair(CAN_MSGS)
    block, _ = pair.writer.acquire_write()
    block[0].data = b"x"
    other.writer.put_data_entry(block[0])
    assert other.reader.get_data_entry().data == b"x"


def test_an_element_of_any_size_is_its_memory() -> None:
    pair: Any = Pair(Plain(4))
    block, _ = pair.writer.acquire_write()
    block[0][:] = b"abcd"
    block[1][0] = 0xFF
    pair.writer.release_write(2)
    assert pair.reader.get_data_entry() == b"abcd"
    assert pair.reader.get_data_entry() == b"\xff\0\0\0"


@forms
def test_a_readers_element_is_its_own_and_may_be_kept(form: str) -> None:
    elements, kind = FORMS[form]
    pair: Any = Pair(elements)
    pair.writer.put_data_entry(kind(msg_id=1, data=b"1"))
    block, count = pair.reader.acquire_read()
    message = block[0]
    message.ab_data[0] = 0x32
    assert block[0] is message
    pair.reader.release_read(count)
    assert message.data == b"2"
    with pytest.raises(vci.VciError, match="released"):
        block[0]
