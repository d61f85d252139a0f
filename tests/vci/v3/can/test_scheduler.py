"""ICanScheduler: the cyclic list. A tick of the simulated boards is 100 us."""

from __future__ import annotations

import dataclasses
from typing import Any

import pytest

from canwire import vci
from canwire.boards import catalogue
from canwire.boards.description import Feature
from canwire.vci import v3
from tests.vci.programs import Program
from tests.vci.v3.programs import NetProgram

TICK_US = 100
EMPTY, BUSY, DONE = v3.CanCyclicTXStatus
FAST = v3.CanBitrate.CIA_1000_KBIT  # a message without data fits in a tick


@pytest.fixture
def rig(virtual_net: NetProgram) -> Any:
    """A cyclic list on a started line, and a channel on another line."""
    virtual_net.start(0, bitrate=FAST)
    virtual_net.start(1, bitrate=FAST)
    return Rig(virtual_net)


class Rig:
    def __init__(self, program: Program) -> None:
        self.hub = program.hub
        self.receiver = program.port(1, rx=1000)
        self.scheduler: v3.CanScheduler = program.open(v3.CanScheduler)

    def run(self, ticks: float) -> list[v3.CanMessage]:
        """What is heard in so many ticks."""
        self.hub.run_for(ticks * TICK_US * 1e-6)
        return self.receiver.waiting()

    def add(self, *messages: v3.CanCyclicTXMsg, start: int | None = 0) -> None:
        for one in messages:
            self.scheduler.add_message(one)
            if start is not None:
                self.scheduler.start_message(one, start)


def ids(messages: list[v3.CanMessage]) -> list[int]:
    return [one.identifier for one in messages]


# who has it, and what fits


@pytest.mark.conforms("X3-29")
def test_one_program_at_a_time_has_the_list(net: NetProgram, other_net: NetProgram) -> None:
    scheduler = net.open(v3.CanScheduler)
    with pytest.raises(v3.VciException) as raised:
        other_net.open(v3.CanScheduler)
    assert raised.value.code == vci.VCI_E_ACCESSDENIED
    scheduler.dispose()
    other_net.open(v3.CanScheduler)


@pytest.mark.conforms("X3-29")
def test_a_board_without_a_list_says_so(virtual_net: NetProgram, monkeypatch: pytest.MonkeyPatch) -> None:
    kind = catalogue.KINDS["usb-to-can"]
    features = kind.connectors[0].capabilities.features & ~Feature.SCHEDULER
    connectors = tuple(
        one._replace(capabilities=dataclasses.replace(one.capabilities, features=features))
        for one in kind.connectors
    )
    plain = dataclasses.replace(kind, name="plain", connectors=connectors)
    monkeypatch.setitem(catalogue.KINDS, "plain", plain)
    virtual_net.hub.plug("plain", "HW777777")
    with pytest.raises(v3.NotImplementedException) as raised:
        virtual_net.open(v3.CanScheduler, board="HW777777")
    assert not isinstance(raised.value, v3.VciException)
    assert not virtual_net.open(v3.CanSocket, board="HW777777").supports_cyclic_message_scheduler


@pytest.mark.conforms("X3-29")
def test_the_list_holds_16_messages(net: NetProgram, cyclic: Any) -> None:
    scheduler = net.open(v3.CanScheduler)
    messages = [cyclic(one, cycle_ticks=100) for one in range(17)]
    for one in messages[:16]:
        scheduler.add_message(one)
    with pytest.raises(v3.VciException):
        scheduler.add_message(messages[16])
    scheduler.remove_message(messages[3])
    scheduler.add_message(messages[16])


@pytest.mark.conforms("X3-30")
@pytest.mark.parametrize(
    ("cycles", "fits"), [([1], True), ([1, 1000], False), ([2, 3], True), ([2, 3, 5], False)]
)
def test_the_sum_of_the_frequencies_is_limited(
    net: NetProgram, cyclic: Any, cycles: list[int], fits: bool
) -> None:
    scheduler = net.open(v3.CanScheduler)
    *before, last = [cyclic(1, cycle_ticks=ticks) for ticks in cycles]
    for one in before:
        scheduler.add_message(one)
    if fits:
        scheduler.add_message(last)
    else:
        with pytest.raises(v3.ArgumentException):
            scheduler.add_message(last)


