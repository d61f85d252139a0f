"""FIFO interfaces over a ring in memory: the rules that need no hub."""

from __future__ import annotations

import struct
import threading
from collections.abc import Iterator
from itertools import pairwise
from types import SimpleNamespace
from typing import Any
from uuid import UUID

import pytest

import canwire
from canwire import vci
from canwire.platform import EventDescriptor
from canwire.ring import Ring, ring_size
from canwire.vci.fifo.elements import CAN_MSG2S, CAN_MSGS, Elements, Plain
from canwire.vci.fifo.size import whole_pages
from tests.cases import each


class Lease:
    """What a ring's end belongs to."""

    name = "FIFO"
    over = False
    hub = SimpleNamespace(virtual=False)

    def __init__(self) -> None:
        self.gone: Exception | None = None

    def check(self) -> None:
        if self.gone is not None:
            raise self.gone


def alone(iid: UUID) -> Any:
    raise vci.VciError(vci.VCI_E_NOINTERFACE)


class Pair:
    """Both interfaces of one FIFO, with a ring end each, as two processes would have them."""

    def __init__(self, form: Elements[Any], capacity: int = 5) -> None:
        buffer = memoryview(bytearray(ring_size(8, form.cell)))
        rings = [Ring(capacity, exact=True, record_size=form.cell, buffer=buffer) for _ in range(2)]
        readable, writable = EventDescriptor(), EventDescriptor()
        self.lease = Lease()
        self.released: list[str] = []
        ends = []
        for ring, descriptor, reads in zip(rings, (readable, writable), (True, False), strict=True):
            ring.event, ring.free_event = readable, writable
            lease: Any = self.lease
            ends.append(canwire.RingEnd(lease, ring, descriptor, reads=reads))
        self.reader: vci.FifoReader[Any] = vci.FifoReader(
            ends[0], form, lambda: self.released.append("reader"), alone
        )
        self.writer: vci.FifoWriter[Any] = vci.FifoWriter(
            ends[1], form, lambda: self.released.append("writer"), alone
        )

    def fill(self, *numbers: int) -> None:
        for number in numbers:
            self.writer.put_data_entry(number.to_bytes(4, "little"))

    def drain(self) -> list[int]:
        found = []
        while self.reader.get_fill_count():
            found.append(int.from_bytes(self.reader.get_data_entry(), "little"))
        return found


@pytest.fixture
def pair() -> Pair:
    return Pair(Plain(4))


@pytest.fixture
def event() -> Iterator[canwire.Event]:
    with_event = canwire.Event()
    yield with_event
    with_event.close()


# how many elements


@pytest.mark.conforms("X4-08")
@each(
    ("count", "size", "gets"),
    [
        (32, 16, 254),
        (1, 16, 254),
        (254, 16, 254),
        (255, 16, 510),
        (1, 20, 203),
        (1, 80, 50),
        (51, 80, 102),
        (1, 4073, 2),
    ],
)
def test_whole_pages_are_made_use_of(count: int, size: int, gets: int) -> None:
    assert whole_pages(count, size) == gets
    assert whole_pages(gets, size) == gets


# one after the other


@pytest.mark.conforms("X4-09")
def test_order_is_kept(pair: Pair) -> None:
    pair.fill(1, 2, 3)
    assert pair.drain() == [1, 2, 3]
    pair.fill(4, 5, 6, 7, 8)
    assert pair.drain() == [4, 5, 6, 7, 8]


@pytest.mark.conforms("X4-09")
def test_a_full_fifo_refuses_the_new_element(pair: Pair) -> None:
    pair.fill(1, 2, 3, 4, 5)
    with pytest.raises(vci.VciTxQueueFull):
        pair.fill(6)
    assert pair.drain() == [1, 2, 3, 4, 5]


def test_an_empty_fifo_has_nothing(pair: Pair) -> None:
    for take in (pair.reader.get_data_entry, pair.reader.acquire_read):
        with pytest.raises(vci.VciRxQueueEmpty):
            take()


