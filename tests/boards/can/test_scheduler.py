"""The cyclic transmit list, seen from another node of the bus: what arrives, and exactly when."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue, BitTiming, Closed, Frame, LineError, Siblings, WrongState
from canwire.boards.can.channel import Channel
from canwire.boards.can.line import Line
from canwire.boards.can.scheduler import CyclicList, CyclicState, Increment
from canwire.boards.catalogue import ideal_line, plug
from canwire.bus.can.bus import CanBus
from canwire.drivers.driver import LineSettings
from canwire.timeline import NEVER, Timeline
from canwire.values.record import CONFIRM, HIGH_PRIORITY, SELF_RECEPTION, SINGLE_SHOT
from tests.cases import each
from tests.effort import examples

pytestmark = pytest.mark.core

TICK_NS = 1_000_000
MAX_TICKS = 24  # what the manual says dwCmsMaxTicks holds
NOMINAL = BitTiming.for_bit_rate(1_000_000, clock_hz=80_000_000)
DATA = BitTiming.for_bit_rate(5_000_000, clock_hz=80_000_000)
EMPTY, BUSY, DONE = CyclicState.EMPTY, CyclicState.BUSY, CyclicState.DONE
OWN, OTHERS = Siblings.OTHERS_AND_OWN, Siblings.OTHERS


class Bench:
    """A cyclic list on one line, and a node that writes down what the bus carries."""

    def __init__(
        self, *, fd: bool = True, listen_only: bool = False, on_bus: bool = True, max_ticks: int = MAX_TICKS
    ) -> None:
        self.timeline = Timeline()
        self.bus = CanBus(self.timeline)
        self.line = self.node("sender", fd=fd, listen_only=listen_only, start=on_bus)
        self.listener = Channel(4096, 0)
        self.node("listener").open(self.listener)
        self.list = CyclicList(self.line, self.timeline, TICK_NS, max_ticks)

    def node(self, name: str, *, fd: bool = True, listen_only: bool = False, start: bool = True) -> Line:
        line = ideal_line(name, self.timeline)
        plug(line, self.bus)
        assert line.driver is not None
        line.driver.configure(LineSettings(NOMINAL, DATA if fd else None, listen_only=listen_only))
        if start:
            line.driver.start(0, integrated=True)
        return line

    def started(self, *cycles: int, count: int = 0) -> list[int]:
        """Objects with these cycles, their index as identifier, started."""
        added = [self.list.add(Frame(k), cycle) for k, cycle in enumerate(cycles)]
        for index in added:
            self.list.start(index, count)
        return added

    def run_to(self, tick: float) -> None:
        """To just before the end of a tick (of a list resumed at 0), whose frame has arrived by then."""
        self.timeline.run_until(round((tick + 1) * TICK_NS) - 1)

    def arrived(self) -> list[Frame]:
        return self.listener.receive.take_frames(4096)

    def ticks(self) -> dict[int, list[int]]:
        """By identifier the ticks whose frames have arrived, each to the nanosecond; takes them."""
        found: dict[int, list[int]] = {}
        for frame in self.arrived():
            tick, rest = divmod(frame.timestamp_ns, TICK_NS)
            assert rest == duration_ns(frame)
            found.setdefault(frame.id, []).append(tick)
        return found


@cache
def duration_ns(frame: Frame) -> int:
    """How long a frame takes, sent at 0 on a bus at rest."""
    bench = Bench()
    channel = bench.line.open(Channel(1, 1, frames=False))
    bench.line.send(channel, frame)
    bench.timeline.run_until_idle(TICK_NS)
    return bench.arrived()[0].timestamp_ns


@dataclass
class Wish:
    """One object of `expected`: what it wants from tick `start` on."""

    cycle: int
    start: int = 0


def expected(wishes: list[Wish], last: int) -> dict[int, list[int]]:
    """The rule by itself: each object in turn puts its occurrences, in order, into the first free slots."""
    taken: set[int] = set()
    slots: dict[int, list[int]] = {}
    for k, wish in enumerate(wishes):
        for ideal in range(wish.start + wish.cycle, last + 1, wish.cycle):
            slot = next(tick for tick in range(ideal, 2 * last + 1000) if tick not in taken)
            taken.add(slot)
            if slot <= last:
                slots.setdefault(k, []).append(slot)
    return slots


ANY_CYCLE = st.integers(1, 40)


@st.composite
def cycle_sets(draw: st.DrawFn, cycles: st.SearchStrategy[int] = ANY_CYCLE) -> list[int]:
    """1 to 16 cycles whose 1/cycle sum up to 1 at most."""
    kept: list[int] = []
    for cycle in draw(st.lists(cycles, min_size=1, max_size=24)):
        if len(kept) < CyclicList.SLOTS and sum(Fraction(1, other) for other in [*kept, cycle]) <= 1:
            kept.append(cycle)
    return kept


# slots


@pytest.mark.conforms("X3-30")
def test_cycles_2_and_3_as_in_the_manual() -> None:
    bench = Bench()
    bench.started(2, 3)
    bench.list.resume()
    bench.run_to(21)
    assert bench.ticks() == {0: [2, 4, 6, 8, 10, 12, 14, 16, 18, 20], 1: [3, 7, 9, 13, 15, 19, 21]}
    assert bench.list.late == 3  # 6, 12 and 18 were taken
    assert bench.list.skipped == 0


@pytest.mark.conforms("X3-30")
def test_a_slot_begins_on_the_nanosecond() -> None:
    """Identifier 0x555 without data: 44 bits and a stuffed one, 1 us each."""
    bench = Bench()
    bench.timeline.run_until(12_345)
    bench.list.start(bench.list.add(Frame(0x555), 5))
    bench.list.resume()
    bench.run_to(10)
    assert [frame.timestamp_ns - 12_345 for frame in bench.arrived()] == [5_045_000, 10_045_000]


@pytest.mark.conforms("X3-30")
def test_cycle_1_alone_fills_every_slot_and_the_list() -> None:
    bench = Bench()
    bench.started(1)
    with pytest.raises(BadValue, match=r"cycle 24: the sum of 1/cycle would be 25/24"):
        bench.list.add(Frame(1), 24)
    bench.list.resume()
    bench.run_to(50)
    assert bench.ticks() == {0: list(range(1, 51))}


@pytest.mark.conforms("X3-30")
def test_the_load_rule_counts_every_object_of_the_list_exactly() -> None:
    bench = Bench()
    half, third, sixth = (bench.list.add(Frame(1), cycle) for cycle in (2, 3, 6))
    with pytest.raises(BadValue, match="25/24"):
        bench.list.add(Frame(1), 24)
    bench.list.start(sixth, 1)
    bench.list.stop(sixth)
    with pytest.raises(BadValue, match="25/24"):
        bench.list.add(Frame(1), 24)
    bench.list.remove(sixth)
    assert bench.list.add(Frame(1), 24) == sixth
    bench.list.remove(half)
    assert bench.list.add(Frame(1), 24) == half
    assert third == 1


@pytest.mark.conforms("X3-30")
@each("cycle", [0, -1, 25, 2.0, "2"])
def test_a_cycle_has_1_to_max_ticks(cycle: int) -> None:
    bench = Bench()
    with pytest.raises(BadValue, match=r"cycle .*from 1 to 24 ticks"):
        bench.list.add(Frame(1), cycle)
    assert bench.list.add(Frame(1), 24) == 0


@pytest.mark.conforms("X3-30")
@examples(60)
@given(cycle_sets(), st.data())
def test_slots_of_any_cycles(cycles: list[int], data: st.DataObject) -> None:
    """One object a tick, each in the slot that the rule gives it, whatever was added after it."""
    last = 150
    bench = Bench(max_ticks=40)
    bench.started(*cycles)
    bench.list.resume()
    bench.run_to(last)
    slots = bench.ticks()
    used = [tick for ticks in slots.values() for tick in ticks]
    assert len(used) == len(set(used))
    assert slots == expected([Wish(cycle) for cycle in cycles], last)
    late = sum(
        tick != cycle * (turn + 1)
        for index, cycle in enumerate(cycles)
        for turn, tick in enumerate(slots.get(index, []))
    )
    assert (bench.list.late, bench.list.skipped) == (late, 0)
    behind = [last // cycle - len(slots.get(index, [])) for index, cycle in enumerate(cycles)]
    assert min(behind) >= 0
    assert sum(behind) < len(cycles)

    first = data.draw(st.integers(1, len(cycles)))
    fewer = Bench(max_ticks=40)
    fewer.started(*cycles[:first])
    fewer.list.resume()
    fewer.run_to(last)
    assert fewer.ticks() == {index: ticks for index, ticks in slots.items() if index < first}


@pytest.mark.conforms("X3-30")
@examples(60)
@given(cycle_sets(st.sampled_from([1, 2, 3, 4, 5, 6, 8, 10, 12, 20, 24, 30, 40])))
def test_nothing_is_lost_over_a_long_window(cycles: list[int]) -> None:
    """Just before all cycles meet, in tick 240, each object has been sent as often as its cycle fits."""
    bench = Bench(max_ticks=40)
    bench.started(*cycles)
    bench.list.resume()
    bench.run_to(239)
    slots = bench.ticks()
    assert [len(slots.get(index, [])) for index in range(len(cycles))] == [239 // cycle for cycle in cycles]


@pytest.mark.conforms("X3-30")
@examples(40)
@given(cycle_sets(), st.data())
def test_objects_started_in_different_ticks(cycles: list[int], data: st.DataObject) -> None:
    """From within a tick too: the slots count from the tick in which `start` came."""
    last = 100
    starts = [data.draw(st.integers(0, 50)) for _ in cycles]
    bench = Bench(max_ticks=40)
    added = [bench.list.add(Frame(k), cycle) for k, cycle in enumerate(cycles)]
    bench.list.resume()
    for tick, index in sorted(zip(starts, added, strict=True)):
        bench.timeline.run_until(tick * TICK_NS + data.draw(st.sampled_from([0, 1, TICK_NS // 2])))
        bench.list.start(index)
    bench.run_to(last)
    assert bench.ticks() == expected([Wish(*wish) for wish in zip(cycles, starts, strict=True)], last)


def test_a_freed_index_comes_last_in_the_order_of_adding() -> None:
    bench = Bench()
    bench.started(4, 4)
    bench.list.remove(0)
    assert bench.list.add(Frame(2), 4) == 0
    bench.list.start(0)
    bench.list.resume()
    bench.run_to(9)
    assert bench.ticks() == {1: [4, 8], 2: [5, 9]}


# idle, start, stop, resume, suspend, reset


@pytest.mark.conforms("X3-32")
def test_stopped_after_opening_and_objects_idle_until_started() -> None:
    bench = Bench()
    idle = bench.list.add(Frame(7), 2)
    started = bench.list.add(Frame(8), 2)
    bench.list.start(started)
    assert not bench.list.running
    bench.run_to(10)
    assert bench.arrived() == []
    bench.list.resume()
    assert bench.list.running
    bench.run_to(20)
    assert {frame.id for frame in bench.arrived()} == {8}
    bench.list.start(idle)
    bench.run_to(30)
    assert {frame.id for frame in bench.arrived()} == {7, 8}


@pytest.mark.conforms("X3-32")
def test_resume_starts_all_in_the_same_tick_however_long_ago_they_were_started() -> None:
    bench = Bench()
    for index, cycle in enumerate((3, 4, 6)):
        bench.list.start(bench.list.add(Frame(index), cycle))
        bench.timeline.run_until((7 * index + 1) * TICK_NS)
    bench.list.resume()
    now = bench.timeline.now_ns // TICK_NS
    bench.run_to(now + 6)
    assert bench.ticks() == {0: [now + 3, now + 6], 1: [now + 4]}
    bench.run_to(now + 8)
    assert bench.ticks() == {2: [now + 7], 1: [now + 8]}


@pytest.mark.conforms("X3-32")
def test_suspend_stops_all_and_resume_begins_anew_together() -> None:
    bench = Bench()
    bench.started(2, 3)
    bench.list.resume()
    bench.run_to(4)
    assert bench.ticks() == {0: [2, 4], 1: [3]}
    bench.list.suspend()
    bench.list.suspend()
    assert not bench.list.running
    assert bench.timeline.next_ns() == NEVER
    bench.run_to(100)
    assert bench.ticks() == {}
    bench.timeline.run_until(200 * TICK_NS)
    bench.list.resume()
    bench.run_to(209)
    assert bench.ticks() == {0: [202, 204, 206, 208], 1: [203, 207, 209]}


@pytest.mark.conforms("X3-32")
def test_a_second_resume_changes_nothing() -> None:
    bench = Bench()
    bench.started(4)
    bench.list.resume()
    bench.run_to(2)
    bench.list.resume()
    bench.run_to(9)
    assert bench.ticks() == {0: [4, 8]}


@pytest.mark.conforms("X3-32")
def test_stop_one_of_two_and_start_it_again() -> None:
    bench = Bench()
    first, second = bench.started(2, 4)
    bench.list.resume()
    bench.run_to(5)
    bench.list.stop(first)
    bench.run_to(9)
    assert bench.ticks() == {first: [2, 4], second: [5, 8]}
    bench.list.start(first)  # within tick 9
    bench.timeline.run_until(10 * TICK_NS)
    bench.list.start(second)  # anew, in tick 10
    bench.run_to(15)
    assert bench.ticks() == {first: [11, 13, 15], second: [14]}


@pytest.mark.conforms("X3-32")
def test_reset_stops_and_empties() -> None:
    bench = Bench()
    bench.started(1)
    bench.list.resume()
    bench.run_to(3)
    bench.list.reset()
    assert not bench.list.running
    assert bench.list.states() == (EMPTY,) * 16
    with pytest.raises(BadValue, match="nothing at index 0"):
        bench.list.start(0)
    bench.run_to(10)
    assert bench.ticks() == {0: [1, 2, 3]}
    assert bench.started(2) == [0]
    bench.run_to(20)
    assert bench.ticks() == {}


@pytest.mark.conforms("X3-32")
def test_no_timer_but_for_the_next_slot_in_use_and_none_that_keeps_the_timeline_busy() -> None:
    bench = Bench()
    started, _ = bench.list.add(Frame(1), 24), bench.list.add(Frame(2), 2)
    bench.list.resume()
    assert bench.timeline.next_ns() == NEVER
    bench.list.start(started)
    assert bench.timeline.next_ns() == 24 * TICK_NS
    assert bench.timeline.idle()
    bench.run_to(24)
    assert bench.timeline.next_ns() == 48 * TICK_NS
    bench.list.stop(started)
    assert bench.timeline.next_ns() == NEVER
    bench.list.start(started)
    bench.list.remove(started)
    assert bench.timeline.next_ns() == NEVER


def test_closed() -> None:
    bench = Bench(on_bus=False)
    (index,) = bench.started(1)
    bench.list.resume()
    bench.run_to(10)
    bench.list.close()
    bench.list.close()
    refused: list[Callable[[], object]] = [
        bench.list.resume,
        bench.list.suspend,
        bench.list.reset,
        lambda: bench.list.add(Frame(1), 2),
        lambda: bench.list.start(index),
        lambda: bench.list.stop(index),
        lambda: bench.list.remove(index),
    ]
    for call in refused:
        with pytest.raises(Closed, match="cyclic transmit list of sender is closed"):
            call()
    assert (bench.list.running, bench.list.states()) == (False, (EMPTY,) * 16)
    assert bench.list.skipped == 0  # nothing is due while the line is stopped
    assert bench.timeline.next_ns() == NEVER
    assert bench.line.driver is not None
    bench.line.driver.start(bench.timeline.now_ns)
    bench.run_to(20)
    assert bench.arrived() == []


# states and counts


@pytest.mark.conforms("X3-33", "X4-41")
def test_states_and_task() -> None:
    bench = Bench()
    once, endless, idle, stopped = (bench.list.add(Frame(k), 8) for k in range(4))
    assert bench.list.states() == (EMPTY,) * 16
    bench.list.start(once, 1)
    bench.list.start(endless)
    bench.list.start(stopped)
    bench.list.stop(stopped)
    assert bench.list.states() == (BUSY, BUSY, EMPTY, DONE, *(EMPTY,) * 12)
    bench.list.resume()
    assert bench.list.running
    bench.run_to(7)
    assert bench.list.states()[once] == BUSY
    bench.run_to(8)
    assert bench.list.states() == (DONE, BUSY, EMPTY, DONE, *(EMPTY,) * 12)
    bench.list.suspend()
    assert not bench.list.running
    assert bench.list.states() == (DONE, BUSY, EMPTY, DONE, *(EMPTY,) * 12)
    bench.list.start(once)
    bench.list.remove(endless)
    assert bench.list.states() == (BUSY, EMPTY, EMPTY, DONE, *(EMPTY,) * 12)
    assert idle == 2


def test_the_numbers_are_vcis() -> None:
    assert {state.name: int(state) for state in CyclicState} == {"EMPTY": 0, "BUSY": 1, "DONE": 2}
    assert {mode.name: int(mode) for mode in Increment} == {"NONE": 0, "ID": 1, "BYTE": 2, "WORD": 3}


@pytest.mark.conforms("X4-41")
def test_a_count_of_transmissions_then_done() -> None:
    bench = Bench()
    counted, endless = bench.started(3, 5)
    bench.list.start(counted, 3)
    bench.list.resume()
    bench.run_to(100)
    assert bench.ticks() == {counted: [3, 6, 9], endless: list(range(5, 101, 5))}
    assert bench.list.states()[:2] == (DONE, BUSY)
    bench.list.start(counted, 1)  # in tick 100
    bench.run_to(110)
    assert bench.ticks() == {counted: [103], endless: [105, 110]}


@pytest.mark.conforms("X4-41")
def test_a_count_goes_on_after_suspend() -> None:
    bench = Bench()
    bench.started(2, count=5)
    bench.list.resume()
    bench.run_to(4)
    bench.list.suspend()
    bench.list.resume()
    bench.run_to(40)
    assert len(bench.arrived()) == 5
    assert bench.list.states()[0] == DONE


@pytest.mark.conforms("X4-41")
def test_the_largest_count() -> None:
    bench = Bench()
    (index,) = bench.started(1, count=65_535)
    bench.list.resume()
    bench.run_to(65_534)
    assert bench.list.states()[index] == BUSY
    bench.run_to(65_600)
    assert bench.list.states()[index] == DONE
    assert bench.listener.accepted == 65_535


@pytest.mark.conforms("X4-41")
@each("count", [-1, 65_536, 1.5])
def test_counts_that_cannot_be(count: int) -> None:
    bench = Bench()
    (index,) = bench.started(2)
    bench.list.stop(index)
    with pytest.raises(BadValue, match=r"count .*65535"):
        bench.list.start(index, count)
    assert bench.list.states()[index] == DONE


# increments


def sent(frame: Frame, increment: Increment, *, byte_index: int = 0, times: int = 3) -> list[Frame]:
    """The frames of an incremented object as they arrive."""
    bench = Bench()
    index = bench.list.add(frame, 1, increment=increment, byte_index=byte_index)
    bench.list.start(index, times)
    bench.list.resume()
    bench.run_to(times)
    return bench.arrived()


@pytest.mark.conforms("X3-31")
@each(
    ("ids", "data", "kind"),
    [
        ([0x7FE, 0x7FF, 0], b"\1", {}),
        ([0x7FF, 0, 1], b"", {"remote": True, "dlc": 12}),
        ([0x7FF, 0x800, 0x801], b"", {"extended": True}),
        ([0x1FFFFFFE, 0x1FFFFFFF, 0], b"\1", {"extended": True}),
        ([0x7FE, 0x7FF, 0], bytes(8), {"dlc": 11}),
        ([0x7FE, 0x7FF, 0], bytes(12), {"fd": True, "bit_rate_switch": True}),
    ],
)
def test_identifiers_wrap(ids: list[int], data: bytes, kind: dict[str, Any]) -> None:
    frames = [Frame(id, data, **kind) for id in ids]
    assert sent(frames[0], Increment.ID) == frames


@pytest.mark.conforms("X3-31")
@each(
    ("increment", "byte_index", "data"),
    [
        (Increment.NONE, 0, ["01fe00", "01fe00", "01fe00"]),
        (Increment.NONE, 99, ["01fe00", "01fe00", "01fe00"]),
        (Increment.BYTE, 0, ["01fe00", "02fe00", "03fe00"]),
        (Increment.BYTE, 1, ["01fe00", "01ff00", "010000"]),
        (Increment.BYTE, 2, ["01fe00", "01fe01", "01fe02"]),
        (Increment.WORD, 1, ["01fe00", "01ff00", "010001"]),
        (Increment.WORD, 0, ["fffe77", "00ff77", "01ff77"]),
        (Increment.WORD, 0, ["feff77", "ffff77", "000077"]),
        (Increment.WORD, 1, ["77ffff", "770000", "770100"]),
    ],
)
def test_bytes_and_words_wrap(increment: Increment, byte_index: int, data: list[str]) -> None:
    frames = [Frame(0x55, bytes.fromhex(text)) for text in data]
    assert sent(frames[0], increment, byte_index=byte_index) == frames


@pytest.mark.conforms("X3-31")
def test_a_number_goes_on_where_it_was_when_the_object_starts_again() -> None:
    bench = Bench()
    index = bench.list.add(Frame(1, b"\x10"), 2, increment=Increment.BYTE)
    bench.list.resume()
    for tick in (10, 20):
        bench.list.start(index, 2)
        bench.run_to(tick)
    assert [frame.data[0] for frame in bench.arrived()] == [0x10, 0x11, 0x12, 0x13]


@pytest.mark.conforms("X4-42")
def test_fd_frames_of_64_bytes_with_a_number_at_the_end() -> None:
    first = Frame(0x1ABCDEF, bytes(62) + b"\xff\x41", extended=True, fd=True, bit_rate_switch=True)
    arrived = sent(first, Increment.WORD, byte_index=62, times=2)
    assert arrived[0] == first
    assert arrived[1].data == bytes(63) + b"\x42"
    assert (arrived[1].fd, arrived[1].bit_rate_switch, arrived[1].extended) == (True, True, True)


@pytest.mark.conforms("X4-42")
@each("frame", [Frame(1, bytes(1)), Frame(1, bytes(8)), Frame(1, bytes(64), fd=True)])
@each("increment", [Increment.BYTE, Increment.WORD])
def test_limits_of_the_index(frame: Frame, increment: Increment) -> None:
    bench = Bench()
    last = len(frame.data) - (1 if increment is Increment.BYTE else 2)
    for byte_index in (-1, last + 1):
        with pytest.raises(BadValue, match="byte_index" if last >= 0 else "1 bytes of data"):
            bench.list.add(frame, 2, increment=increment, byte_index=byte_index)
    assert bench.list.states() == (EMPTY,) * 16
    if last >= 0:
        assert bench.list.add(frame, 2, increment=increment, byte_index=last) == 0


@pytest.mark.conforms("X4-42")
@each("frame", [Frame(1), Frame(1, remote=True, dlc=8), Frame(1, fd=True)])
@each("increment", [Increment.BYTE, Increment.WORD])
def test_no_number_without_data(frame: Frame, increment: Increment) -> None:
    with pytest.raises(BadValue, match="0 bytes of data"):
        Bench().list.add(frame, 2, increment=increment)


# what the list and the line refuse


def test_sixteen_objects() -> None:
    bench = Bench()
    assert [bench.list.add(Frame(1), 16) for _ in range(16)] == list(range(16))
    with pytest.raises(LineError, match="full"):
        bench.list.add(Frame(1), 24)
    bench.list.remove(5)
    bench.list.remove(3)
    assert [bench.list.add(Frame(1), 16) for _ in range(2)] == [3, 5]


@each("index", [-1, 1, 16])
def test_an_index_with_nothing_there(index: int) -> None:
    bench = Bench()
    bench.list.add(Frame(1), 2)
    for call in (bench.list.start, bench.list.stop, bench.list.remove):
        with pytest.raises(BadValue, match=f"nothing at index {index} "):
            call(index)


@each(("tick_ns", "max_ticks"), [(0, 24), (-1, 24), (1000, 0), (1 << 60, 24)])
def test_ticks_that_cannot_be(tick_ns: int, max_ticks: int) -> None:
    bench = Bench()
    with pytest.raises(BadValue, match="ticks of"):
        CyclicList(bench.line, bench.timeline, tick_ns, max_ticks)


def test_flags_and_increments_that_cannot_be() -> None:
    bench = Bench()
    with pytest.raises(BadValue, match="flags 0x2000"):
        bench.list.add(Frame(1), 2, flags=CONFIRM)
    with pytest.raises(BadValue, match="increment 4"):
        bench.list.add(Frame(1, b"\0"), 2, increment=4)  # type: ignore[arg-type]


def test_what_the_line_cannot_send_is_refused_early() -> None:
    with pytest.raises(LineError, match="FD"):
        Bench(fd=False).list.add(Frame(1, fd=True), 2)
    with pytest.raises(LineError, match="listen-only"):
        Bench(listen_only=True).list.add(Frame(1), 2)


def test_what_the_line_refuses_later_is_counted_and_hurts_nobody() -> None:
    bench = Bench()
    index = bench.list.add(Frame(1, b"\0"), 2, increment=Increment.BYTE)
    bench.list.start(index, 3)
    bench.list.resume()
    bench.run_to(2)
    assert bench.line.driver is not None
    bench.line.driver.configure(LineSettings(NOMINAL, DATA, listen_only=True))
    bench.run_to(9)
    assert (bench.list.skipped, bench.list.states()[index]) == (3, BUSY)
    bench.line.driver.configure(LineSettings(NOMINAL, DATA))
    bench.run_to(20)
    assert [frame.data[0] for frame in bench.arrived()] == [0, 1, 2]
    assert (bench.list.skipped, bench.list.states()[index]) == (3, DONE)


def test_a_full_queue_skips_and_counts() -> None:
    """On a shorted bus the controller keeps the first frame, and the queue holds 64."""
    bench = Bench()
    bench.bus.short(True)
    index = bench.list.add(Frame(0), 1)
    bench.list.start(index)
    bench.list.resume()
    bench.run_to(100)
    assert bench.list.skipped == 100 - 64 - 1


def test_a_stopped_line_is_sent_nothing_of_the_time_it_stood() -> None:
    bench = Bench(on_bus=False)
    index = bench.list.add(Frame(0), 1, increment=Increment.ID)
    bench.list.start(index, 100)
    bench.list.resume()
    bench.run_to(80)
    assert bench.line.driver is not None
    bench.line.driver.start(bench.timeline.now_ns)
    bench.run_to(200)
    assert [frame.id for frame in bench.arrived()] == list(range(100))
    assert (bench.list.skipped, bench.list.states()[index]) == (0, DONE)


def test_flags_reach_the_line() -> None:
    """High priority goes before the node's own queue, self-reception comes back to its other channels."""
    bench = Bench()
    own = bench.line.open(Channel(64, 64))
    index = bench.list.add(Frame(0x7FF), 1, flags=HIGH_PRIORITY | SELF_RECEPTION | SINGLE_SHOT)
    bench.list.start(index, 1)
    bench.list.resume()
    bench.timeline.run_until(TICK_NS - 10_000)
    for _ in range(5):
        bench.line.send(own, Frame(1, bytes(8)))
    bench.run_to(5)
    assert [frame.id for frame in bench.arrived()] == [1, 0x7FF, 1, 1, 1, 1]
    assert [(frame.id, frame.self_received) for frame in own.receive.take_frames(9)] == [(0x7FF, True)]


