"""The event queue. Source: CANDRV manual, 7.6, 7.7, 8.7, 8.9."""

from __future__ import annotations

from collections import deque

import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from canwire import BadValue, candrv
from canwire.candrv import CanbusEvent, Event, EventQueue

RECEIVED, TRANSMITTED = CanbusEvent.RECEIVED, CanbusEvent.TRANSMITTED
CHANGED, WARNING = CanbusEvent.DEVICE_CHANGED, CanbusEvent.WARNING
EVERY = candrv.EVERY_EVENT

# the eight entries of 8.7, and what is left of them
EXAMPLE = [
    *((RECEIVED, 2), (RECEIVED, 5), (CHANGED, 4), (CHANGED, 3)),
    *((TRANSMITTED, 1), (CHANGED, 2), (RECEIVED, 0), (TRANSMITTED, 0)),
]
LEFT = [(RECEIVED, 2), (RECEIVED, 5), (TRANSMITTED, 10), (RECEIVED, 3), (TRANSMITTED, 0)]


def shown(queue: EventQueue) -> list[tuple[int, int]]:
    events = []
    while (event := queue.pop()) is not None:
        events.append((event.event, event.lost))
    return events


def queue_of_the_example() -> EventQueue:
    """Filled as on the manual's fast bus: every lost event found the queue full."""
    queue = EventQueue(8)
    for kind, lost in EXAMPLE:
        queue.lose(lost)
        assert queue.push(Event(kind))
    return queue


@pytest.mark.conforms("FS-34")
def test_worked_example_of_8_7() -> None:
    queue = queue_of_the_example()
    queue.mask &= ~CHANGED
    assert shown(queue) == LEFT


@pytest.mark.conforms("FS-34", "FS-35")
def test_the_example_through_a_queue_that_overflows() -> None:
    """The same counts, made by events that find a full queue."""
    queue = EventQueue(8)
    for _ in range(8):
        queue.push(Event(WARNING))
    for kind, lost in EXAMPLE:
        for _ in range(lost):
            assert not queue.push(Event(RECEIVED))
        assert queue.pop() == Event(WARNING)
        assert queue.push(Event(kind))
    queue.mask &= ~CHANGED
    assert shown(queue) == LEFT


@pytest.mark.conforms("FS-33")
def test_widening_the_mask_brings_nothing_back() -> None:
    queue = queue_of_the_example()
    queue.mask &= ~CHANGED
    queue.mask = EVERY
    assert shown(queue) == LEFT


@pytest.mark.conforms("FS-33", "FS-34")
def test_events_deleted_at_the_end_count_for_the_next_one_stored() -> None:
    queue = EventQueue(8)
    queue.push(Event(RECEIVED))
    queue.lose(4)
    queue.push(Event(CHANGED))
    queue.push(Event(CHANGED))
    queue.mask = RECEIVED
    assert queue.lost == 6
    queue.push(Event(RECEIVED))
    assert shown(queue) == [(RECEIVED, 0), (RECEIVED, 6)]


@pytest.mark.conforms("FS-32")
def test_only_types_in_the_mask_are_stored_and_the_rest_does_not_count() -> None:
    queue = EventQueue(8, mask=RECEIVED | WARNING)
    assert queue.mask == RECEIVED | WARNING
    assert not queue.push(Event(CHANGED))
    assert queue.push(Event(WARNING))
    assert queue.lost == 0
    assert shown(queue) == [(WARNING, 0)]


@pytest.mark.conforms("FS-32")
@pytest.mark.parametrize("mask", [0, 1, 0x7FF, 0x800, 0xFFFF_FFFF])
def test_the_mask_is_returned_as_it_was_set(mask: int) -> None:
    queue = EventQueue(1)
    assert queue.mask == 0x7FF
    queue.mask = mask
    assert queue.mask == mask


@pytest.mark.conforms("FS-32")
def test_each_queue_has_its_own_mask() -> None:
    one, other = EventQueue(8), EventQueue(8)
    one.mask = WARNING
    assert other.mask == EVERY


@pytest.mark.conforms("FS-35")
def test_a_full_queue_keeps_the_old_events_and_counts_the_new_ones() -> None:
    queue = EventQueue(2)
    pushed = [queue.push(Event(RECEIVED, time)) for time in range(5)]
    assert pushed == [True, True, False, False, False]
    assert queue.pop() == Event(RECEIVED, 0)
    assert queue.push(Event(RECEIVED, 5))
    assert not queue.push(Event(RECEIVED, 6))
    assert [queue.pop(), queue.pop(), queue.pop()] == [Event(RECEIVED, 1), Event(RECEIVED, 5, lost=3), None]
    assert queue.push(Event(RECEIVED, 7))
    assert queue.pop() == Event(RECEIVED, 7, lost=1)
    assert queue.overflowed == 4