def test_an_entry_can_be_thrown_away(pair: Pair) -> None:
    pair.fill(1, 2)
    assert pair.reader.get_data_entry(discard=True) is None
    assert pair.drain() == [2]


def test_elements_have_their_size(pair: Pair) -> None:
    for wrong in (b"", b"123", b"12345", "1234", 1234, vci.CanInitLine2()):
        with pytest.raises(vci.VciInvalidArgument):
            pair.writer.put_data_entry(wrong)
    pair.writer.put_data_entry(vci.CanInitLine(op_mode=1, bt_reg1=0x1C))
    assert pair.reader.get_data_entry() == b"\x01\0\0\x1c"


# counts


@pytest.mark.conforms("X4-12")
def test_counts(pair: Pair) -> None:
    for end in (pair.reader, pair.writer):
        assert (end.get_capacity(), end.get_entry_size()) == (5, 4)
        assert (end.get_fill_count(), end.get_free_count()) == (0, 5)
    pair.fill(1, 2)
    for end in (pair.reader, pair.writer):
        assert (end.get_fill_count(), end.get_free_count()) == (2, 3)


@pytest.mark.conforms("X4-12")
def test_a_threshold_is_kept_inside_the_capacity(pair: Pair) -> None:
    for end in (pair.reader, pair.writer):
        assert end.get_threshold() == 1
        for wanted, gets in ((3, 3), (5, 5), (6, 5), (65535, 5), (0, 1)):
            end.set_threshold(wanted)
            assert end.get_threshold() == gets
        with pytest.raises(vci.VciInvalidArgument):
            end.set_threshold(-1)


# blocks


@pytest.mark.conforms("X4-10")
def test_a_block_lies_in_the_fifos_own_memory(pair: Pair) -> None:
    block, count = pair.writer.acquire_write()
    assert count == len(block) == 5
    block[0] = b"aaaa"
    block.memory[4:8] = b"bbbb"
    block.records[2] = list(b"cccc")
    pair.writer.release_write(3)
    assert [pair.reader.get_data_entry() for _ in range(3)] == [b"aaaa", b"bbbb", b"cccc"]


@pytest.mark.conforms("X4-10")
def test_releasing_fewer_keeps_the_rest(pair: Pair) -> None:
    pair.fill(1, 2, 3, 4, 5)
    block, count = pair.reader.acquire_read()
    assert (count, [element[0] for element in block]) == (5, [1, 2, 3, 4, 5])
    pair.reader.release_read(2)
    assert pair.reader.get_fill_count() == 3
    block, count = pair.reader.acquire_read()
    assert (count, [element[0] for element in block]) == (3, [3, 4, 5])
    pair.reader.release_read(0)
    assert pair.drain() == [3, 4, 5]


@pytest.mark.conforms("X4-10")
def test_at_the_end_of_the_memory_less_is_offered(pair: Pair) -> None:
    """The memory has eight places: from the sixth on three lie in one piece, the other two at its beginning."""
    pair.fill(1, 2, 3, 4, 5)
    assert pair.drain() == [1, 2, 3, 4, 5]
    block, count = pair.writer.acquire_write()
    assert (count, pair.writer.get_free_count()) == (3, 5)
    block[0], block[1], block[2] = b"\x06\0\0\0", b"\x07\0\0\0", b"\x08\0\0\0"
    pair.writer.release_write(3)
    assert pair.writer.acquire_write()[1] == 2
    pair.fill(9)
    found = []
    while pair.reader.get_fill_count():
        block, count = pair.reader.acquire_read()
        found.append([element[0] for element in block])
        pair.reader.release_read(count)
    assert found == [[6, 7, 8], [9]]


