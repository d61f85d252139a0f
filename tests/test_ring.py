"""The contract of a ring in both homes: one object in this process, or two ends of named shared memory."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Iterator
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path

import numpy
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

import canwire
from canwire.errors import BadValue, CanwireError
from canwire.platform import EventDescriptor
from canwire.ring import HEADER_SIZE, MAGIC, Ring, ring_size
from canwire.values.frame import Frame, record_of_frame
from canwire.values.record import RECORD_SIZE, record_dtype

pytestmark = pytest.mark.core

WORDS = {"head": 8, "lost": 9, "tail": 16, "wanted": 17, "free_wanted": 24}  # as ring.py draws them
_numbers = itertools.count()


def fresh_name() -> str:
    return f"canwire-test-{os.getpid()}-{next(_numbers)}"


def record(number: int) -> bytes:
    """A record that holds its number in time, identifier and data."""
    return record_of_frame(frame(number))


def frame(number: int) -> Frame:
    return Frame(number & 0x7FF, number.to_bytes(8, "little"), timestamp_ns=number)


def array(*numbers: int) -> numpy.ndarray:
    return numpy.frombuffer(b"".join(map(record, numbers)), record_dtype())


class Ends:
    """Both ends of one ring, of a given capacity."""

    def __init__(self, home: str, capacity: int) -> None:
        self.home = home
        if home == "process":
            self.producer = self.consumer = Ring(capacity)
        else:
            name = fresh_name()
            self.producer = Ring.create(name, capacity)
            self.consumer = Ring.attach(name)

    def fill_up(self, *numbers: int) -> None:
        for number in numbers:
            assert self.producer.put_bytes(record(number))

    def take(self) -> int | None:
        got = self.consumer.take_bytes()
        return None if got is None else int.from_bytes(got[:8], "little")

    def take_all(self) -> list[int]:
        return [found.timestamp_ns for found in self.consumer.take_frames(1 << 20)]

    def close(self) -> None:
        if self.home == "shared":
            self.consumer.close()
            self.producer.close(remove=True)


Make = Callable[[int], Ends]


@pytest.fixture(params=["process", "shared"])
def make(request: pytest.FixtureRequest) -> Iterator[Make]:
    made: list[Ends] = []

    def one(capacity: int) -> Ends:
        made.append(Ends(request.param, capacity))
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

    @pytest.mark.parametrize("capacity", [0, -1, (1 << 24) + 1, 2.5, "8", None])
    def test_no_capacity(self, capacity: int) -> None:
        with pytest.raises(BadValue, match="capacity"):
            Ring(capacity)

    @pytest.mark.parametrize("capacity", [0, -5, (1 << 24) + 1, 2.5, "8", None])
    def test_no_capacity_leaves_no_shared_memory_behind(self, capacity: int) -> None:
        name = fresh_name()
        try:
            with pytest.raises(BadValue, match="capacity"):
                Ring.create(name, capacity)
            with pytest.raises(FileNotFoundError):
                Ring.attach(name)
        finally:
            remove_if_there(name)

    @pytest.mark.parametrize("size", [24, HEADER_SIZE, ring_size(4), ring_size(8) - 1])
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
        ends.consumer.release(3)
        ends.fill_up(4, 5, 6, 7)
        blocks = [bytes(block) for block in ends.consumer.acquire(100)]
        assert [len(block) // RECORD_SIZE for block in blocks] == [1, 3]
        assert b"".join(blocks) == b"".join(map(record, (4, 5, 6, 7)))
        ends.consumer.release(4)
        assert ends.consumer.fill() == 0

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
        ends.fill_up(0, 0, 0)
        ends.consumer.release(3)
        ends.fill_up(1, 2, 3, 4)
        taken = ends.consumer.take_array(100)
        ends.fill_up(5, 6, 7, 8)
        assert taken["time_ns"].tolist() == [1, 2, 3, 4]

    def test_take_nothing(self, make: Make) -> None:
        taken = make(4).consumer.take_array(3)
        assert (len(taken), taken.dtype) == (0, record_dtype())

    def test_put(self, make: Make) -> None:
        ends = make(4)
        assert ends.producer.put_array(array(1, 2, 3)) == 3
        assert ends.take_all() == [1, 2, 3]
        assert ends.producer.put_array(array(4, 5, 6)) == 3  # around the end
        assert ends.consumer.take_bytes() == record(4)
        assert ends.take_all() == [5, 6]

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


class TestAttach:
    def test_by_name(self) -> None:
        ends = Ends("shared", 5)
        try:
            ends.fill_up(1, 2)
            assert ends.take_all() == [1, 2]
        finally:
            ends.close()

    def test_a_name_that_is_taken(self) -> None:
        name = fresh_name()
        ring = Ring.create(name, 4)
        try:
            with pytest.raises(FileExistsError):
                Ring.create(name, 4)
            ring.put_bytes(record(1))
            assert ring.take_bytes() == record(1)
        finally:
            ring.close(remove=True)

    def test_no_such_name(self) -> None:
        with pytest.raises(FileNotFoundError):
            Ring.attach(fresh_name())

    # fmt: off
    @pytest.mark.parametrize(("size", "words"), [
        (4096, []),
        (4096, [0x1234, 4, 10]),
        (4096, [None, 0, 10]),
        (4096, [None, 3, 10]),
        (4096, [None, 1 << 25, 10]),
        (4096, [None, 2**64 - 1, 10]),
        (4096, [None, 1 << 63, 10]),
        (4096, [None, 4, 9]),
        (4096, [None, 64, 10]),  # larger than its memory
        (16, []),
        (20, []),
        (24, [None, 4, 10]),
    ])  # fmt: skip
    def test_memory_that_holds_no_ring(self, size: int, words: list[int | None]) -> None:
        memory = SharedMemory(fresh_name(), create=True, size=size)
        try:
            for at, word in enumerate(words):
                value = MAGIC if word is None else word
                write_into(memory, 8 * at, value.to_bytes(8, "little"))
            with pytest.raises(BadValue, match=memory.name):
                Ring.attach(memory.name)
        finally:
            memory.close()
            remove_if_there(memory.name)

    def test_closing_twice_is_fine(self) -> None:
        name = fresh_name()
        ring = Ring.create(name, 4)
        ring.close(remove=True)
        ring.close(remove=True)
        with pytest.raises(FileNotFoundError):
            Ring.attach(name)

    def test_a_closed_end_leaves_the_other_alone(self) -> None:
        ends = Ends("shared", 4)
        try:
            ends.fill_up(1)
            ends.consumer.close()
            ends.fill_up(2)
            assert (ends.producer.fill(), ends.consumer.fill()) == (2, 0)
        finally:
            ends.close()

    def test_leaves_no_complaint_behind(self) -> None:
        """Creating, attaching and removing in one process: nothing on standard error, at exit neither."""
        script = (
            "from canwire.ring import Ring\n"
            f"name = {fresh_name()!r}\n"
            "one = Ring.create(name, 4)\n"
            "other = Ring.attach(name)\n"
            "other.close()\n"
            "one.close(remove=True)\n"
        )
        command = [sys.executable, "-c", script]
        done = subprocess.run(command, env=environment(), capture_output=True, check=True)
        assert done.stderr.decode() == ""


def write_into(memory: SharedMemory, start: int, data: bytes) -> None:
    assert memory.buf is not None
    memory.buf[start : start + len(data)] = data


def remove_if_there(name: str) -> None:
    try:
        memory = SharedMemory(name)
    except FileNotFoundError:
        return
    memory.close()
    memory.unlink()


class RingMachine(RuleBasedStateMachine):
    """Any sequence of calls does what a deque does."""

    home = "process"

    @initialize(capacity=st.integers(1, 9))
    def begin(self, capacity: int) -> None:
        self.ends = Ends(self.home, capacity)
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
TestMachine.settings = settings(max_examples=60, stateful_step_count=30)
TestSharedMachine = SharedRingMachine.TestCase
TestSharedMachine.settings = settings(max_examples=30, stateful_step_count=30)


COUNT = 20_000
PEER = """
import itertools, os, sys
from canwire.platform import EventDescriptor
from canwire.ring import Ring
from canwire.values.frame import Frame, record_of_frame