@pytest.mark.conforms("X3-30")
def test_cycles_are_limited(net: NetProgram, cyclic: Any) -> None:
    scheduler = net.open(v3.CanScheduler)
    with pytest.raises(v3.ArgumentException):
        scheduler.add_message(cyclic(1, cycle_ticks=0))
    scheduler.add_message(cyclic(1, cycle_ticks=scheduler.max_cyclic_msg_ticks))


@pytest.mark.finding("vendor 6")
@pytest.mark.parametrize(
    "wrong",
    [
        {"identifier": 0x800},
        {"identifier": 0x20000000, "extended_frame_format": True},
        {"frame_type": v3.CanMsgFrameType.INFO},
        {"auto_increment_mode": 2, "auto_increment_index": 2},
        {"auto_increment_mode": 3, "auto_increment_index": 1},
    ],
)
def test_messages_that_no_line_can_send(net: NetProgram, cyclic: Any, wrong: dict[str, Any]) -> None:
    made = cyclic(1, b"ab", cycle_ticks=10, **wrong)
    with pytest.raises(v3.ArgumentException):
        net.open(v3.CanScheduler).add_message(made)


def test_a_message_is_on_the_list_once_and_on_no_other(net: NetProgram, cyclic: Any) -> None:
    scheduler = net.open(v3.CanScheduler)
    one, stranger = cyclic(1, cycle_ticks=10), cyclic(1, cycle_ticks=10)
    scheduler.add_message(one)
    for use, message in (
        (scheduler.add_message, one),
        (scheduler.start_message, stranger),
        (scheduler.stop_message, stranger),
        (scheduler.remove_message, stranger),
    ):
        with pytest.raises(v3.ArgumentException):
            use(message)


# what is sent