def test_more_than_was_acquired_cannot_be_released(pair: Pair) -> None:
    pair.fill(1, 2)
    for release in (pair.reader.release_read, pair.writer.release_write):
        release(0)
        with pytest.raises(vci.VciInvalidArgument):
            release(1)
    pair.reader.acquire_read()
    pair.fill(3)
    with pytest.raises(vci.VciInvalidArgument):
        pair.reader.release_read(3)
    pair.reader.release_read(2)
    with pytest.raises(vci.VciInvalidArgument):
        pair.reader.release_read(1)
    assert pair.drain() == [3]


def test_a_released_block_is_dead(pair: Pair) -> None:
    pair.fill(1, 2)
    block, _ = pair.reader.acquire_read()
    memory = block.memory
    pair.reader.release_read(1)
    for use in (lambda: block[0], lambda: block.memory, lambda: block.records):
        with pytest.raises(vci.VciError, match="this block of a FIFO was released") as raised:
            use()
        assert raised.value.code == vci.VCI_E_INVHANDLE
    with pytest.raises(ValueError, match="released"):
        memory[0]
    block, _ = pair.reader.acquire_read()
    pair.reader.get_data_entry()
    with pytest.raises(vci.VciError, match="released"):
        block[0]


def test_an_array_over_a_block_outlives_it(pair: Pair) -> None:
    pair.fill(1)
    block, _ = pair.reader.acquire_read()
    array = block.records
    pair.reader.release_read(1)
    assert array.shape == (1, 4)


def test_a_block_is_a_sequence(pair: Pair) -> None:
    pair.fill(1, 2, 3)
    block, _ = pair.reader.acquire_read()
    assert block[-1] == block[2] == b"\x03\0\0\0"
    assert block[:2] == [block[0], block[1]]
    for wrong in (3, -4):
        with pytest.raises(IndexError):
            block[wrong]
    with pytest.raises(TypeError, match="reader"):
        block[0] = b"abcd"
    with pytest.raises(TypeError):
        block.memory[0] = 1
    assert not block.records.flags.writeable


# CANMSG and CANMSG2


def test_canmsg2_is_what_lies_there() -> None:
    pair = Pair(CAN_MSG2S)
    message = vci.CanMsg2(time=7, msg_id=0x123, data=bytes(range(12)), edl=1, fdr=1)
    pair.writer.put_data_entry(message)
    pair.writer.put_data_entry(message.to_bytes())
    block, count = pair.reader.acquire_read()
    assert (count, block.memory.nbytes, pair.reader.get_entry_size()) == (2, 160, 80)
    assert block.records["dwMsgId"].tolist() == [0x123, 0x123]
    assert block.records.base is not None
    assert list(block) == [message, message]
    pair.reader.release_read(1)
    assert pair.reader.get_data_entry() == message
    with pytest.raises(vci.VciInvalidArgument, match="a CanMsg2 belongs here"):
        pair.writer.put_data_entry(vci.CanMsg())


def test_canmsg_lies_in_cells_of_canmsg2() -> None:
    pair = Pair(CAN_MSGS)
    message = vci.CanMsg(time=9, msg_id=0x7FF, data=b"12345678", srr=1)
    pair.writer.put_data_entry(message)
    pair.writer.put_data_entry(message.to_bytes())
    block, count = pair.reader.acquire_read()
    assert (count, pair.reader.get_entry_size(), pair.writer.get_entry_size()) == (2, 20, 20)
    assert bytes(block.memory) == 2 * message.to_bytes()
    assert block.records["dwTime"].tolist() == [9, 9]
    assert block.records["abData"][1].tobytes() == b"12345678"
    assert block.records.strides == (80,)
    assert block[1] == message
    pair.reader.release_read(2)


