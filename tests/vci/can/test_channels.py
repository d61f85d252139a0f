"""Message channels: queues of their own on a line that several programs share."""

from __future__ import annotations

import itertools
from typing import Any

import numpy
import pytest

import canwire
from canwire import vci
from tests.hubs import until
from tests.vci.programs import CLASSIC_BOARD, Program, Virtual

TICK_US = 1  # of a time stamp
DELAY_TICK_US = 100  # of a delayed message
LONGEST_DELAY = 65_535  # in ticks


def message(msg_id: int, data: bytes = b"", **bits: int) -> vci.CanMsg2:
    return vci.CanMsg2(msg_id=msg_id, data=data, **bits)


def ids(messages: list[Any]) -> list[int]:
    return [one.msg_id for one in messages]


@pytest.mark.conforms("X3-19", "X3-20")
def test_messages_go_from_one_line_to_the_other(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0)
    program.start(1)
    sender.send(message(0x123, b"hello"), message(0x18DAF110, b"\x01", ext=1), message(0x7, rtr=1, dlc=3))
    first, second, third = receiver.messages(3)
    assert (first.msg_id, first.data, first.msg_info.ext) == (0x123, b"hello", 0)
    assert (second.msg_id, second.data, second.msg_info.ext) == (0x18DAF110, b"\x01", 1)
    assert (third.msg_id, third.data, third.msg_info.rtr, third.msg_info.dlc) == (7, b"", 1, 3)
    assert first.time < second.time < third.time


# life of a channel


@pytest.mark.finding("vendor 12")
@pytest.mark.conforms("X3-16")
@pytest.mark.parametrize("socket", [vci.IID_ICanSocket, vci.IID_ICanSocket2])
def test_before_it_is_initialised_a_channel_can_do_nothing(program: Program, socket: Any) -> None:
    channel = program.keep(program.open(socket).create_channel(False))
    for call in (channel.activate, channel.deactivate, channel.get_reader, channel.get_writer):
        with pytest.raises(vci.VciNotInitialized):
            call()
    status = channel.get_status()
    assert (status.activated, status.rx_overrun, status.rx_fifo_load, status.tx_fifo_load) == (
        False,
        False,
        0,
        0,
    )


@pytest.mark.conforms("X4-35")
def test_before_it_is_initialised_a_channel_has_no_filters(program: Program) -> None:
    channel = program.keep(program.open(vci.IID_ICanSocket2).create_channel(False))
    calls = [
        lambda: channel.get_filter_mode(vci.CAN_FILTER_STD),
        lambda: channel.set_filter_mode(vci.CAN_FILTER_STD, vci.CAN_FILTER_PASS),
        lambda: channel.set_acc_filter(vci.CAN_FILTER_STD, 0, 0),
        lambda: channel.add_filter_ids(vci.CAN_FILTER_STD, 0, 0xFFF),
        lambda: channel.rem_filter_ids(vci.CAN_FILTER_EXT, 0, 0xFFF),
    ]
    for call in calls:
        with pytest.raises(vci.VciNotInitialized):
            call()


@pytest.mark.conforms("X3-16", "X3-19")
def test_an_inactive_channel_gets_nothing_and_never_will(program: Program) -> None:
    sender, awake, asleep = program.port(0), program.port(1), program.port(1, active=False)
    program.start(0)
    program.start(1)
    sender.send(message(1))
    awake.message()
    asleep.channel.activate()
    sender.send(message(2))
    assert asleep.message().msg_id == 2
    asleep.channel.deactivate()
    sender.send(message(3))
    assert ids(awake.messages(2)) == [2, 3]
    assert asleep.waiting() == []


@pytest.mark.conforms("X3-19")
def test_a_stopped_line_gets_nothing_and_never_will(program: Program) -> None:
    sender, helper, receiver = program.port(0), program.port(0, "HW000002"), program.port(1)
    program.start(0)
    program.start(0, "HW000002")
    control = program.control(1)
    control.init_line(program.init())
    sender.send(message(1))
    helper.message()
    control.start_line()
    sender.send(message(2))
    assert receiver.message().msg_id == 2