@pytest.mark.conforms("X3-30")
def test_collisions_take_the_next_free_slot(rig: Any, cyclic: Any) -> None:
    rig.add(cyclic(2, cycle_ticks=2), cyclic(3, cycle_ticks=3))
    rig.scheduler.resume()
    heard = rig.run(21)
    origin = heard[0].time_stamp - 2 * TICK_US
    slots = {which: [] for which in (2, 3)}
    for one in heard:
        slots[one.identifier].append((one.time_stamp - origin + TICK_US // 4) // TICK_US)
    assert slots[2][:9] == [2, 4, 6, 8, 10, 12, 14, 16, 18]
    assert slots[3][:6] == [3, 7, 9, 13, 15, 19]


@pytest.mark.conforms("X3-32")
def test_a_new_message_is_idle(rig: Any, cyclic: Any) -> None:
    idle, started = cyclic(1, cycle_ticks=5), cyclic(2, cycle_ticks=5)
    rig.add(idle, start=None)
    rig.add(started)
    assert rig.run(20) == []
    rig.scheduler.resume()
    assert set(ids(rig.run(20.9))) == {2}
    rig.scheduler.start_message(idle)
    assert set(ids(rig.run(20))) == {1, 2}
    rig.scheduler.stop_message(started)
    rig.run(1)
    assert set(ids(rig.run(20))) == {1}


@pytest.mark.conforms("X3-32")
def test_resume_starts_all_and_suspend_stops_all(rig: Any, cyclic: Any) -> None:
    rig.add(*[cyclic(one, cycle_ticks=10) for one in range(3)])
    rig.scheduler.resume()
    heard = rig.run(13.9)
    assert ids(heard) == [0, 1, 2]
    assert heard[2].time_stamp - heard[0].time_stamp == pytest.approx(2 * TICK_US, abs=10)
    rig.scheduler.suspend()
    assert rig.run(100) == []
    rig.scheduler.resume()
    assert ids(rig.run(13.9)) == [0, 1, 2]


@pytest.mark.conforms("X3-32")
def test_a_count_ends_by_itself(rig: Any, cyclic: Any) -> None:
    rig.add(cyclic(1, cycle_ticks=4), start=3)
    rig.scheduler.resume()
    assert ids(rig.run(100)) == [1, 1, 1]


@pytest.mark.conforms("X3-32")
def test_reset_stops_and_empties_the_list(rig: Any, cyclic: Any) -> None:
    messages = [cyclic(one, cycle_ticks=32) for one in range(16)]
    rig.add(*messages)
    rig.scheduler.resume()
    rig.scheduler.update_status()
    rig.scheduler.reset()
    assert {one.status for one in messages} == {EMPTY}
    assert rig.run(100) == []
    rig.scheduler.update_status()
    assert rig.scheduler.task_status is v3.CanCyclicTXTaskStatus.STOPPED
    rig.add(*messages)
    rig.scheduler.resume()
    assert len(rig.run(60)) == 16


@pytest.mark.conforms("X3-31")
@pytest.mark.parametrize(("extended", "highest"), [(False, 0x7FF), (True, 0x1FFFFFFF)])
def test_the_identifier_counts_up(rig: Any, cyclic: Any, extended: bool, highest: int) -> None:
    counting = cyclic(highest - 1, cycle_ticks=5, extended_frame_format=extended)
    counting.auto_increment_mode = v3.CanCyclicTXIncMode.INC_1
    rig.add(counting, start=4)
    rig.scheduler.resume()
    assert ids(rig.run(100)) == [highest - 1, highest, 0, 1]


@pytest.mark.conforms("X3-31")
def test_a_byte_counts_up(rig: Any, cyclic: Any) -> None:
    counting = cyclic(1, b"\x11\xfe\x33", cycle_ticks=5, auto_increment_index=1)
    counting.auto_increment_mode = v3.CanCyclicTXIncMode.INC_8
    rig.add(counting, start=3)
    rig.scheduler.resume()
    assert [bytes(one)[:3] for one in rig.run(100)] == [b"\x11\xfe\x33", b"\x11\xff\x33", b"\x11\x00\x33"]


@pytest.mark.conforms("X3-31")
def test_two_bytes_count_up_the_low_one_first(rig: Any, cyclic: Any) -> None:
    counting = cyclic(1, b"\xfe\x12\xff\xff", cycle_ticks=5, auto_increment_index=0)
    counting.auto_increment_mode = v3.CanCyclicTXIncMode.INC_16
    other = cyclic(2, b"\xfe\x12\xff\xff", cycle_ticks=5, auto_increment_index=2)
    other.auto_increment_mode = v3.CanCyclicTXIncMode.INC_16
    rig.add(counting, other, start=3)
    rig.scheduler.resume()
    heard = rig.run(100)
    low = [bytes(one)[:2] for one in heard if one.identifier == 1]
    high = [bytes(one)[2:4] for one in heard if one.identifier == 2]
    assert low == [b"\xfe\x12", b"\xff\x12", b"\x00\x13"]
    assert high == [b"\xff\xff", b"\x00\x00", b"\x01\x00"]


# states


@pytest.mark.finding("vendor 7")
@pytest.mark.conforms("X3-33")
def test_states_change_with_update_status_only(rig: Any, cyclic: Any) -> None:
    endless, twice, idle = (cyclic(one, cycle_ticks=5) for one in range(3))
    rig.add(endless)
    rig.add(twice, start=2)
    rig.add(idle, start=None)
    rig.scheduler.resume()
    rig.run(50)

    def states() -> list[Any]:
        return [one.status for one in (endless, twice, idle)] + [rig.scheduler.task_status]

    stopped, running = v3.CanCyclicTXTaskStatus
    assert states() == [EMPTY, EMPTY, EMPTY, stopped]
    rig.scheduler.update_status()
    assert states() == [BUSY, DONE, EMPTY, running]
    rig.scheduler.stop_message(endless)
    rig.scheduler.suspend()
    assert states() == [BUSY, DONE, EMPTY, running]
    rig.scheduler.update_status()
    assert states() == [DONE, DONE, EMPTY, stopped]
    rig.scheduler.remove_message(endless)
    assert endless.status is EMPTY


def test_the_list_takes_a_copy(rig: Any, cyclic: Any) -> None:
    changing = cyclic(1, cycle_ticks=5)
    rig.add(changing)
    changing.identifier = 2
    rig.scheduler.resume()
    assert set(ids(rig.run(20.9))) == {1}
    rig.scheduler.remove_message(changing)
    rig.add(changing)
    assert set(ids(rig.run(20.9))) == {2}


@pytest.mark.parametrize("count", [-1, 65_536])
def test_counts_that_are_none(net: NetProgram, cyclic: Any, count: int) -> None:
    scheduler, made = net.open(v3.CanScheduler), cyclic(1, cycle_ticks=5)
    scheduler.add_message(made)
    with pytest.raises(v3.ArgumentOutOfRangeException):
        scheduler.start_message(made, count)


@pytest.mark.finding("vendor 9")
def test_a_disposed_list_is_gone(rig: Any, cyclic: Any) -> None:
    rig.add(cyclic(1, cycle_ticks=5))
    rig.scheduler.resume()
    rig.scheduler.dispose()
    rig.run(1)
    assert rig.run(50) == []
    with pytest.raises(v3.ObjectDisposedException):
        rig.scheduler.resume()
    rig.scheduler.update_status()