@pytest.mark.conforms("X4-15")
@pytest.mark.parametrize("bits", [{"edl": 1}, {"fdr": 1}])
def test_canmsg_has_no_fd(bits: dict[str, int]) -> None:
    pair = Pair(CAN_MSGS)
    message = vci.CanMsg(msg_id=1, data=b"1")
    for bit, value in bits.items():
        setattr(message.msg_info, bit, value)
    with pytest.raises(vci.VciInvalidArgument, match="use ICanChannel2"):
        pair.writer.put_data_entry(message)
    block, _ = pair.writer.acquire_write()
    block.records["uMsgInfo"][0] = message.msg_info.value
    with pytest.raises(vci.VciInvalidArgument, match="use ICanChannel2"):
        pair.writer.release_write(1)
    block.records["uMsgInfo"][0] = 0
    pair.writer.release_write(1)
    assert pair.reader.get_fill_count() == 1


def test_what_a_canmsg_does_not_have_is_cleared() -> None:
    pair = Pair(CAN_MSGS)
    block, _ = pair.writer.acquire_write()
    cells = block._cells
    assert cells is not None
    cells[:160] = bytes([0]) * 12 + struct.pack("<I", 1 << 16) + bytes([0xEE]) * 64 + bytes(80)
    cells[4:8] = b"\xee" * 4
    pair.writer.release_write(1)
    record = bytes(pair.reader._ring.acquire(1)[0])
    assert record == bytes(12) + struct.pack("<I", 1 << 16) + b"\xee" * 8 + bytes(56)


def test_canmsgs_to_write_do_not_lie_side_by_side() -> None:
    pair = Pair(CAN_MSGS)
    block, _ = pair.writer.acquire_write()
    block[0] = vci.CanMsg(msg_id=5)
    with pytest.raises(vci.VciNotImplemented, match=r"block\[i\]"):
        block.memory[0] = 1
    pair.writer.release_write(1)
    assert pair.reader.get_data_entry().msg_id == 5


# locks


@pytest.mark.conforms("X4-11")
def test_locks_nest_and_another_thread_waits(pair: Pair) -> None:
    order: list[str] = []
    began, held = threading.Event(), threading.Event()

    def other() -> None:
        began.set()
        pair.reader.lock()
        order.append("other")
        pair.reader.unlock()
        held.set()

    pair.reader.lock()
    pair.reader.lock()
    thread = threading.Thread(target=other)
    thread.start()
    began.wait(10)
    pair.reader.unlock()
    assert not held.wait(0.05)
    order.append("this")
    pair.reader.unlock()
    assert held.wait(10)
    thread.join()
    assert order == ["this", "other"]


@pytest.mark.conforms("X4-11")
def test_both_ends_have_a_lock_of_their_own(pair: Pair) -> None:
    pair.reader.lock()
    thread = threading.Thread(target=lambda: (pair.writer.lock(), pair.fill(1), pair.writer.unlock()))
    thread.start()
    thread.join(10)
    assert not thread.is_alive()
    pair.reader.unlock()


def test_who_does_not_hold_the_lock_cannot_unlock(pair: Pair) -> None:
    with pytest.raises(vci.VciInvalidState):
        pair.reader.unlock()


# events


@pytest.mark.conforms("X4-13")
def test_an_event_comes_with_a_write_only(pair: Pair, event: canwire.Event) -> None:
    """Threshold 1, several queued, one read: nothing until the next write."""
    pair.reader.assign_event(event)
    assert not event.wait(0)
    pair.fill(1, 2, 3)
    assert event.wait(10)
    pair.reader.get_data_entry()
    assert not event.wait(0.02)
    pair.fill(4)
    assert event.wait(10)


@pytest.mark.conforms("X3-22", "X4-13")
def test_a_reader_is_woken_at_its_threshold(pair: Pair, event: canwire.Event) -> None:
    pair.reader.set_threshold(3)
    pair.reader.assign_event(event)
    pair.fill(1, 2)
    assert not event.wait(0.02)
    pair.fill(3)
    assert event.wait(10)