# anything in any order


class Plain:
    """The list once more, tick by tick: every object's wishes in a queue, the oldest object served first."""

    def __init__(self) -> None:
        self.objects: dict[int, dict[str, int]] = {}
        self.running = False
        self.tick = 0
        self.log: list[int] = []

    def add(self, name: int, cycle: int) -> int | None:
        load = sum((Fraction(1, o["cycle"]) for o in self.objects.values()), Fraction(1, cycle))
        if load > 1 or len(self.objects) == 16:
            return None
        index = min(set(range(16)) - set(self.objects))
        self.objects[index] = {"name": name, "cycle": cycle, "state": EMPTY, "left": 0, "from": 0, "wants": 0}
        return index

    def start(self, index: int, count: int) -> None:
        self.objects[index].update({"state": BUSY, "left": count or -1, "from": self.tick, "wants": 0})

    def resume(self) -> None:
        if not self.running:
            self.running = True
            for o in self.objects.values():
                o.update({"from": self.tick, "wants": 0})

    def pass_tick(self) -> None:
        self.tick += 1
        busy = [o for o in self.objects.values() if self.running and o["state"] == BUSY]
        for o in busy:
            o["wants"] += (self.tick - o["from"]) % o["cycle"] == 0
        served = next((o for o in busy if o["wants"]), None)
        self.log.append(-1 if served is None else served["name"])
        if served is not None:
            served["wants"] -= 1
            served["left"] -= 1
            if served["left"] == 0:
                served["state"] = DONE