@pytest.mark.conforms("FS-36")
def test_peeking_leaves_the_event() -> None:
    queue = EventQueue(2)
    assert queue.peek() == 0
    queue.push(Event(WARNING))
    queue.push(Event(RECEIVED))
    assert queue.peek() == queue.peek() == WARNING
    queue.put_back(queue.pop() or Event(0))
    assert shown(queue) == [(WARNING, 0), (RECEIVED, 0)]


def test_the_count_stays_at_32_bits() -> None:
    queue = EventQueue(1)
    queue.lose(0xFFFF_FFFF)
    queue.lose(5)
    queue.push(Event(RECEIVED))
    assert queue.pop() == Event(RECEIVED, lost=0xFFFF_FFFF)


def test_clearing_forgets_events_and_counts() -> None:
    queue = EventQueue(1)
    queue.push(Event(RECEIVED))
    queue.push(Event(RECEIVED))
    queue.clear()
    queue.push(Event(WARNING))
    assert shown(queue) == [(WARNING, 0)]


@pytest.mark.parametrize("capacity", [0, -1])
def test_no_queue_without_room(capacity: int) -> None:
    with pytest.raises(BadValue, match="1 or more"):
        EventQueue(capacity)


@pytest.mark.parametrize("mask", [-1, 1 << 32, "1"])
def test_impossible_masks_change_nothing(mask: int) -> None:
    queue = queue_of_the_example()
    with pytest.raises(BadValue, match="32 bits"):
        queue.mask = mask
    assert shown(queue) == EXAMPLE


events = st.builds(
    lambda kind, time, lost: Event(kind, time, lost),
    st.sampled_from([int(one) for one in CanbusEvent]),
    st.integers(0, (1 << 64) - 1),
    st.integers(0, 0xFFFF_FFFF),
)
messages = st.builds(
    lambda kind, time, lost, fmt, identifier, dlc, data: Event(
        kind, time, lost, fmt, identifier, 0, dlc, data[: min(dlc, 8)]
    ),
    st.sampled_from([RECEIVED, TRANSMITTED, CanbusEvent.ABORTED]).map(int),
    st.integers(0, (1 << 64) - 1),
    st.integers(0, 0xFFFF_FFFF),
    st.integers(0, 2),
    st.integers(0, 0xFFFF_FFFF),
    st.integers(0, 15),
    st.binary(min_size=8, max_size=8),
)


@pytest.mark.conforms("FS-48")
@given(event=events | messages)
def test_an_event_is_a_can_event(event: Event) -> None:
    structure = event.to_structure()
    assert event.pack() == structure.pack()
    assert len(event.pack()) == candrv.CAN_EVENT.SIZE
    assert Event.from_structure(candrv.CAN_EVENT.unpack(event.pack())) == event
    assert event.type == event.event
    assert event.has_message == (event.event in (0x001, 0x002, 0x400))


class Queue(RuleBasedStateMachine):
    """Against a model that keeps every event ever made, and works the counts out from who is missing."""

    @initialize(capacity=st.integers(1, 6))
    def begin(self, capacity: int) -> None:
        self.queue = EventQueue(capacity)
        self.capacity, self.mask = capacity, 0x7FF
        self.line: deque[tuple[int, int, bool]] = deque()  # type, number, whether it is still there
        self.number = 0

    def waiting(self) -> list[tuple[int, int]]:
        """(number, lost before it) of those still there."""
        found, missing = [], 0
        for _, number, there in self.line:
            if there:
                found.append((number, missing))
            missing = 0 if there else missing + 1
        return found

    @rule(kind=st.sampled_from([int(one) for one in CanbusEvent]), count=st.integers(1, 4))
    def push(self, kind: int, count: int) -> None:
        for _ in range(count):
            self.number += 1
            room = len(self.waiting()) < self.capacity
            stored = self.queue.push(Event(kind, self.number))
            if kind & self.mask:
                self.line.append((kind, self.number, room))
            assert stored == (bool(kind & self.mask) and room)

    @rule()
    def pop(self) -> None:
        waiting = self.waiting()
        event = self.queue.pop()
        assert (event is None) == (not waiting)
        if event is not None:
            assert (event.time, event.lost) == waiting[0]
            while not self.line.popleft()[2]:
                pass

    @rule(mask=st.integers(0, 0x7FF))
    def set_mask(self, mask: int) -> None:
        self.queue.mask = self.mask = mask
        self.line = deque((kind, number, there and bool(kind & mask)) for kind, number, there in self.line)

    @invariant()
    def as_told(self) -> None:
        waiting = self.waiting()
        assert len(self.queue) == len(waiting)
        kinds = {number: kind for kind, number, _ in self.line}
        assert self.queue.peek() == (kinds[waiting[0][0]] if waiting else 0)


TestQueue = Queue.TestCase