@pytest.mark.conforms("X4-38")
@pytest.mark.parametrize("socket", [vci.IID_ICanSocket, vci.IID_ICanSocket2])
def test_sizes(program: Program, socket: Any) -> None:
    channel = program.keep(program.open(socket).create_channel(False))
    size = 20 if socket == vci.IID_ICanSocket else 80
    more = () if socket == vci.IID_ICanSocket else (0, vci.CAN_FILTER_PASS)
    for wrong in ((0, 10), (-1, 10), (10, -1), (1 << 32, 10)):
        with pytest.raises(vci.VciInvalidArgument):
            channel.initialize(*wrong, *more)
    with pytest.raises(vci.VciNotInitialized):
        channel.get_reader()
    channel.initialize(10, 0, *more)
    with pytest.raises(vci.VciInvalidState, match="no transmit FIFO"):
        channel.get_writer()
    channel.initialize(1, 300, *more)
    with channel.get_reader() as reader, channel.get_writer() as writer:
        assert reader.get_entry_size() == writer.get_entry_size() == size
        assert reader.get_capacity() == (4096 - 24) // size
        pages = -(-(300 * size + 24) // 4096)
        assert writer.get_capacity() == writer.get_free_count() == (pages * 4096 - 24) // size


@pytest.mark.conforms("X4-34", "X4-35")
@pytest.mark.parametrize("mode", [0, 5, 0x7F, 0x100])
def test_a_channel_is_initialised_with_a_filter_mode(program: Program, mode: int) -> None:
    channel = program.keep(program.open(vci.IID_ICanSocket2).create_channel(False))
    with pytest.raises(vci.VciInvalidArgument):
        channel.initialize(10, 10, 0, mode)


@pytest.mark.conforms("X3-16")
def test_initialising_again_makes_everything_new(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0)
    program.start(1)
    sender.send(message(1), message(2))
    assert receiver.message().msg_id == 1
    receiver.channel.initialize(100, 100, 0, vci.CAN_FILTER_PASS)
    assert not receiver.channel.get_status().activated
    with pytest.raises(vci.VciError, match="initialised again") as raised:
        receiver.reader.get_fill_count()
    assert raised.value.code == vci.VCI_E_INVHANDLE
    with receiver.channel.get_reader() as reader:
        assert reader.get_fill_count() == 0


def test_a_released_channel_takes_its_ends_along(program: Program) -> None:
    port = program.port(0)
    assert port.channel.release() == 0
    for end in (port.reader, port.writer):
        with pytest.raises(vci.VciError, match="released") as raised:
            end.get_free_count()
        assert raised.value.code == vci.VCI_E_INVHANDLE
        assert end.release() == 0


# alone or together


@pytest.mark.conforms("X3-17")
def test_an_exclusive_channel_is_the_only_one(program: Program, other_program: Program) -> None:
    mine = program.open(vci.IID_ICanSocket2)
    theirs = other_program.open(vci.IID_ICanSocket)
    with mine.create_channel(True):
        for exclusive in (True, False):
            for socket in (mine, theirs):
                with pytest.raises(vci.VciAccessDenied):
                    socket.create_channel(exclusive)
    with mine.create_channel(False), theirs.create_channel(False), pytest.raises(vci.VciAccessDenied):
        theirs.create_channel(True)
    with theirs.create_channel(True):
        pass


@pytest.mark.conforms("X3-17")
def test_lines_are_not_each_others_business(program: Program) -> None:
    with (
        program.open(vci.IID_ICanSocket2, 0).create_channel(True),
        program.open(vci.IID_ICanSocket2, 1).create_channel(True),
    ):
        pass


@pytest.mark.conforms("X3-18")
def test_channels_of_a_line_take_turns(program: Program, other_program: Program) -> None:
    channels = [program.port(0), other_program.port(0), program.port(0)]
    receiver = program.port(1)
    control = program.control(0)
    control.init_line(program.init())
    for number, channel in enumerate(channels):
        channel.send(*(message(0x100 * number + k) for k in range(50)))
    program.start(1)
    control.start_line()
    counts = [0, 0, 0]
    for one in receiver.messages(150):
        assert one.msg_id & 0xFF == counts[one.msg_id >> 8]
        counts[one.msg_id >> 8] += 1
        assert max(counts) - min(counts) <= 1


# the ends of a channel's FIFOs


@pytest.mark.conforms("X3-21")
def test_each_end_is_open_once(program: Program) -> None:
    channel = program.keep(program.open(vci.IID_ICanSocket2).create_channel(False))
    channel.initialize(10, 10, 0, vci.CAN_FILTER_PASS)
    for get in (channel.get_reader, channel.get_writer):
        end = get()
        with pytest.raises(vci.VciAccessDenied, match="is open"):
            get()
        end.add_ref()
        assert end.release() == 1
        with pytest.raises(vci.VciAccessDenied):
            get()
        assert end.release() == 0
        with get() as again:
            assert again.get_threshold() == 1


def test_what_keeps_an_adapter_off_its_bus_stands_in_the_error(
    program: Program, monkeypatch: pytest.MonkeyPatch
) -> None:
    port = program.port(0, tx=1)
    monkeypatch.setattr(canwire.Hub, "obstacle", lambda *where: "can0: no such adapter")
    for number in range(port.writer.get_capacity()):
        port.send(message(number))
    with pytest.raises(vci.VciTxQueueFull, match="can0: no such adapter"):
        port.send(message(0x7FF))


@pytest.mark.conforms("X3-20")
def test_what_fits_is_queued(program: Program) -> None:
    port = program.port(0, tx=1)
    for number in range(port.writer.get_capacity()):
        port.send(message(number))
    with pytest.raises(vci.VciTxQueueFull):
        port.send(message(0x7FF))
    with pytest.raises(vci.VciTxQueueFull):
        port.writer.acquire_write()
    assert port.channel.get_status().tx_fifo_load == 100


@pytest.mark.conforms("X3-20", "X4-10")
def test_blocks_of_messages(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0)
    program.start(1)
    block, count = sender.writer.acquire_write()
    assert count == sender.writer.get_capacity()
    records = block.records
    records[:20] = numpy.zeros(20, records.dtype)
    records["dwMsgId"][:20] = range(20)
    records["uMsgInfo"][:20] = 2 << 16
    records["abData"][:20, 1] = range(20)
    sender.writer.release_write(20)
    assert [(one.msg_id, one.data) for one in receiver.messages(20)] == [
        (k, bytes([0, k])) for k in range(20)
    ]


@pytest.mark.finding("dialects 7")
@pytest.mark.parametrize("bits", [{"edl": 1}, {"fdr": 1}])
def test_a_classic_controller_refuses_can_fd_aloud(program: Program, bits: dict[str, int]) -> None:
    sender = program.port(0, CLASSIC_BOARD)
    refused = pytest.raises(vci.VciNotSupported, match="CAN_FEATURE_EXTDATA")
    with refused:
        sender.send(message(1, b"1", **bits))
    with refused:
        sender.writer.put_data_entry(message(1, b"1", **bits).to_bytes())
    block, _ = sender.writer.acquire_write()
    block[0].data = b"1"
    for bit, value in bits.items():
        setattr(block[0].msg_info, bit, value)
    with refused:
        sender.writer.release_write(1)
    block[0].msg_info.edl = block[0].msg_info.fdr = 0
    sender.writer.release_write(1)
    assert sender.channel.get_status().tx_fifo_load <= 1


@pytest.mark.conforms("X3-22")
def test_a_reader_is_told_at_its_threshold(program: Program, event: canwire.Event) -> None:
    sender, first, third = program.port(0), program.port(1), program.port(1)
    program.start(0)
    program.start(1)
    sender.send(message(0))
    first.message()
    third.message()
    third.reader.set_threshold(3)
    third.reader.assign_event(event)
    sender.send(message(1), message(2))
    first.messages(2)
    assert not event.is_set()
    sender.send(message(3))
    assert event.wait(30)
    assert third.reader.get_fill_count() == 3


@pytest.mark.conforms("X3-22")
def test_a_writer_is_told_when_there_is_room(program: Program, event: canwire.Event) -> None:
    sender, receiver = program.port(0, tx=1), program.port(1)
    program.start(1)
    room = sender.writer.get_capacity()
    sender.writer.set_threshold(room // 2)
    sender.writer.assign_event(event)
    sender.send(*(message(number) for number in range(room)))
    assert not event.is_set()
    program.start(0)
    assert event.wait(30)
    assert sender.writer.get_free_count() >= room // 2
    assert ids(receiver.messages(room)) == list(range(room))


# what is sent


@pytest.mark.conforms("X3-23")
def test_only_data_can_be_sent(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0)
    program.start(1)
    kinds = (vci.CAN_MSGTYPE_INFO, vci.CAN_MSGTYPE_ERROR, vci.CAN_MSGTYPE_STATUS, 200)
    sender.send(*(message(1, type=kind) for kind in kinds))
    sender.send(message(2))
    assert receiver.message().msg_id == 2
    assert sender.counts().refused == len(kinds)


@pytest.mark.conforms("X4-15", "X4-17")
@pytest.mark.parametrize(
    ("ex_mode", "through"),
    [
        (vci.CAN_EXMODE_DISABLED, {1}),
        (vci.CAN_EXMODE_EXTDATA, {1, 2, 3}),
        (vci.CAN_EXMODE_FASTDATA, {1, 2, 4}),
        (vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA, {1, 2, 3, 4, 5}),
    ],
)
def test_extended_modes_allow_extended_messages(program: Program, ex_mode: int, through: set[int]) -> None:
    sender, receiver = program.port(0), program.port(1)
    program.start(0, ex_mode=ex_mode)
    program.start(1, ex_mode=ex_mode)
    sender.send(
        message(1, b"classic!"),
        message(2, b"fd", edl=1),
        message(3, bytes(12), edl=1),
        message(4, b"fast", edl=1, fdr=1),
        message(5, bytes(64), edl=1, fdr=1),
        message(6),
    )
    found = receiver.messages(len(through) + 1)
    assert ids(found) == sorted(through | {6})
    assert sender.counts().refused == 5 - len(through)


@pytest.mark.conforms("X4-16")
@pytest.mark.parametrize(
    ("dlc", "length"), [(8, 8), (9, 12), (10, 16), (11, 20), (12, 24), (13, 32), (14, 48), (15, 64)]
)
def test_long_messages(program: Program, dlc: int, length: int) -> None:
    sender, receiver = program.port(0), program.port(1)
    ex_mode = vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA
    program.start(0, ex_mode=ex_mode)
    program.start(1, ex_mode=ex_mode)
    data = bytes(range(length))
    sender.send(message(0x55, data, edl=1, fdr=1))
    found = receiver.message()
    info = found.msg_info
    assert (found.data, info.dlc, info.edl, info.fdr, info.esi) == (data, dlc, 1, 1, 0)


@pytest.mark.conforms("X4-16")
def test_rtr_means_nothing_with_edl_or_fdr(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    ex_mode = vci.CAN_EXMODE_EXTDATA | vci.CAN_EXMODE_FASTDATA
    program.start(0, ex_mode=ex_mode)
    program.start(1, ex_mode=ex_mode)
    sender.send(message(1, b"ab", rtr=1, edl=1), message(2, b"cd", rtr=1, fdr=1))
    for found, data in zip(receiver.messages(2), (b"ab", b"cd"), strict=True):
        assert (found.data, found.msg_info.rtr, found.msg_info.edl) == (data, 0, 1)


@pytest.mark.conforms("X3-25", "X4-28")
def test_a_message_can_wait_for_its_time(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    sender.send(message(1), vci.CanMsg2(time=5, msg_id=2), vci.CanMsg2(time=20, msg_id=3), message(4))
    program.start(1)
    program.start(0)
    times = [one.time for one in receiver.messages(4)]
    gaps = [later - earlier for earlier, later in itertools.pairwise(times)]
    frame_us = gaps[2] + TICK_US
    for gap, ticks in zip(gaps, (5, 20), strict=False):
        assert ticks * DELAY_TICK_US <= gap <= ticks * DELAY_TICK_US + frame_us


@pytest.mark.conforms("X3-25", "X4-28")
def test_a_message_cannot_wait_too_long(program: Program) -> None:
    sender, receiver = program.port(0), program.port(1)
    caps = program.open(vci.IID_ICanSocket2).get_capabilities()
    assert caps.dtx_max_ticks == LONGEST_DELAY
    assert caps.dtx_divisor * 1_000_000 == DELAY_TICK_US * caps.dtx_clk_freq
    program.start(0)
    program.start(1)
    sender.send(vci.CanMsg2(time=LONGEST_DELAY + 1, msg_id=1), message(2))
    assert receiver.message().msg_id == 2
    assert sender.counts().refused == 1


@pytest.mark.conforms("X4-24")
def test_single_shot_is_given_up_after_a_lost_arbitration(virtual: Virtual) -> None:
    program = virtual.program
    loser, winner, receiver = program.port(0), program.port(1), program.port(0, "HW000002")
    for line, board in ((0, "HW000001"), (1, "HW000001"), (0, "HW000002")):
        program.start(line, board)
    loser.send(message(0x200, ssm=1), message(0x300))
    winner.send(message(0x100))
    assert ids(receiver.messages(2)) == [0x100, 0x300]
    counts = loser.counts()
    assert (counts.sent, counts.delivered, counts.aborted, counts.refused) == (2, 1, 1, 0)


@pytest.mark.conforms("X4-24")
def test_without_single_shot_it_is_tried_again(virtual: Virtual) -> None:
    program = virtual.program
    loser, winner, receiver = program.port(0), program.port(1), program.port(0, "HW000002")
    for line, board in ((0, "HW000001"), (1, "HW000001"), (0, "HW000002")):
        program.start(line, board)
    loser.send(message(0x200))
    winner.send(message(0x100))
    assert ids(receiver.messages(2)) == [0x100, 0x200]


@pytest.mark.conforms("X4-24")
def test_single_shot_is_given_up_after_an_error_which_is_reported(program: Program) -> None:
    """Nobody acknowledges: the line is alone."""
    port = program.port(0)
    both = vci.CAN_OPMODE_STANDARD | vci.CAN_OPMODE_EXTENDED
    program.start(0, op_mode=both | vci.CAN_OPMODE_ERRFRAME)
    port.send(message(0x200, ssm=1))
    error = port.message(vci.CAN_MSGTYPE_ERROR)
    assert error.ab_data[0] == vci.CAN_ERROR_ACK
    receiver = program.port(1)
    program.start(1)
    port.send(message(0x201))
    assert receiver.message().msg_id == 0x201
    assert port.counts().aborted == 1


@pytest.mark.conforms("X4-25")
def test_high_priority_overtakes_what_is_in_the_controller_but_nothing_in_a_fifo(virtual: Virtual) -> None:
    program = virtual.program
    plain, urgent, receiver = program.port(0), program.port(0), program.port(1)
    program.start(0)
    program.start(1)
    plain.send(*(message(0x100 + k) for k in range(3)))
    urgent.send(message(0x700, hpm=1))
    found = ids(receiver.messages(4))
    assert found.index(0x700) <= 1
    plain.send(*(message(0x110 + k) for k in range(5)), message(0x7FF, hpm=1))
    found = ids(receiver.messages(6))
    assert found.index(0x7FF) >= 4
    assert [one for one in found if one != 0x7FF] == list(range(0x110, 0x115))


# messages come back


@pytest.mark.conforms("X3-24", "X4-26")
def test_self_reception_comes_once_the_message_was_sent(program: Program) -> None:
    sender = program.port(0, filter_mode=vci.CAN_FILTER_LOCK)
    program.start(0)
    sender.send(message(0x10, b"me", srr=1))
    assert sender.waiting() == [] or all(one.msg_info.type for one in sender.waiting())
    receiver = program.port(1)
    program.start(1)
    sent, echo = receiver.message(), sender.message()
    assert (echo.msg_id, echo.data, echo.msg_info.srr) == (0x10, b"me", 1)
    assert echo.msg_info.afc == vci.CAN_ACCEPT_ALWAYS
    assert sent.msg_info.srr == 0


@pytest.mark.conforms("X4-26", "X4-27")
def test_who_gets_self_receptions(program: Program, other_program: Program) -> None:
    sender, sibling = program.port(0), program.port(0)
    watcher = program.port(0, filter_mode=vci.CAN_FILTER_PASS | vci.CAN_FILTER_SRRA)
    deaf = program.port(0, filter_mode=vci.CAN_FILTER_LOCK | vci.CAN_FILTER_SRRA)
    old, old_elsewhere = program.old_port(0), other_program.old_port(0)
    receiver = program.port(1)
    program.start(0)
    program.start(1)
    sender.send(message(1), message(2, srr=1), message(3))
    receiver.messages(3)
    elsewhere = program.port(1)
    elsewhere.send(message(9))
    flags = [(one.msg_id, one.msg_info.srr) for one in sender.messages(2)]
    assert flags == [(2, 1), (9, 0)]
    assert [(one.msg_id, one.msg_info.srr) for one in watcher.messages(2)] == [(2, 0), (9, 0)]
    for channel in (old, old_elsewhere):
        assert [(one.msg_id, one.msg_info.srr) for one in channel.messages(2)] == [(2, 1), (9, 0)]
    assert ids(sibling.messages(1)) == [9]
    assert all(one.msg_info.type for one in deaf.waiting())


@pytest.mark.conforms("X4-26")
def test_with_srra_ones_own_come_back_marked(program: Program) -> None:
    port = program.port(0, filter_mode=vci.CAN_FILTER_LOCK | vci.CAN_FILTER_SRRA)
    program.port(1)
    program.start(0)
    program.start(1)
    port.send(message(5, srr=1))
    assert port.message().msg_info.srr == 1


# two kinds of channel


def test_old_and_new_channels_understand_each_other(program: Program) -> None:
    old, new = program.old_port(0), program.port(1)
    program.start(0)
    program.start(1)
    old.send(vci.CanMsg(msg_id=0x123, data=b"12345678"))
    assert new.message().data == b"12345678"
    new.send(message(0x124, b"87654321"))
    found = old.message()
    assert isinstance(found, vci.CanMsg)
    assert (found.msg_id, found.data) == (0x124, b"87654321")


# status


@pytest.mark.conforms("X4-37")
@pytest.mark.parametrize("kind", ["port", "old_port"])
def test_status(program: Program, kind: str) -> None:
    sender = program.port(0)
    receiver = getattr(program, kind)(1, rx=1, tx=1)
    program.start(0)
    program.start(1)
    status = receiver.channel.get_status()
    assert (status.activated, status.rx_overrun) == (True, False)
    socket = program.open(vci.IID_ICanSocket if kind == "old_port" else vci.IID_ICanSocket2, 1)
    until(  # the bus may have carried frames just before, and the load of its last second falls between two looks
        lambda: receiver.channel.get_status().line_status == socket.get_line_status()
    )
    waiting = receiver.reader.get_fill_count()
    half = receiver.reader.get_capacity() // 2 - waiting
    watcher = program.port(1, rx=1000)
    sender.send(*(message(number) for number in range(half)))
    watcher.messages(half)
    status = receiver.channel.get_status()
    assert status.rx_fifo_load == receiver.reader.get_fill_count() * 100 // receiver.reader.get_capacity()
    assert status.rx_fifo_load in (49, 50)
    receiver.channel.deactivate()
    assert not receiver.channel.get_status().activated


@pytest.mark.conforms("X4-37", "X4-32")
def test_overrun(program: Program) -> None:
    sender, receiver, watcher = program.port(0, tx=500), program.port(1, rx=1), program.port(1, rx=500)
    program.start(0)
    program.start(1)
    capacity = receiver.reader.get_capacity()
    sender.send(*(message(number) for number in range(capacity + 10)))
    watcher.messages(capacity + 10)
    assert receiver.channel.get_status().rx_overrun
    assert receiver.channel.get_status().rx_fifo_load == 100
    first = [one for one in receiver.waiting() if one.msg_info.type == vci.CAN_MSGTYPE_DATA]
    assert not any(one.msg_info.ovr for one in first)
    sender.send(message(0x700), message(0x701))
    after = receiver.messages(2)
    assert [(one.msg_id, one.msg_info.ovr) for one in after] == [(0x700, 1), (0x701, 0)]
    assert receiver.channel.get_status().rx_overrun


# who may do what


@pytest.mark.conforms("X4-39")
def test_a_channel_opens_its_lines_control(program: Program, other_program: Program) -> None:
    port = program.port(0)
    with port.channel.get_control() as control:
        assert isinstance(control, vci.CanControl2)
        control.init_line(program.init())
        for take in (port.channel.get_control, lambda: other_program.control(0)):
            with pytest.raises(vci.VciAccessDenied):
                take()
    other_program.control(0).start_line()