def passed_on(descriptor):
    event = EventDescriptor()
    os.dup2(descriptor, event.fileno())
    return event

role, name, count, event, free_event = sys.argv[1], sys.argv[2], *map(int, sys.argv[3:])
ring = Ring.attach(name)
ring.event, ring.free_event = passed_on(event), passed_on(free_event)
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


@pytest.mark.skipif(not hasattr(os, "eventfd"), reason="descriptors are passed by number: Linux")
class TestTwoProcesses:
    """20,000 records through a small ring, both sides asleep whenever they cannot go on."""

    @pytest.fixture
    def name(self) -> str:
        return fresh_name()

    @pytest.fixture
    def ring(self, name: str) -> Iterator[Ring]:
        ring = Ring.create(name, 64)
        events = Watched(), Watched()
        ring.event, ring.free_event = events
        yield ring
        assert (ring.lost, ring.fill(), ring.written, ring.taken) == (0, 0, COUNT, COUNT)
        ring.close(remove=True)
        for event in events:
            event.close()
        if canwire.core_mode() == "compiled":  # the interpreted form has no fence: a wake-up may be late
            assert [event.in_vain for event in events] == [0, 0]

    def peer(self, role: str, ring: Ring, name: str) -> subprocess.Popen[bytes]:
        assert ring.event is not None
        assert ring.free_event is not None
        descriptors = (ring.event.fileno(), ring.free_event.fileno())
        command = [sys.executable, "-c", PEER, role, name, str(COUNT), *map(str, descriptors)]
        return subprocess.Popen(command, env=environment(), pass_fds=descriptors, stderr=subprocess.PIPE)

    def finish(self, peer: subprocess.Popen[bytes]) -> None:
        _, complaints = peer.communicate(timeout=60)
        assert (complaints.decode(), peer.returncode) == ("", 0)

    def test_from_there_to_here(self, ring: Ring, name: str) -> None:
        peer = self.peer("produce", ring, name)
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

    def test_from_here_to_there(self, ring: Ring, name: str) -> None:
        peer = self.peer("consume", ring, name)
        for number in range(COUNT):
            while ring.free() == 0:
                if not ring.sleep_until_free(20.0):
                    assert peer.poll() is None, peer.communicate()[1].decode()
            assert ring.put_bytes(record(number))
        self.finish(peer)


