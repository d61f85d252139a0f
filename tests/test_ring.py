"""The contract of a ring in both homes: one object in this process, or two ends of memory behind a descriptor."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

import canwire
from canwire.errors import BadValue, CanwireError
from canwire.platform import PORTABLE, EventDescriptor, close_descriptors, create_memory, map_memory
from canwire.ring import HEADER_SIZE, MAGIC, Ring, ring_size, rounded_capacity
from canwire.values.frame import Frame, record_of_frame
from canwire.values.record import RECORD_SIZE, record_dtype
from tests.cases import each
from tests.descriptors import open_descriptors
from tests.effort import examples, scaled

pytestmark = pytest.mark.core

TOP = 2**64 - 1
WORDS = {"head": 8, "lost": 9, "tail": 16, "wanted": 17, "free_wanted": 24}  # as ring.py draws them


def record(number: int) -> bytes:
    """A record that holds its number in time, identifier and data."""
    return record_of_frame(frame(number))


def frame(number: int) -> Frame:
    return Frame(number & 0x7FF, number.to_bytes(8, "little"), timestamp_ns=number)


def array(*numbers: int) -> numpy.ndarray:
    return numpy.frombuffer(b"".join(map(record, numbers)), record_dtype())


class Ends:
    """Both ends of one ring, of a given capacity."""

    def __init__(
        self, home: str, capacity: int, *, exact: bool = False, record_size: int = RECORD_SIZE
    ) -> None:
        self.home = home
        if home == "process":
            self.producer = self.consumer = Ring(capacity, exact=exact, record_size=record_size)
        else:
            memory = memory_for(capacity, record_size)
            self.producer, self.consumer = (
                Ring.over(memory, capacity, exact=exact, record_size=record_size) for _ in range(2)
            )
            close_descriptors(memory)

    def fill_up(self, *numbers: int) -> None:
        for number in numbers:
            assert self.producer.put_bytes(record(number))

    def take(self) -> int | None:
        got = self.consumer.take_bytes()
        return None if got is None else int.from_bytes(got[:8], "little")

    def take_all(self) -> list[int]:
        return [found.timestamp_ns for found in self.consumer.take_frames(1 << 20)]

    def close(self) -> None:
        self.consumer.close()
        self.producer.close()


def memory_for(capacity: int, record_size: int = RECORD_SIZE) -> int:
    """Descriptor of memory in which such a ring fits."""
    return create_memory(ring_size(rounded_capacity(capacity), record_size))


Make = Callable[..., Ends]


@pytest.fixture(params=["process", "shared"])
def make(request: pytest.FixtureRequest) -> Iterator[Make]:
    made: list[Ends] = []

    def one(capacity: int, **options: int) -> Ends:
        made.append(Ends(request.param, capacity, **options))
        return made[-1]

    yield one
    for ends in made:
        ends.close()


class TestOrder:
    def test_first_in_first_out(self, make: Make) -> None:
        ends = make(8)
        ends.fill_up(1, 2, 3)
        assert [ends.take() for _ in range(4)] == [1, 2, 3, None]

    def test_records_come_out_byte_by_byte(self, make: Make) -> None:
        ends = make(4)
        block = bytes(range(80))
        ends.producer.put_bytes(block)
        assert ends.consumer.take_bytes() == block

    @pytest.mark.parametrize("form", [bytes, bytearray, memoryview])
    def test_takes_any_bytes(self, make: Make, form: Callable[[bytes], bytes]) -> None:
        ends = make(4)
        ends.producer.put_bytes(form(record(7)))
        assert ends.take() == 7

    def test_a_record_with_a_time_and_a_mark_at_the_last(self, make: Make) -> None:
        ends = make(2)
        block = bytearray(range(80))
        put = [ends.producer.put_at(block, time_ns, 1 << 63) for time_ns in (5, 6, 7)]
        assert (put, ends.producer.lost) == ([True, True, False], 1)
        unmarked, marked = ends.consumer.take_bytes(), ends.consumer.take_bytes()
        assert unmarked == (5).to_bytes(8, "little") + block[8:]
        block[15] |= 0x80
        assert marked == (6).to_bytes(8, "little") + block[8:]

    @pytest.mark.parametrize("size", [0, 79, 81, 160])
    def test_other_sizes_have_no_time(self, make: Make, size: int) -> None:
        ends = make(4)
        with pytest.raises(BadValue, match=f"80 bytes, not {size}"):
            ends.producer.put_at(bytearray(size), 1, 0)
        assert ends.consumer.fill() == 0

    @pytest.mark.parametrize("size", [0, 79, 81, 160])
    def test_other_sizes_are_no_record(self, make: Make, size: int) -> None:
        ends = make(4)
        with pytest.raises(BadValue, match=f"80 bytes, not {size}"):
            ends.producer.put_bytes(bytes(size))
        assert ends.consumer.fill() == 0

    def test_many_times_around(self, make: Make) -> None:
        ends = make(4)
        for number in range(50):
            ends.fill_up(number, number + 100)
            assert [ends.take(), ends.take()] == [number, number + 100]

    def test_frames(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(1, 2, 3)
        first = ends.consumer.take_frame()
        assert first == frame(1)
        assert first is not None
        assert first.timestamp_ns == 1
        assert ends.consumer.take_frames(1) == [frame(2)]
        assert ends.consumer.take_frames(10) == [frame(3)]
        assert ends.consumer.take_frame() is None
        assert ends.consumer.take_frames(10) == []


class TestCapacity:
    @pytest.mark.parametrize(("asked", "got"), [(1, 1), (2, 2), (3, 4), (5, 8), (64, 64), (65, 128)])
    def test_rounds_up_to_a_power_of_two(self, make: Make, asked: int, got: int) -> None:
        ends = make(asked)
        assert ends.producer.capacity == ends.consumer.capacity == got
        ends.fill_up(*range(got))
        assert not ends.producer.put_bytes(record(got))
        assert ends.take_all() == list(range(got))

    def test_a_full_ring_counts_what_it_drops(self, make: Make) -> None:
        ends = make(2)
        ends.fill_up(1, 2)
        assert [ends.producer.put_bytes(record(number)) for number in (3, 4)] == [False, False]
        assert ends.producer.lost == ends.consumer.lost == 2
        assert ends.take() == 1
        ends.fill_up(5)
        assert ends.take_all() == [2, 5]
        assert ends.consumer.lost == 2

    def test_levels(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(1, 2, 3)
        ends.take()
        for end in (ends.producer, ends.consumer):
            assert (end.fill(), end.free(), end.written, end.taken, end.lost) == (2, 2, 3, 1, 0)

    @each("capacity", [0, -1, (1 << 24) + 1, 2.5, "8", None])
    def test_no_capacity(self, capacity: int) -> None:
        with pytest.raises(BadValue, match="capacity"):
            Ring(capacity)

    @pytest.mark.parametrize("capacity", [1, 2, 3, 5, 100])
    def test_exactly_as_many_as_asked_for(self, make: Make, capacity: int) -> None:
        ends = make(capacity, exact=True)
        assert ends.producer.capacity == ends.consumer.capacity == capacity
        for round in range(3):  # the slots behind the limit have their turn too
            numbers = range(round * capacity, (round + 1) * capacity)
            ends.fill_up(*numbers)
            assert (ends.consumer.fill(), ends.producer.free()) == (capacity, 0)
            assert not ends.producer.put_bytes(record(0))
            assert ends.producer.put_array(array(1, 2)) == 0
            assert not ends.producer.acquire_free(5)
            assert ends.take_all() == list(numbers)
        assert ends.consumer.lost == 3

    @each("capacity", [0, -1, (1 << 24) + 1, 2.5, "8", None])
    def test_no_exact_capacity(self, capacity: int) -> None:
        with pytest.raises(BadValue, match="capacity"):
            Ring(capacity, exact=True)

    @each("size", [24, HEADER_SIZE, ring_size(4), ring_size(8) - 1])
    def test_no_room_in_the_buffer(self, size: int) -> None:
        """Compiled, a ring larger than its buffer would write into somebody else's memory."""
        with pytest.raises(BadValue, match="buffer"):
            Ring(8, buffer=memoryview(bytearray(size)))

    def test_size(self) -> None:
        assert ring_size(16) == HEADER_SIZE + 16 * RECORD_SIZE