@pytest.mark.conforms("X3-22")
def test_a_writer_is_woken_when_there_is_room(pair: Pair, event: canwire.Event) -> None:
    pair.writer.set_threshold(2)
    pair.writer.assign_event(event)
    pair.fill(1, 2, 3, 4, 5)
    pair.reader.get_data_entry()
    assert not event.wait(0.02)
    block, _ = pair.reader.acquire_read()
    pair.reader.release_read(1)
    assert event.wait(10)
    assert len(block) == 4


def test_there_is_one_event_at_a_time(pair: Pair, event: canwire.Event) -> None:
    other = canwire.Event()
    pair.reader.assign_event(event)
    pair.reader.assign_event(other)
    pair.fill(1)
    assert other.wait(10)
    assert not event.wait(0)
    pair.reader.assign_event(None)
    pair.fill(2)
    assert not other.wait(0.02)
    other.close()


# whose they are


def test_release_tells_the_owner(pair: Pair, event: canwire.Event) -> None:
    pair.reader.set_threshold(2)
    pair.reader.assign_event(event)
    block = pair.writer.acquire_write()[0]
    assert [pair.reader.release(), pair.writer.release()] == [0, 0]
    assert pair.released == ["reader", "writer"]
    with pytest.raises(vci.VciError, match="released"):
        block[0]
    with pytest.raises(vci.VciError) as raised:
        pair.reader.get_fill_count()
    assert raised.value.code == vci.VCI_E_INVHANDLE


def test_an_end_without_a_fifo_is_dead(pair: Pair) -> None:
    pair.reader.cut("the channel was initialised anew")
    with pytest.raises(vci.VciError, match="initialised anew") as raised:
        pair.reader.get_data_entry()
    assert raised.value.code == vci.VCI_E_INVHANDLE
    assert pair.reader.release() == 0
    assert pair.released == []


@pytest.mark.conforms("X3-35")
@pytest.mark.parametrize(
    ("why", "code"),
    [(canwire.Unplugged("gone"), "DEVICE_NOT_CONNECTED"), (canwire.HubLost("gone"), "DISCONNECTED")],
)
def test_every_call_says_that_the_board_is_gone(pair: Pair, why: Exception, code: str) -> None:
    pair.fill(1)
    pair.lease.gone = why
    calls = [
        pair.reader.get_data_entry,
        pair.reader.acquire_read,
        pair.reader.get_fill_count,
        pair.reader.lock,
        pair.writer.acquire_write,
        lambda: pair.fill(1),
        lambda: pair.reader.release_read(0),
        lambda: pair.writer.set_threshold(1),
    ]
    for call in calls:
        with pytest.raises(vci.VciError) as raised:
            call()
        assert raised.value.code == getattr(vci, f"VCI_E_{code}")
    assert pair.reader.release() == 0


def test_interfaces(pair: Pair) -> None:
    assert pair.reader.query_interface(vci.IID_IFifoReader) is pair.reader
    with pytest.raises(vci.VciNoInterface):
        pair.reader.query_interface(vci.IID_IFifoWriter)
    with pytest.raises(vci.VciNoInterface):
        pair.writer.query_interface(vci.IID_IFifoReader)


def test_messages_of_one_writer_arrive_in_order_whatever_is_used() -> None:
    pair = Pair(CAN_MSG2S)
    sent = []
    for number in range(40):
        if number % 3:
            pair.writer.put_data_entry(vci.CanMsg2(msg_id=number))
        else:
            block, _ = pair.writer.acquire_write()
            block[0] = vci.CanMsg2(msg_id=number)
            pair.writer.release_write(1)
        if number % 2:
            block, _ = pair.reader.acquire_read()
            sent += block.records["dwMsgId"].tolist()
            pair.reader.release_read(len(block))
    while pair.reader.get_fill_count():
        sent.append(pair.reader.get_data_entry().msg_id)
    assert all(later == earlier + 1 for earlier, later in pairwise(sent))
    assert len(sent) == 40