STEPS = st.one_of(
    st.tuples(st.just("add"), st.integers(1, 12)),
    st.tuples(st.just("start"), st.integers(0, 4), st.integers(0, 4)),
    st.tuples(st.just("start"), st.integers(0, 4), st.just(0)),
    st.tuples(st.sampled_from(["stop", "remove"]), st.integers(0, 4)),
    st.tuples(st.sampled_from(["resume", "resume", "suspend", "reset"])),
    st.tuples(st.just("pass"), st.integers(1, 20)),
)


def drive(bench: Bench, plain: Plain, steps: list[tuple[str | int, ...]]) -> None:
    """The same steps for both; identifiers number the objects added."""
    for name, (verb, *values) in enumerate(steps):
        take(bench, plain, name, str(verb), [int(value) for value in values])
        states = [plain.objects[k]["state"] if k in plain.objects else EMPTY for k in range(16)]
        assert bench.list.states() == tuple(states)
        assert bench.list.running == plain.running


def take(bench: Bench, plain: Plain, name: int, verb: str, values: list[int]) -> None:
    if verb == "pass":
        for _ in range(values[0]):
            plain.pass_tick()
        bench.timeline.run_until(plain.tick * TICK_NS)
    elif verb == "add":
        index = plain.add(name, values[0])
        if index is None:
            with pytest.raises((BadValue, LineError)):
                bench.list.add(Frame(name), values[0])
        else:
            assert bench.list.add(Frame(name), values[0]) == index
    elif values:
        if values[0] not in plain.objects:
            with pytest.raises(BadValue):
                getattr(bench.list, verb)(*values)
            return
        getattr(bench.list, verb)(*values)
        if verb == "start":
            plain.start(*values)
        elif verb == "stop":
            plain.objects[values[0]]["state"] = DONE
        else:
            del plain.objects[values[0]]
    else:
        getattr(bench.list, verb)()
        if verb == "resume":
            plain.resume()
        else:
            plain.running = False
        if verb == "reset":
            plain.objects.clear()