class Hostile:
    """A ring whose memory somebody else writes to."""

    def __init__(self, capacity: int) -> None:
        self.block = bytearray(ring_size(1 << (capacity - 1).bit_length()))
        self.ring = Ring(capacity, buffer=memoryview(self.block))
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
        elif action == "counters":
            assert min(ring.written, ring.taken, ring.lost) >= 0
        assert 0 <= ring.fill() <= ring.capacity
        assert 0 <= ring.free() <= ring.capacity


_EVENTS = EventDescriptor(), EventDescriptor()
ACTIONS = ["put", "put_array", "take_frame", "take_bytes", "take_frames", "take_array", "acquire", "clear",
           "sleep", "sleep_until_free", "counters"]  # fmt: skip
TOP = 2**64 - 1
nonsense = st.one_of(
    st.integers(0, TOP),
    st.integers(0, 20),
    st.integers(TOP - 20, TOP),
    st.sampled_from([1 << 63, (1 << 63) - 1]),
)
intrusions = st.dictionaries(st.sampled_from(sorted(WORDS)), nonsense, min_size=1)


class TestHostilePeer:
    @given(
        st.integers(1, 16), st.lists(st.tuples(intrusions, st.sampled_from(ACTIONS)), min_size=1, max_size=8)
    )
    def test_nonsense_in_the_words_does_no_harm(
        self, capacity: int, attacks: list[tuple[dict[str, int], str]]
    ) -> None:
        victim = Hostile(capacity)
        for words, action in attacks:
            victim.write(**words)
            victim.use(action)

    @pytest.mark.parametrize("action", ACTIONS)
    @pytest.mark.parametrize(
        ("head", "tail"),
        [(TOP, TOP), (TOP, 0), (0, TOP), (1 << 63, 0), (0, 1 << 63), (9, 0), (0, 1), (TOP, TOP - 8)],
    )
    def test_each_action_by_itself(self, head: int, tail: int, action: str) -> None:
        victim = Hostile(8)
        victim.write(head=head, tail=tail)
        victim.use(action)

    @pytest.mark.parametrize(("head", "tail"), [(9, 0), (1 << 40, 0), (1 << 63, 0), (0, 1), (3, 1 << 40)])
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
        assert ring.clear() == 0
        assert ring.lost == 1

    @pytest.mark.parametrize("start", [TOP, TOP - 2, (1 << 63) - 2, (1 << 32) - 2])
    @pytest.mark.parametrize("way", ["one by one", "arrays"])
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
        name = fresh_name()
        ring = Ring.create(name, 8)
        intruder = SharedMemory(name)
        try:
            for word in (WORDS["head"], WORDS["tail"]):
                write_into(intruder, 8 * word, b"\xfe" * 7 + bytes([word]))
            assert (ring.fill(), ring.free()) == (0, 0)
            assert ring.take_frame() is None
            assert not ring.put_bytes(record(1))
            write_into(intruder, 8, b"\xff" * (HEADER_SIZE - 8))  # capacity too: it was read once
            assert ring.fill() == 0
            assert ring.free() == 8
        finally:
            intruder.close()
            ring.close(remove=True)