class TestBlocks:
    """acquire and release: the ring's own memory."""

    def test_nothing_is_copied(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(1, 2)
        one, other = (numpy.frombuffer(ends.consumer.acquire(1)[0], record_dtype()) for _ in range(2))
        assert numpy.shares_memory(one, other)
        del one, other

    def test_acquire_takes_nothing_until_released(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(1, 2, 3)
        assert [bytes(block) for block in ends.consumer.acquire(2)] == [record(1) + record(2)]
        assert ends.consumer.fill() == 3
        ends.consumer.release(2)
        assert ends.take_all() == [3]

    def test_two_blocks_around_the_end(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(1, 2, 3)
        ends.consumer.release(2)
        ends.fill_up(4, 5, 6)
        blocks = [bytes(block) for block in ends.consumer.acquire(100)]
        assert [len(block) // RECORD_SIZE for block in blocks] == [2, 2]
        assert b"".join(blocks) == b"".join(map(record, (3, 4, 5, 6)))
        ends.consumer.release(4)
        assert ends.consumer.fill() == 0

    def test_in_this_process_an_empty_ring_begins_again_at_its_first_record(self) -> None:
        ends = Ends("process", 4)
        for number in (10, 20, 30):
            ends.fill_up(number, number + 1, number + 2)
            (block,) = ends.consumer.acquire(100)
            assert bytes(block) == b"".join(map(record, (number, number + 1, number + 2)))
            ends.consumer.release(3)
        assert (ends.consumer.written, ends.consumer.taken) == (9, 9)
        assert len(ends.producer.acquire_free(100)) == 4 * RECORD_SIZE
        assert ends.producer.put_array(array(1, 2, 3, 4)) == 4
        assert len(ends.consumer.acquire(100)) == 1

    def test_an_empty_ring_has_no_blocks(self, make: Make) -> None:
        ends = make(4)
        assert ends.consumer.acquire(5) == []
        ends.fill_up(1)
        assert ends.consumer.acquire(0) == []


class TestArrays:
    def test_take(self, make: Make) -> None:
        ends = make(8)
        ends.fill_up(1, 2, 3)
        taken = ends.consumer.take_array(2)
        assert taken.dtype == record_dtype()
        assert taken.tobytes() == record(1) + record(2)
        assert ends.take_all() == [3]

    def test_take_around_the_end_and_keep(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(0, 0, 1)
        ends.consumer.release(2)
        ends.fill_up(2, 3, 4)
        taken = ends.consumer.take_array(100)
        ends.fill_up(5, 6, 7, 8)
        assert taken["time_ns"].tolist() == [1, 2, 3, 4]

    def test_take_nothing(self, make: Make) -> None:
        taken = make(4).consumer.take_array(3)
        assert (len(taken), taken.dtype) == (0, record_dtype())

    def test_put(self, make: Make) -> None:
        ends = make(4)
        assert ends.producer.put_array(array(1, 2, 3)) == 3
        assert [ends.take(), ends.take()] == [1, 2]
        assert ends.producer.put_array(array(4, 5, 6)) == 3  # around the end
        assert ends.consumer.take_bytes() == record(3)
        assert ends.take_all() == [4, 5, 6]

    def test_put_as_many_as_fit(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(1)
        assert ends.producer.put_array(array(2, 3, 4, 5, 6)) == 3
        assert ends.producer.put_array(array(7)) == 0
        assert ends.producer.lost == 0  # the caller still has them
        assert ends.take_all() == [1, 2, 3, 4]

    def test_put_nothing(self, make: Make) -> None:
        ends = make(4)
        assert ends.producer.put_array(array()) == 0
        assert ends.consumer.fill() == 0


class TestThresholds:
    @pytest.mark.parametrize("threshold", [1, 2, 3, 4])
    def test_the_listener_hears_each_crossing_once(self, make: Make, threshold: int) -> None:
        ends = make(4)
        heard: list[int] = []
        ends.producer.threshold = threshold
        ends.producer.listener = lambda: heard.append(ends.producer.fill())
        ends.fill_up(1, 2, 3, 4)
        assert heard == [threshold]
        ends.producer.put_bytes(record(5))  # lost
        assert heard == [threshold]
        ends.consumer.release(4)
        ends.fill_up(*range(threshold))
        assert heard == [threshold] * 2

    @pytest.mark.parametrize(
        ("threshold", "before", "put", "calls"),
        [(1, 0, 3, 1), (1, 1, 2, 0), (3, 0, 2, 0), (3, 0, 3, 1), (3, 2, 1, 1), (3, 1, 3, 1), (3, 3, 1, 0),
         (4, 3, 9, 1)],
    )  # fmt: skip
    def test_arrays_cross_too(self, make: Make, threshold: int, before: int, put: int, calls: int) -> None:
        ends = make(4)
        ends.fill_up(*range(before))
        heard: list[int] = []
        ends.producer.threshold = threshold
        ends.producer.listener = lambda: heard.append(ends.producer.fill())
        ends.producer.put_array(array(*range(put)))
        assert heard == [min(4, before + put)] * calls

    @pytest.mark.parametrize(
        ("threshold", "steps", "calls"),
        [
            (1, [1, 1, 1, 1], [1, 0, 0, 0]),
            (2, [1, 1, 1, 1], [0, 1, 0, 0]),
            (2, [3, 1], [1, 0]),
            (4, [3, 1], [0, 1]),
            (4, [4], [1]),
        ],
    )
    def test_the_free_listener_hears_each_crossing_once(
        self, make: Make, threshold: int, steps: list[int], calls: list[int]
    ) -> None:
        ends = make(4)
        ends.fill_up(1, 2, 3, 4)
        heard: list[int] = []
        ends.consumer.free_threshold = threshold
        ends.consumer.free_listener = lambda: heard.append(1)
        counted = []
        for step in steps:
            del heard[:]
            ends.consumer.release(step)
            counted.append(len(heard))
        assert counted == calls

    def test_every_way_of_taking_tells_the_free_listener(self, make: Make) -> None:
        ends = make(4)
        heard: list[int] = []
        ends.consumer.free_listener = lambda: heard.append(ends.consumer.free())
        for take in (
            ends.consumer.take_frame,
            ends.consumer.take_bytes,
            lambda: ends.consumer.take_frames(1),
            lambda: ends.consumer.take_array(1),
        ):
            ends.fill_up(*range(ends.producer.free()))
            take()
        assert heard == [1] * 4
        ends.producer.put_bytes(record(1))
        ends.consumer.clear()
        assert heard == [1] * 4 + [4]

    def test_a_listener_may_take(self, make: Make) -> None:
        ends = make(4)
        taken: list[int | None] = []
        ends.producer.listener = lambda: taken.append(ends.take())
        ends.fill_up(1, 2, 3)
        assert taken == [1, 2, 3]

    def test_what_a_listener_raises_comes_out(self, make: Make) -> None:
        def fail() -> None:
            raise LookupError("on purpose")

        ends = make(4)
        ends.producer.listener = fail
        with pytest.raises(LookupError, match="on purpose"):
            ends.producer.put_bytes(record(1))
        ends.producer.listener = None
        assert ends.take_all() == [1]


class TestClear:
    def test_drops_what_waits(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(1, 2, 3)
        assert ends.consumer.clear() == 3
        assert ends.consumer.clear() == 0
        assert (ends.consumer.fill(), ends.producer.free(), ends.consumer.lost) == (0, 4, 0)
        ends.fill_up(4)
        assert ends.take_all() == [4]


class TestSleep:
    def test_without_an_event_there_is_nothing_to_wait_on(self, make: Make) -> None:
        ends = make(4)
        with pytest.raises(CanwireError, match="event descriptor"):
            ends.consumer.sleep(0)
        with pytest.raises(CanwireError, match="event descriptor"):
            ends.producer.sleep_until_free(0)

    def test_returns_at_once_when_enough_is_there(self, make: Make) -> None:
        ends = make(4)
        with_events(ends)
        assert not ends.consumer.sleep(0)
        assert ends.producer.sleep_until_free(0)
        ends.fill_up(1, 2, 3, 4)
        assert ends.consumer.sleep(0)
        assert not ends.producer.sleep_until_free(0)

    def test_thresholds(self, make: Make) -> None:
        ends = make(4)
        with_events(ends)
        ends.consumer.threshold, ends.producer.free_threshold = 3, 2
        ends.fill_up(1, 2)
        assert not ends.consumer.sleep(0)
        ends.fill_up(3)
        assert ends.consumer.sleep(0)
        assert not ends.producer.sleep_until_free(0)
        ends.take()
        assert ends.producer.sleep_until_free(0)

    @pytest.mark.parametrize("way", ["sleep", "sleep_until_free"])
    def test_sleep_may_be_ended(self, make: Make, way: str) -> None:
        """By whoever signals the descriptor once there is nothing to wait for any more."""
        ends = make(2)
        with_events(ends)
        ends.consumer.threshold, ends.producer.free_threshold = 1, 2
        ends.fill_up(1)
        if way == "sleep":
            ends.take()
        end = ends.consumer if way == "sleep" else ends.producer
        over: list[bool] = []
        asked: list[bool] = []

        def ended() -> bool:
            asked.append(True)
            if len(asked) == 2:
                over.append(True)
            event = end.event if way == "sleep" else end.free_event
            event.signal()  # type: ignore[union-attr]
            return bool(over)

        assert getattr(end, way)(None, ended)
        assert len(asked) == 2

    def test_an_awake_consumer_costs_no_signal(self) -> None:
        ends = Ends("shared", 4)
        try:
            with_events(ends)
            ends.fill_up(1, 2)
            assert not ends.consumer.event.wait(0)  # type: ignore[union-attr]
            ends.take_all()
            assert not ends.producer.free_event.wait(0)  # type: ignore[union-attr]
        finally:
            ends.close()


def with_events(ends: Ends) -> None:
    events = EventDescriptor(), EventDescriptor()
    for end in (ends.producer, ends.consumer):
        end.event, end.free_event = events


class TestFreeBlocks:
    """acquire_free and commit: room in the ring's own memory."""

    def test_what_is_written_there_arrives_once_it_is_committed(self, make: Make) -> None:
        ends = make(4)
        room = ends.producer.acquire_free(2)
        room[:] = record(1) + record(2)
        assert ends.consumer.fill() == 0
        ends.producer.commit(1)
        assert ends.take_all() == [1]
        ends.producer.commit(1)
        assert ends.take_all() == [2]

    def test_only_what_lies_in_one_piece(self, make: Make) -> None:
        ends = make(4)
        ends.fill_up(1, 2, 3)
        ends.consumer.release(2)
        assert len(ends.producer.acquire_free(100)) == RECORD_SIZE
        ends.fill_up(4)
        assert len(ends.producer.acquire_free(100)) == 2 * RECORD_SIZE
        assert len(ends.producer.acquire_free(2)) == 2 * RECORD_SIZE
        assert len(ends.producer.acquire_free(0)) == 0
        assert len(ends.producer.acquire_free(-1)) == 0

    def test_a_full_ring_has_none(self, make: Make) -> None:
        ends = make(3, exact=True)
        ends.fill_up(1, 2, 3)
        assert len(ends.producer.acquire_free(5)) == 0
        assert ends.consumer.lost == 0  # nobody lost anything

    def test_an_exact_ring_gives_no_more_than_its_limit(self, make: Make) -> None:
        ends = make(5, exact=True)
        assert len(ends.producer.acquire_free(8)) == 5 * RECORD_SIZE
        ends.fill_up(1, 2)
        assert len(ends.producer.acquire_free(8)) == 3 * RECORD_SIZE

    @pytest.mark.parametrize(("threshold", "counts", "calls"), [(1, [2, 1], 1), (3, [1, 2], 1), (4, [3], 0)])
    def test_a_commit_tells_the_listener(
        self, make: Make, threshold: int, counts: list[int], calls: int
    ) -> None:
        ends = make(4)
        heard: list[int] = []
        ends.producer.threshold = threshold
        ends.producer.listener = lambda: heard.append(1)
        for count in counts:
            ends.producer.acquire_free(count)[:] = bytes(count * RECORD_SIZE)
            ends.producer.commit(count)
        assert heard == [1] * calls


class Bell:
    """Counts signals instead of waking anybody."""

    def __init__(self) -> None:
        self.rung = 0

    def signal(self) -> None:
        self.rung += 1

    def heard(self) -> int:
        """Signals since somebody asked last."""
        rung, self.rung = self.rung, 0
        return rung

    def wait_for(self, settled: Callable[[], bool], timeout: float | None, recheck: float | None) -> bool:
        return settled()


class Belled(Ends):
    """Two ends of shared memory, and a bell for each of them."""

    def __init__(self, capacity: int, *, exact: bool = False, record_size: int = RECORD_SIZE) -> None:
        super().__init__("shared", capacity, exact=exact, record_size=record_size)
        self.bell, self.free_bell = Bell(), Bell()
        for end in (self.producer, self.consumer):
            end.event, end.free_event = self.bell, self.free_bell


class TestArm:
    """A signal at the next write, or the next take, that leaves enough: exactly one, and none is lost."""

    def test_unarmed_there_is_no_signal(self) -> None:
        ends = Belled(4)
        ends.fill_up(1, 2)
        ends.take_all()
        assert (ends.bell.rung, ends.free_bell.rung) == (0, 0)

    def test_the_next_write_signals_once(self) -> None:
        ends = Belled(4)
        ends.consumer.arm()
        assert ends.bell.rung == 0
        ends.fill_up(1)
        assert ends.bell.rung == 1
        ends.fill_up(2, 3)
        assert ends.bell.rung == 1

    @pytest.mark.conforms("X4-13", "X3-22")
    def test_ten_queued_one_read_no_signal_until_the_next_write(self) -> None:
        """VCI V4 manual 4.1.1, threshold 1."""
        ends = Belled(16)
        ends.consumer.arm()
        ends.fill_up(*range(10))
        assert ends.bell.heard() == 1
        assert ends.take() == 0
        ends.consumer.arm()
        assert ends.bell.heard() == 0
        ends.fill_up(10)
        assert ends.bell.heard() == 1

    @pytest.mark.conforms("X4-13")
    @each(
        ("threshold", "filled", "writes"), [(3, 0, 3), (3, 1, 2), (3, 2, 1), (3, 3, 1), (3, 7, 1), (1, 0, 1)]
    )
    def test_the_write_that_reaches_the_threshold_or_any_above_it(
        self, threshold: int, filled: int, writes: int
    ) -> None:
        ends = Belled(8)
        ends.fill_up(*range(filled))
        ends.consumer.threshold = threshold
        assert ends.consumer.fill() == filled
        ends.consumer.arm()
        for number in range(writes):
            assert ends.bell.heard() == 0
            ends.fill_up(number)
        assert ends.bell.heard() == 1

    def test_many_at_once_signal_once(self) -> None:
        ends = Belled(8)
        ends.consumer.threshold = 2
        ends.consumer.arm()
        assert ends.producer.put_array(array(1, 2, 3, 4)) == 4
        assert ends.bell.heard() == 1
        ends.take_all()
        ends.consumer.arm()
        ends.producer.acquire_free(3)
        ends.producer.commit(1)
        assert ends.bell.heard() == 0
        ends.producer.commit(2)
        assert ends.bell.heard() == 1

    def test_what_is_written_between_looking_and_arming_signals_at_once(self) -> None:
        ends = Belled(4)
        assert ends.take() is None
        ends.fill_up(1)
        ends.consumer.arm()
        assert ends.bell.heard() == 1
        ends.fill_up(2)
        assert ends.bell.heard() == 0

    @pytest.mark.parametrize("threshold", [2, 3])
    def test_what_is_written_meanwhile_counts_towards_the_threshold(self, threshold: int) -> None:
        ends = Belled(4)
        ends.consumer.threshold = threshold
        assert ends.consumer.fill() == 0
        ends.fill_up(1)
        ends.consumer.arm()
        for number in range(1, threshold):
            assert ends.bell.heard() == 0
            ends.fill_up(number)
        assert ends.bell.heard() == 1

    def test_looking_again_is_what_takes_notice(self) -> None:
        ends = Belled(4)
        ends.consumer.arm()
        ends.fill_up(1)
        assert ends.bell.heard() == 1
        assert ends.consumer.fill() == 1
        ends.consumer.arm()
        assert ends.bell.heard() == 0

    @each("look", ["fill", "front", "take_frame", "take_frames", "acquire", "take_array"])
    def test_every_way_of_looking(self, look: str) -> None:
        ends = Belled(8)
        ends.fill_up(1, 2, 3)
        arguments = () if look in ("fill", "front", "take_frame") else (2,)
        getattr(ends.consumer, look)(*arguments)
        ends.consumer.arm()
        assert ends.bell.heard() == 0
        ends.fill_up(4)
        assert ends.bell.heard() == 1

    def test_arming_again_moves_it(self) -> None:
        ends = Belled(8)
        ends.consumer.threshold = 2
        ends.consumer.arm()
        ends.fill_up(1)
        ends.take_all()
        ends.consumer.arm()
        ends.fill_up(2)
        assert ends.bell.heard() == 0
        ends.fill_up(3)
        assert ends.bell.heard() == 1

    def test_once_leaves_it_where_it_is(self) -> None:
        ends = Belled(8)
        ends.consumer.arm_once()
        ends.consumer.threshold = 5
        ends.consumer.arm_once()
        ends.fill_up(1)
        assert ends.bell.heard() == 1
        ends.consumer.arm_once()  # it was used up: armed anew, for five
        ends.fill_up(2, 3, 4)
        assert ends.bell.heard() == 0
        ends.fill_up(5)
        assert ends.bell.heard() == 1

    def test_disarmed_there_is_none(self) -> None:
        ends = Belled(8)
        ends.consumer.arm()
        ends.consumer.disarm()
        ends.fill_up(1)
        assert ends.bell.heard() == 0

    def test_a_lost_record_is_no_write(self) -> None:
        ends = Belled(2)
        ends.fill_up(1, 2)
        ends.consumer.fill()
        ends.consumer.arm()
        assert not ends.producer.put_bytes(record(3))
        assert ends.bell.heard() == 0

    @pytest.mark.conforms("X3-22")
    @each(
        ("threshold", "filled", "takes"), [(1, 8, 1), (1, 3, 1), (3, 8, 3), (3, 6, 1), (3, 5, 1), (8, 2, 2)]
    )
    def test_the_writer_s_side(self, threshold: int, filled: int, takes: int) -> None:
        """Source: rulings.md 8: when a take brings the free count to the threshold or above."""
        ends = Belled(8)
        ends.producer.free_threshold = threshold
        ends.fill_up(*range(filled))
        ends.producer.arm_free()
        for _ in range(takes):
            assert ends.free_bell.heard() == 0
            ends.take()
        assert ends.free_bell.heard() == 1
        while ends.take() is not None:
            pass
        assert ends.free_bell.heard() == 0

    def test_what_is_taken_between_looking_and_arming_signals_at_once(self) -> None:
        ends = Belled(2)
        ends.fill_up(1, 2)
        assert ends.producer.free() == 0
        ends.take()
        ends.producer.arm_free()
        assert ends.free_bell.heard() == 1

    @each("start", [TOP, TOP - 1, TOP - 3, (1 << 63) - 1])
    def test_counters_that_wrap(self, start: int) -> None:
        memory = memory_for(8)
        words = map_memory(memory).cast("Q")
        words[WORDS["head"]] = words[WORDS["tail"]] = start
        producer, consumer = Ring.over(memory, 8), Ring.over(memory, 8)
        close_descriptors(memory)
        bell = Bell()
        producer.event = consumer.event = bell
        consumer.threshold = 2
        for number in range(6):
            assert consumer.take_frames(8) == ([frame(1), frame(2)] if number else [])
            consumer.arm()
            goal = (start + 2 * number + 2) & TOP
            producer.put_bytes(record(1))
            early = bell.heard()
            assert early == (goal == 0), number  # 0 is no goal: the one before it stands in
            producer.put_bytes(record(2))
            assert bell.heard() + early == 1, number

    @examples(100)
    @given(st.data())
    def test_a_consumer_and_a_producer_that_arm_after_everything_they_do(self, data: st.DataObject) -> None:
        """Against the rule by itself: armed, the next write that leaves enough signals, and disarms."""
        capacity = data.draw(st.integers(1, 9))
        ends = Belled(capacity, exact=True)
        ends.consumer.threshold = threshold = data.draw(st.integers(1, capacity))
        ends.producer.free_threshold = free_threshold = data.draw(st.integers(1, capacity))
        ends.consumer.arm()
        ends.producer.arm_free()
        armed = free_armed = True
        filled = 0
        for write, count in data.draw(st.lists(st.tuples(st.booleans(), st.integers(1, 5)), max_size=30)):
            signals = free_signals = 0
            if write:
                moved = ends.producer.put_array(array(*range(count)))
                filled += moved
                if moved and armed and filled >= threshold:
                    signals, armed = 1, False
                assert (ends.bell.heard(), ends.free_bell.heard()) == (signals, 0)
                ends.producer.arm_free()
                free_armed = True
            else:
                moved = len(ends.consumer.take_frames(count))
                filled -= moved
                if moved and free_armed and capacity - filled >= free_threshold:
                    free_signals, free_armed = 1, False
                assert (ends.bell.heard(), ends.free_bell.heard()) == (0, free_signals)
                ends.consumer.arm()
                armed = True
            assert (ends.bell.heard(), ends.free_bell.heard()) == (0, 0)
        ends.close()


class TestOtherSizes:
    """Elements that are no records: in and out as bytes only."""

    @pytest.mark.parametrize("size", [1, 7, 8, 16, 79, 81, 4096, 65535])
    def test_bytes_in_and_out(self, make: Make, size: int) -> None:
        ends = make(3, record_size=size)
        blocks = [bytes([k + 1]) * size for k in range(9)]
        for k in range(0, 9, 3):
            assert all(ends.producer.put_bytes(block) for block in blocks[k : k + 3])
            assert [ends.consumer.take_bytes() for _ in range(4)] == [*blocks[k : k + 3], None]

    @pytest.mark.parametrize("size", [1, 79, 81, 160])
    def test_bytes_of_another_size_are_refused(self, make: Make, size: int) -> None:
        ends = make(3, record_size=size)
        for wrong in (size - 1, size + 1, 80):
            with pytest.raises(BadValue, match=f"{size} bytes, not {wrong}"):
                ends.producer.put_bytes(bytes(wrong))
        assert ends.consumer.fill() == 0

    @pytest.mark.parametrize("size", [1, 8, 79, 160])
    def test_they_are_no_frames(self, make: Make, size: int) -> None:
        """Compiled, taking one for a frame would read behind the ring's memory."""
        ends = make(3, record_size=size)
        ends.producer.put_bytes(bytes(size))
        for call in (
            ends.consumer.take_frame,
            lambda: ends.consumer.take_frames(1),
            lambda: ends.consumer.take_array(1),
            lambda: ends.producer.put_array(array(1)),
        ):
            with pytest.raises(BadValue, match=f"elements of {size} bytes"):
                call()
        assert ends.consumer.fill() == 1

    def test_a_full_ring_counts_what_it_drops(self, make: Make) -> None:
        ends = make(2, exact=True, record_size=5)
        assert [ends.producer.put_bytes(b"12345") for _ in range(4)] == [True, True, False, False]
        assert ends.consumer.lost == 2

    @examples(100)
    @given(st.data())
    def test_they_do_what_a_list_does(self, data: st.DataObject) -> None:
        size = data.draw(st.integers(1, 200))
        capacity = data.draw(st.integers(1, 9))
        ends = Ends("shared", capacity, exact=data.draw(st.booleans()), record_size=size)
        capacity = ends.producer.capacity
        held: list[bytes] = []
        for step in data.draw(st.lists(st.sampled_from(["put", "fill", "take", "acquire"]), max_size=25)):
            if step == "put":
                element = data.draw(st.binary(min_size=size, max_size=size))
                assert ends.producer.put_bytes(element) == (len(held) < capacity)
                held = [*held, element][:capacity]
            elif step == "fill":
                room = ends.producer.acquire_free(3)
                count = len(room) // size
                elements = [data.draw(st.binary(min_size=size, max_size=size)) for _ in range(count)]
                room[:] = b"".join(elements)
                ends.producer.commit(count)
                held += elements
            elif step == "take":
                assert ends.consumer.take_bytes() == (held.pop(0) if held else None)
            else:
                blocks = ends.consumer.acquire(3)
                assert b"".join(blocks) == b"".join(held[:3])
                taken = sum(map(len, blocks)) // size
                ends.consumer.release(taken)
                del held[:taken]
            assert (ends.consumer.fill(), ends.producer.free()) == (len(held), capacity - len(held))
        ends.close()


class TestSharedMemory:
    """Memory behind a descriptor: whoever has it has the ring, and nobody can take the memory away."""

    def test_one_end_over_the_memory_of_another(self) -> None:
        memory = memory_for(5)
        one = Ring.over(memory, 5)
        one.put_bytes(record(1))
        one.put_bytes(record(2))
        other = Ring.over(memory, 5)
        close_descriptors(memory)
        assert (other.capacity, other.fill()) == (8, 2)
        assert other.take_bytes() == record(1)
        assert one.fill() == 1

    @each("size", [8, HEADER_SIZE, ring_size(4), ring_size(8) - 8])
    def test_memory_that_is_too_small(self, size: int) -> None:
        memory = create_memory(size)
        with pytest.raises(BadValue, match="buffer"):
            Ring.over(memory, 8)
        close_descriptors(memory)

    def test_the_header_tells_what_it_is(self) -> None:
        memory = memory_for(5, 24)
        Ring.over(memory, 5, exact=True, record_size=24)
        words = map_memory(memory).cast("Q")
        close_descriptors(memory)
        assert words[:4].tolist() == [MAGIC, 8, 24, 5]

    def test_it_is_zero_and_not_a_byte_larger_than_asked_for(self) -> None:
        memory = create_memory(1000)
        assert bytes(map_memory(memory)) == bytes(1000)
        close_descriptors(memory)

    @pytest.mark.skipif(PORTABLE, reason="of descriptors that travel between processes, which are Linux'")
    @pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="only Linux can seal memory")
    @pytest.mark.parametrize("size", [0, 1, ring_size(8) - 1, ring_size(8) + 1, 1 << 30])
    def test_nobody_resizes_it(self, size: int) -> None:
        """A mapping that reaches beyond its file kills the process that reads there."""
        memory = memory_for(8)
        ring = Ring.over(memory, 8)
        with pytest.raises(PermissionError):
            os.ftruncate(memory, size)
        copy = os.open(f"/proc/self/fd/{memory}", os.O_RDWR)
        with pytest.raises(PermissionError):
            os.ftruncate(copy, size)
        close_descriptors(memory, copy)
        assert ring.put_bytes(record(1))
        assert ring.take_bytes() == record(1)

    @pytest.mark.skipif(PORTABLE, reason="of descriptors that travel between processes, which are Linux'")
    @pytest.mark.skipif(not hasattr(os, "memfd_create"), reason="only Linux can seal memory")
    def test_nobody_takes_the_seals_off(self) -> None:
        import fcntl

        memory = memory_for(8)
        with pytest.raises(PermissionError):
            fcntl.fcntl(memory, fcntl.F_ADD_SEALS, 0)
        close_descriptors(memory)

    def test_a_closed_end_leaves_the_other_alone(self) -> None:
        ends = Ends("shared", 4)
        ends.fill_up(1)
        ends.consumer.close()
        ends.consumer.close()
        ends.fill_up(2)
        assert (ends.producer.fill(), ends.consumer.fill()) == (2, 0)
        assert ends.consumer.take_frame() is None
        assert ends.consumer.take_frames(5) == []
        ends.close()

    def test_a_closed_end_takes_nothing(self) -> None:
        ends = Ends("shared", 4)
        ends.producer.close()
        assert not ends.producer.put_bytes(record(1))
        assert (ends.producer.free(), ends.consumer.fill()) == (0, 0)
        assert ends.producer.put_array(array(1, 2)) == 0
        assert not ends.producer.acquire_free(1)
        assert ends.producer.clear() == 0
        ends.close()

    def test_blocks_outlive_their_end(self) -> None:
        ends = Ends("shared", 4)
        ends.fill_up(1, 2)
        blocks = ends.consumer.acquire(2)
        ends.close()
        assert b"".join(blocks) == record(1) + record(2)

    def test_a_ring_of_this_process_has_nothing_to_close(self) -> None:
        ring = Ring(4)
        ring.put_bytes(record(1))
        ring.close()
        assert ring.take_bytes() == record(1)

    @pytest.mark.skipif(PORTABLE, reason="of descriptors that travel between processes, which are Linux'")
    def test_no_descriptor_is_left(self) -> None:
        before = open_descriptors()
        for _ in range(3):
            ends = Ends("shared", 4)
            ends.fill_up(1)
            ends.close()
        assert open_descriptors() <= before


class RingMachine(RuleBasedStateMachine):
    """Any sequence of calls does what a deque does."""

    home = "process"

    @initialize(capacity=st.integers(1, 9), exact=st.booleans())
    def begin(self, capacity: int, exact: bool) -> None:
        self.ends = Ends(self.home, capacity, exact=exact)
        self.model: deque[int] = deque()
        self.capacity = self.ends.producer.capacity
        self.next = self.lost = self.taken = 0

    @rule(count=st.integers(1, 5))
    def put(self, count: int) -> None:
        for _ in range(count):
            fits = len(self.model) < self.capacity
            assert self.ends.producer.put_bytes(record(self.next)) == fits
            if fits:
                self.model.append(self.next)
            else:
                self.lost += 1
            self.next += 1

    @rule(count=st.integers(0, 12))
    def put_array(self, count: int) -> None:
        numbers = range(self.next, self.next + count)
        fitting = min(count, self.capacity - len(self.model))
        assert self.ends.producer.put_array(array(*numbers)) == fitting
        self.model.extend(numbers[:fitting])
        self.next += count

    @rule(limit=st.integers(0, 12), kept=st.integers(0, 3))
    def acquire_free(self, limit: int, kept: int) -> None:
        room = self.ends.producer.acquire_free(limit)
        given = len(room) // RECORD_SIZE
        assert given <= min(limit, self.capacity - len(self.model))
        assert given or limit == 0 or len(self.model) == self.capacity
        numbers = range(self.next, self.next + max(0, given - kept))
        room[: len(numbers) * RECORD_SIZE] = b"".join(map(record, numbers))
        room.release()
        self.ends.producer.commit(len(numbers))
        self.model.extend(numbers)
        self.next += len(numbers)

    @rule()
    def take_frame(self) -> None:
        got = self.ends.consumer.take_frame()
        assert ([] if got is None else [got]) == [frame(number) for number in self.forget(1)]

    @rule()
    def take_bytes(self) -> None:
        got = self.ends.consumer.take_bytes()
        assert ([] if got is None else [got]) == [record(number) for number in self.forget(1)]

    @rule(limit=st.integers(0, 12))
    def take_frames(self, limit: int) -> None:
        assert self.ends.consumer.take_frames(limit) == [frame(number) for number in self.forget(limit)]

    @rule(limit=st.integers(0, 12))
    def take_array(self, limit: int) -> None:
        got = self.ends.consumer.take_array(limit)
        assert got.tobytes() == b"".join(record(number) for number in self.forget(limit))

    @rule(limit=st.integers(0, 12), kept=st.integers(0, 3))
    def acquire(self, limit: int, kept: int) -> None:
        blocks = self.ends.consumer.acquire(limit)
        assert len(blocks) <= 2
        seen = b"".join(blocks)
        del blocks
        expected = list(self.model)[:limit]
        assert seen == b"".join(map(record, expected))
        released = max(0, len(expected) - kept)
        if released:
            self.ends.consumer.release(released)
        self.forget(released)

    @rule()
    def clear(self) -> None:
        assert self.ends.consumer.clear() == len(self.forget(len(self.model)))

    @invariant()
    def levels_agree(self) -> None:
        if hasattr(self, "ends"):
            for end in (self.ends.producer, self.ends.consumer):
                assert end.fill() == len(self.model)
                assert end.free() == self.capacity - len(self.model)
                assert (end.lost, end.taken) == (self.lost, self.taken)
                assert end.written == self.taken + len(self.model)

    def forget(self, limit: int) -> list[int]:
        gone = [self.model.popleft() for _ in range(min(limit, len(self.model)))]
        self.taken += len(gone)
        return gone

    def teardown(self) -> None:
        if hasattr(self, "ends"):
            self.ends.close()


class SharedRingMachine(RingMachine):
    """The same through two ends of shared memory."""

    home = "shared"


TestMachine = RingMachine.TestCase
TestMachine.settings = settings(max_examples=scaled(60), stateful_step_count=30)
TestSharedMachine = SharedRingMachine.TestCase
TestSharedMachine.settings = settings(max_examples=scaled(30), stateful_step_count=30)


COUNT = 20_000
PEER = """
import sys
from canwire.platform import EventDescriptor
from canwire.ring import Ring
from canwire.values.frame import Frame, record_of_frame

role = sys.argv[1]
capacity, count, memory, event, free_event = map(int, sys.argv[2:])
ring = Ring.over(memory, capacity)
ring.event, ring.free_event = EventDescriptor.adopt(event), EventDescriptor.adopt(free_event)
if role == "produce":
    for number in range(count):
        data = number.to_bytes(8, "little")
        block = record_of_frame(Frame(number & 0x7FF, data, timestamp_ns=number))
        while ring.free() == 0:
            ring.sleep_until_free(5.0)
        assert ring.put_bytes(block)
else:
    expected = 0
    while expected < count:
        taken = ring.take_frames(ring.capacity)
        for frame in taken:
            data = expected.to_bytes(8, "little")
            assert (frame.timestamp_ns, frame.id, frame.data) == (expected, expected & 0x7FF, data), frame
            expected += 1
        if not taken:
            ring.sleep(5.0)
ring.close()
"""


def environment() -> dict[str, str]:
    """Another process imports the very same canwire."""
    return os.environ | {"PYTHONPATH": str(Path(canwire.__file__).parents[1])}


class Watched(EventDescriptor):
    """An event that remembers how often somebody waited in vain."""

    def __init__(self) -> None:
        super().__init__()
        self.in_vain = 0

    def wait(self, timeout: float | None = None) -> bool:
        woken = super().wait(timeout)
        self.in_vain += not woken
        return woken


@pytest.mark.skipif(PORTABLE, reason="of descriptors that travel between processes, which are Linux'")
@pytest.mark.skipif(not hasattr(os, "eventfd"), reason="descriptors are passed by number: Linux")
class TestTwoProcesses:
    """20,000 records through a small ring, both sides asleep whenever they cannot go on."""

    @pytest.fixture
    def memory(self) -> Iterator[int]:
        memory = memory_for(64)
        yield memory
        close_descriptors(memory)

    @pytest.fixture
    def ring(self, memory: int) -> Iterator[Ring]:
        ring = Ring.over(memory, 64)
        events = Watched(), Watched()
        ring.event, ring.free_event = events
        yield ring
        assert (ring.lost, ring.fill(), ring.written, ring.taken) == (0, 0, COUNT, COUNT)
        ring.close()
        for event in events:
            event.close()
        if canwire.core_mode() == "compiled":  # the interpreted form has no fence: a wake-up may be late
            assert [event.in_vain for event in events] == [0, 0]

    def peer(self, role: str, ring: Ring, memory: int) -> subprocess.Popen[bytes]:
        assert ring.event is not None
        assert ring.free_event is not None
        descriptors = (memory, ring.event.fileno(), ring.free_event.fileno())
        command = [sys.executable, "-c", PEER, role, "64", str(COUNT), *map(str, descriptors)]
        return subprocess.Popen(command, env=environment(), pass_fds=descriptors, stderr=subprocess.PIPE)

    def finish(self, peer: subprocess.Popen[bytes]) -> None:
        _, complaints = peer.communicate(timeout=60)
        assert (complaints.decode(), peer.returncode) == ("", 0)

    def test_from_there_to_here(self, ring: Ring, memory: int) -> None:
        peer = self.peer("produce", ring, memory)
        got: list[int] = []
        while len(got) < COUNT:
            taken = ring.take_array(64)
            times = taken["time_ns"].tolist()
            assert taken["data"][:, :8].copy().view("<u8").ravel().tolist() == times
            got.extend(times)
            if not times and not ring.sleep(20.0):
                assert peer.poll() is None or ring.fill(), peer.communicate()[1].decode()
        self.finish(peer)
        assert got == list(range(COUNT))

    def test_from_here_to_there(self, ring: Ring, memory: int) -> None:
        peer = self.peer("consume", ring, memory)
        for number in range(COUNT):
            while ring.free() == 0:
                if not ring.sleep_until_free(20.0):
                    assert peer.poll() is None, peer.communicate()[1].decode()
            assert ring.put_bytes(record(number))
        self.finish(peer)


PINGER = """
import sys
from canwire.platform import EventDescriptor
from canwire.ring import Ring

memory, event, count, burst = map(int, sys.argv[1:])
ring = Ring.over(memory, 8)
ring.event = EventDescriptor.adopt(event)
for number in range(count):
    for _ in range(burst):
        assert ring.put_bytes(bytes(80))
    while ring.fill():  # the next ones come as soon as the last is taken: just while the reader arms
        pass
"""


@pytest.mark.skipif(not hasattr(os, "eventfd"), reason="descriptors are passed by number: Linux")
class TestArmingRaces:
    """Writes that come while the reader arms, from another process: every one of them wakes it."""

    ROUNDS = 3_000

    @pytest.mark.skipif(PORTABLE, reason="of descriptors that travel between processes, which are Linux'")
    @pytest.mark.parametrize("burst", [1, 3])
    @pytest.mark.parametrize("way", ["arm", "sleep"])
    def test_no_write_is_slept_through(self, way: str, burst: int) -> None:
        memory, event = memory_for(8), Watched()
        ring = Ring.over(memory, 8)
        ring.event = event
        ring.threshold = burst
        ring.arm()
        passed = (memory, event.fileno())
        command = [sys.executable, "-c", PINGER, *map(str, passed), str(self.ROUNDS), str(burst)]
        peer = subprocess.Popen(command, env=environment(), pass_fds=passed, stderr=subprocess.PIPE)
        late = taken = 0
        while taken < self.ROUNDS * burst:
            woken = event.wait(5.0) if way == "arm" else ring.sleep(5.0)
            late += not woken and ring.fill() >= burst
            if not woken and not ring.fill() and peer.poll() is not None:
                break
            while ring.take_bytes() is not None:
                taken += 1
            if way == "arm":
                ring.arm()
        _, complaints = peer.communicate(timeout=60)
        close_descriptors(memory)
        event.close()
        assert (complaints.decode(), taken) == ("", self.ROUNDS * burst)
        if canwire.core_mode() == "compiled":  # the interpreted form has no fence: a wake-up may be late
            assert late == 0

    def test_threads_that_race(self) -> None:
        """One thread writes as soon as the other one has taken; the reader sleeps for ever if it misses one."""
        ends = Ends("shared", 4)
        with_events(ends)
        event = ends.consumer.event
        assert isinstance(event, EventDescriptor)
        rounds = 2_000

        def write() -> None:
            for number in range(rounds):
                while ends.producer.fill():
                    os.sched_yield()
                ends.producer.put_bytes(record(number))

        interval = sys.getswitchinterval()
        sys.setswitchinterval(1e-6)
        thread = threading.Thread(target=write)
        ends.consumer.arm()
        thread.start()
        taken = late = 0
        try:
            while taken < rounds:
                late += not event.wait(5.0)
                while ends.take() is not None:
                    taken += 1
                ends.consumer.arm()
        finally:
            sys.setswitchinterval(interval)
            thread.join()
        assert (taken, late) == (rounds, 0)
        ends.close()


class TestEventDescriptor:
    @pytest.mark.skipif(PORTABLE, reason="of descriptors that travel between processes, which are Linux'")
    def test_an_adopted_one_is_both_ends_of_the_same_event(self) -> None:
        own = EventDescriptor()
        adopted = EventDescriptor.adopt(os.dup(own.fileno()))
        own.signal()
        assert adopted.wait(0)
        assert not own.wait(0)
        adopted.signal()
        assert own.wait(0)
        adopted.close()
        adopted.close()
        own.signal()
        assert own.wait(0)
        own.close()

    @pytest.mark.skipif(PORTABLE, reason="of descriptors that travel between processes, which are Linux'")
    def test_an_adopted_one_owns_its_descriptor(self) -> None:
        own = EventDescriptor()
        copy = os.dup(own.fileno())
        EventDescriptor.adopt(copy).close()
        with pytest.raises(OSError, match="Bad file descriptor"):
            os.fstat(copy)
        own.close()

    def test_signals_count_as_one(self) -> None:
        event = EventDescriptor()
        for _ in range(3):
            event.signal()
        assert [event.wait(0), event.wait(0)] == [True, False]
        event.signal()
        event.clear()
        event.clear()
        assert not event.wait(0)
        event.close()

    @pytest.mark.skipif(not hasattr(os, "eventfd"), reason="the counter is eventfd's")
    def test_a_full_counter_loses_nothing(self) -> None:
        event = EventDescriptor()
        os.write(event.fileno(), (2**64 - 2).to_bytes(8, "little"))
        event.signal()
        assert [event.wait(0), event.wait(0)] == [True, False]
        event.close()

    def test_waiting_for_something(self) -> None:
        event = EventDescriptor()
        asked: list[int] = []

        def settled() -> bool:
            asked.append(1)
            event.signal()
            return len(asked) == 3

        assert event.wait_for(settled, None)
        assert len(asked) == 3
        event.clear()
        assert event.wait_for(lambda: True, 0)
        assert not event.wait_for(lambda: False, 0)
        assert not event.wait_for(lambda: False, 0.001)
        assert event.wait_for(lambda: len(asked.append(1) or asked) > 5, None, recheck=0.0001)  # type: ignore[func-returns-value]
        event.close()


class Hostile:
    """A ring whose memory somebody else writes to."""

    def __init__(self, capacity: int, *, exact: bool = False) -> None:
        self.block = bytearray(ring_size(1 << (capacity - 1).bit_length()))
        self.ring = Ring(capacity, exact=exact, buffer=memoryview(self.block))
        self.ring.event, self.ring.free_event = _EVENTS
        self.words = memoryview(self.block).cast("Q")

    def write(self, **words: int) -> None:
        """Write into the words of these names."""
        for name, value in words.items():
            self.words[WORDS[name]] = value

    def use(self, action: str) -> None:
        """One call; never more than the capacity comes out, never an exception."""
        ring = self.ring
        if action == "put":
            ring.put_bytes(record(1))
        elif action == "put_array":
            assert 0 <= ring.put_array(array(*range(20))) <= ring.capacity
        elif action == "take_frame":
            ring.take_frame()
        elif action == "take_bytes":
            ring.take_bytes()
        elif action == "take_frames":
            assert len(ring.take_frames(100)) <= ring.capacity
        elif action == "take_array":
            assert len(ring.take_array(100)) <= ring.capacity
        elif action == "acquire":
            assert sum(map(len, ring.acquire(100))) <= ring.capacity * RECORD_SIZE
        elif action == "clear":
            assert 0 <= ring.clear() <= ring.capacity
        elif action == "sleep":
            ring.sleep(0)
        elif action == "sleep_until_free":
            ring.sleep_until_free(0)
        elif action == "acquire_free":
            room = ring.acquire_free(100)
            assert len(room) <= ring.capacity * RECORD_SIZE
            room[:] = bytes(len(room))
            ring.commit(len(room) // RECORD_SIZE)
        elif action == "arm":
            ring.arm()
            ring.arm_once()
            ring.arm_free()
        elif action == "counters":
            assert min(ring.written, ring.taken, ring.lost) >= 0
        assert 0 <= ring.fill() <= ring.capacity
        assert 0 <= ring.free() <= ring.capacity


_EVENTS = EventDescriptor(), EventDescriptor()
ACTIONS = ["put", "put_array", "take_frame", "take_bytes", "take_frames", "take_array", "acquire", "clear",
           "acquire_free", "arm", "sleep", "sleep_until_free", "counters"]  # fmt: skip
nonsense = st.one_of(
    st.integers(0, TOP),
    st.integers(0, 20),
    st.integers(TOP - 20, TOP),
    st.sampled_from([1 << 63, (1 << 63) - 1]),
)
intrusions = st.dictionaries(st.sampled_from(sorted(WORDS)), nonsense, min_size=1)


class TestHostilePeer:
    @examples(100)
    @given(
        st.integers(1, 16),
        st.booleans(),
        st.lists(st.tuples(intrusions, st.sampled_from(ACTIONS)), min_size=1, max_size=8),
    )
    def test_nonsense_in_the_words_does_no_harm(
        self, capacity: int, exact: bool, attacks: list[tuple[dict[str, int], str]]
    ) -> None:
        victim = Hostile(capacity, exact=exact)
        for words, action in attacks:
            victim.write(**words)
            victim.use(action)

    @each("action", ACTIONS)
    @each(
        ("head", "tail"),
        [(TOP, TOP), (TOP, 0), (0, TOP), (1 << 63, 0), (0, 1 << 63), (9, 0), (0, 1), (TOP, TOP - 8)],
    )
    def test_each_action_by_itself(self, head: int, tail: int, action: str) -> None:
        victim = Hostile(8)
        victim.write(head=head, tail=tail)
        victim.use(action)

    @each(("head", "tail"), [(9, 0), (1 << 40, 0), (1 << 63, 0), (0, 1), (3, 1 << 40)])
    def test_a_broken_ring_is_full_for_the_producer_and_empty_for_the_consumer(
        self, head: int, tail: int
    ) -> None:
        victim = Hostile(8)
        victim.write(head=head, tail=tail)
        ring = victim.ring
        assert (ring.fill(), ring.free()) == (0, 0)
        assert not ring.put_bytes(record(1))
        assert ring.put_array(array(1, 2)) == 0
        assert ring.take_frame() is None
        assert ring.take_bytes() is None
        assert ring.take_frames(5) == []
        assert len(ring.take_array(5)) == 0
        assert ring.acquire(5) == []
        assert not ring.acquire_free(5)
        assert ring.clear() == 0
        assert ring.lost == 1

    @each("start", [TOP, TOP - 2, (1 << 63) - 2, (1 << 32) - 2])
    @each("way", ["one by one", "arrays"])
    def test_counters_may_wrap(self, start: int, way: str) -> None:
        victim = Hostile(8)
        victim.write(head=start, tail=start)
        ring = victim.ring
        for number in range(0, 20, 5):
            numbers = range(number, number + 5)
            if way == "arrays":
                assert ring.put_array(array(*numbers)) == 5
                assert (ring.fill(), ring.free()) == (5, 3)
                assert ring.take_array(8)["time_ns"].tolist() == list(numbers)
            else:
                assert all(ring.put_bytes(record(one)) for one in numbers)
                assert (ring.fill(), ring.free()) == (5, 3)
                assert [ring.take_frame() for _ in numbers] == [frame(one) for one in numbers]
        assert ring.lost == 0

    def test_a_loss_counter_at_its_end(self) -> None:
        victim = Hostile(1)
        victim.write(lost=TOP)
        assert victim.ring.put_bytes(record(1))
        assert not victim.ring.put_bytes(record(2))

    def test_through_shared_memory(self) -> None:
        memory = memory_for(8)
        ring, intruder = Ring.over(memory, 8), map_memory(memory)
        close_descriptors(memory)
        for word in (WORDS["head"], WORDS["tail"]):
            intruder[8 * word : 8 * word + 8] = b"\xfe" * 7 + bytes([word])
        assert (ring.fill(), ring.free()) == (0, 0)
        assert ring.take_frame() is None
        assert not ring.put_bytes(record(1))
        intruder[8:HEADER_SIZE] = b"\xff" * (HEADER_SIZE - 8)  # capacity too: it was read once
        assert ring.fill() == 0
        assert ring.free() == 8
        intruder[:HEADER_SIZE] = bytes(HEADER_SIZE)
        assert (ring.capacity, ring.free()) == (8, 8)


@pytest.mark.finding("faults-2 11")
@pytest.mark.skipif(canwire.core_mode() == "uncompiled", reason="an AttributeError there")
def test_a_ring_that_was_never_initialised_is_full_and_empty() -> None:
    ring = Ring.__new__(Ring)
    assert repr(ring) == "<ring, 0 of 0 records of 0 bytes>"
    assert (ring.fill(), ring.free(), ring.written, ring.take_bytes()) == (0, 0, 0, None)
    with pytest.raises(TypeError):
        ring.put_bytes(b"")