@pytest.mark.conforms("X3-30", "X3-32", "X4-41")
@examples(100)
@given(st.lists(st.integers(2, 12), max_size=5), st.lists(STEPS, max_size=40))
def test_any_steps_give_what_the_plain_list_gives_and_the_same_twice(
    cycles: list[int], steps: list[tuple[str | int, ...]]
) -> None:
    """All steps come on a tick's very start, after the tick's own frame was sent."""
    arrivals = []
    for _ in range(2):
        bench, plain = Bench(), Plain()
        drive(bench, plain, [("resume",), *(("add", cycle) for cycle in cycles), *steps])
        bench.list.suspend()
        bench.timeline.run_until_idle(bench.timeline.now_ns + TICK_NS)
        arrived = bench.arrived()
        slots = {frame.timestamp_ns // TICK_NS: frame.id for frame in arrived}
        assert len(slots) == len(arrived)
        assert slots == {tick: name for tick, name in enumerate(plain.log, 1) if name >= 0}
        arrivals.append([(frame.timestamp_ns, frame.id) for frame in arrived])
    assert arrivals[0] == arrivals[1]


def test_objects_in_turn() -> None:
    bench = Bench()
    added = [bench.list.add(Frame(k), 6) for k in range(3)]
    with pytest.raises(WrongState, match="stopped"):
        bench.list.start_in_turn(added, [0, 0, 0], 2)
    bench.list.resume()
    bench.run_to(3)
    bench.list.start_in_turn(added, [2, 1, 0], 2)
    bench.run_to(22)
    assert bench.ticks() == {0: [4, 10], 1: [6], 2: [8, 14, 20]}
    assert bench.list.states()[:3] == (DONE, DONE, BUSY)
    for counts, step in (([0], 1), ([0, 0, -1], 1), ([0, 0, 0], -1)):
        with pytest.raises(BadValue, match="counts"):
            bench.list.start_in_turn(added, counts, step)


def test_another_frame_in_the_same_ticks() -> None:
    bench = Bench(fd=False)
    (index,) = bench.started(3)
    bench.list.resume()
    bench.run_to(4)
    bench.list.replace(index, Frame(9, b"\1"))
    bench.run_to(10)
    assert bench.ticks() == {0: [3], 9: [6, 9]}
    with pytest.raises(LineError, match="FD"):
        bench.list.replace(index, Frame(9, fd=True))
    grows = bench.list.add(Frame(1), 3, increment=Increment.ID)
    with pytest.raises(BadValue, match="grows"):
        bench.list.replace(grows, Frame(9))


def test_on_behalf_of_a_channel() -> None:
    """Its frames are that channel's own; what sent for somebody is used again."""
    bench = Bench()
    owner, other = (bench.line.open(Channel(64, 1, siblings=int(kind))) for kind in (OWN, OTHERS))
    before = len(bench.line.channels())
    bench.list.resume()
    for _ in range(3):
        index = bench.list.add(Frame(1), 1, owner=owner)
        bench.list.start(index, 2)
        bench.run_to(bench.timeline.now_ns // TICK_NS + 4)
        bench.list.remove(index)
        for channel, marked in ((owner, True), (other, False)):
            assert [frame.self_received for frame in channel.receive.take_frames(9)] == [marked] * 2
    index = bench.list.add(Frame(1), 1, owner=other)
    bench.list.start(index, 1)
    bench.run_to(bench.timeline.now_ns // TICK_NS + 4)
    assert not other.receive.fill()
    assert [frame.self_received for frame in owner.receive.take_frames(9)] == [False]
    assert len(bench.line.channels()) == before + 1
