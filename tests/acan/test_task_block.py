"""Task blocks on their own: what they let through, keep and tell. Source: INduCAN104 manual."""

from __future__ import annotations

import contextlib
import queue
from collections import deque
from typing import Any

import hypothesis
import hypothesis.strategies as st
import pytest
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from canwire import BadValue, Frame, WrongState
from canwire.acan.constants import Action, BlockStatus, Condition
from canwire.acan.filters import Filter
from canwire.acan.identifiers import acan_word
from canwire.acan.task_block import Occurrence, Status, TaskBlock
from tests.cases import each
from tests.effort import examples

NOTIFY, QUEUE, RECEIVE, SEND = Action.NOTIFY, Action.QUEUE, Action.CHANRCV, Action.CHANSND
SC, MB, OVERFLOW = BlockStatus.SC, BlockStatus.MB, BlockStatus.OVERFLOW


def offer(block: TaskBlock, frame: Frame) -> list[Frame]:
    return block.offer(frame, acan_word(frame.id, frame.extended))


def channel(id: int, action: Action, variable: Any, length: int | None = None) -> Filter:
    return Filter.one(id, actions=action, variable=variable, length=length)


@pytest.mark.conforms("AC-20")
@each(
    ("and_mask", "xor_value", "word", "passes"),
    [
        (0, 0, 0, True),
        (0, 0, 0x1FFF_FFFF, True),
        (0x1FFF_FFFF, 0x0123_4567, 0x0123_4567, True),
        (0x1FFF_FFFF, 0x0123_4567, 0x0123_4566, False),
        (0x1FFF_0000, 0x01C0_0000, 0x01C0_FFFF, True),
        (0x1FFF_0000, 0x01C0_0000, 0x01C1_0000, False),
        (0x1FFF_0000, 0x01C0_0001, 0x01C0_0001, False),  # a bit that dwAnd takes away never agrees
    ],
)
def test_the_manuals_filters(and_mask: int, xor_value: int, word: int, passes: bool) -> None:
    assert Filter(and_mask, xor_value).matches(word) is passes


@pytest.mark.conforms("AC-20")
@examples(100)
@hypothesis.given(*(st.integers(0, 0xFFFF_FFFF) for _ in range(2)), st.integers(0, 0x1FFF_FFFF))
def test_a_filter_is_the_manuals_formula(and_mask: int, xor_value: int, word: int) -> None:
    assert Filter(and_mask, xor_value).matches(word) is (((word & and_mask) ^ xor_value) == 0)


@pytest.mark.conforms("AC-17", "AC-20")
def test_identifiers_are_left_aligned_in_filters() -> None:
    block = TaskBlock([Filter.one(0x123)])
    offer(block, Frame(0x123, b"standard"))
    offer(block, Frame(0x123, b"extended", extended=True))
    offer(block, Frame(0x123 << 18, b"same", extended=True))
    assert [frame.data for frame in block.retrieve()] == [b"standard", b"same"]


def test_a_filter_takes_data_and_remote_frames_alike() -> None:
    block = TaskBlock([Filter.one(0x123)])
    frames = [Frame(0x123), Frame(0x123, remote=True), Frame(0x123 << 18, remote=True, extended=True)]
    for frame in frames:
        offer(block, frame)
    assert block.retrieve() == frames


@pytest.mark.conforms("AC-21")
def test_one_frame_may_match_several_filters_and_stands_in_the_fifo_once() -> None:
    variable = bytearray(2)
    block = TaskBlock([Filter.any(), Filter.one(0x10), channel(0x10, RECEIVE, variable)])
    offer(block, Frame(0x10, b"ab"))
    assert block.occupation == 1
    assert variable == b"ab"


@pytest.mark.conforms("AC-22")
@each("number", range(16))
def test_all_actions_combine_but_both_directions_of_a_channel(number: int) -> None:
    actions = Action(number << 4)
    variable = bytearray(8) if actions & (RECEIVE | SEND) else None
    if RECEIVE in actions and SEND in actions:
        with pytest.raises(BadValue, match="bAction"):
            Filter(0, 0, actions, variable)
        return
    told: list[TaskBlock] = []
    block = TaskBlock([Filter(0, 0, actions, variable)], notify=told.append)
    request = Frame(0x1, bytes([0, 0, 4, 0, 0, 3]))
    replies = offer(block, request)
    assert block.take_notification() is (NOTIFY in actions)
    assert block.occupation == (QUEUE in actions)
    assert (variable == request.data.ljust(8, b"\0")) is (RECEIVE in actions)
    assert replies == ([Frame(0x1, bytes(3))] if SEND in actions else [])


@pytest.mark.conforms("AC-23")
@each("received", range(9))
@each("length", [1, 3, 8])
def test_a_receiving_channel_copies_the_shorter_of_both(received: int, length: int) -> None:
    variable = bytearray(b"........")
    block = TaskBlock([channel(0x10, RECEIVE, variable, length)])
    offer(block, Frame(0x10, bytes(range(1, received + 1))))
    count = min(received, length)
    assert variable == bytes(range(1, count + 1)).ljust(8, b".")
    assert block.status == 0
    assert not block.take_notification()


@pytest.mark.conforms("AC-23")
def test_a_remote_frame_brings_a_channel_nothing() -> None:
    variable = bytearray(b"....")
    offer(TaskBlock([channel(0x10, RECEIVE, variable)]), Frame(0x10, remote=True, dlc=4))
    assert variable == b"...."


def test_a_variable_that_became_shorter_is_never_overrun() -> None:
    variable = bytearray(8)
    receiving = TaskBlock([channel(0x10, RECEIVE, variable)])
    sending = TaskBlock([channel(0x10, SEND, variable)])
    del variable[2:]
    offer(receiving, Frame(0x10, b"12345678"))
    assert variable == b"12"
    [reply] = offer(sending, Frame(0x10, bytes([0, 0, 4, 0, 0, 8])))
    assert reply == Frame(0x1, b"12")


def test_a_variable_whose_memory_was_released_moves_nothing() -> None:
    variable = memoryview(bytearray(8))
    block = TaskBlock([channel(0x10, RECEIVE, variable), channel(0x10, SEND, variable)])
    variable.release()
    assert offer(block, Frame(0x10, bytes([0, 0, 4, 0, 0, 8]))) == [Frame(0x1, b"")]


@pytest.mark.conforms("AC-24")
@each(
    ("request_data", "reply"),
    [
        ("000048000004", Frame(0x012, b"vari")),
        ("000048000008", Frame(0x012, b"variable")),
        ("0000480000ff", Frame(0x012, b"variable")),
        ("000048000000", Frame(0x012)),
        ("785634128002", Frame(0x12345678, b"va", extended=True)),
        ("000048004004", Frame(0x012, remote=True, dlc=4)),
        ("785634f28002ffff", Frame(0x12345678, b"va", extended=True)),
        ("ffff4b000002", Frame(0x012, b"va")),
        ("0000480000", None),
        ("", None),
    ],
)
def test_a_request_says_where_the_answer_goes(request_data: str, reply: Frame | None) -> None:
    block = TaskBlock([channel(0x10, SEND, bytearray(b"variable"))])
    assert offer(block, Frame(0x10, bytes.fromhex(request_data))) == ([reply] if reply else [])


@pytest.mark.conforms("AC-35")
@each(
    ("field", "make"),
    [
        ("bSCFilter", lambda: TaskBlock(conditions=0x100)),
        ("wRMBSize", lambda: TaskBlock(size=0x1_0000)),
        ("wRMBSize", lambda: TaskBlock([Filter.any()], size=0)),
        ("bNId", lambda: TaskBlock([Filter.any()] * 256)),
        ("bNotType", lambda: TaskBlock(notify=3)),
        ("dwAnd", lambda: Filter(1 << 32, 0)),
        ("dwXor", lambda: Filter(0, -1)),
        ("bAction", lambda: Filter(0, 0, 0x88)),
        ("lpAddress", lambda: Filter(0, 0, RECEIVE)),
        ("lpAddress", lambda: Filter(0, 0, RECEIVE, b"constant")),
        ("lpAddress", lambda: Filter(0, 0, NOTIFY, bytearray(8))),
        ("lpAddress", lambda: Filter(0, 0, RECEIVE, memoryview(bytearray(8))[::2])),
        ("bLength", lambda: Filter(0, 0, RECEIVE, bytearray(9))),
        ("bLength", lambda: Filter(0, 0, SEND, bytearray(8), 9)),
        ("bLength", lambda: Filter(0, 0, SEND, bytearray(2), 3)),
        ("bLength", lambda: Filter(0, 0, SEND, bytearray(2), 0)),
    ],
)
def test_impossible_fields_are_refused_by_both_their_names(field: str, make: Any) -> None:
    with pytest.raises(BadValue, match=field) as refused:
        make()
    assert f"({field})" in str(refused.value)


@pytest.mark.conforms("AC-23", "AC-35")
def test_a_variable_that_is_too_short_by_now_is_refused_at_registration() -> None:
    variable = bytearray(8)
    block = TaskBlock([channel(0x10, RECEIVE, variable, 8)])
    del variable[4:]
    with pytest.raises(BadValue, match="bLength"):
        block.attach(Nobody())
    assert not block.registered


@pytest.mark.conforms("AC-29")
def test_a_full_fifo_drops_the_new_frame_and_says_so() -> None:
    block = TaskBlock([Filter.any()], size=2)
    for number in range(4):
        offer(block, Frame(number))
    assert (block.occupation, block.lost) == (2, 2)
    assert block.acknowledge() == MB | OVERFLOW
    assert [frame.id for frame in block.retrieve()] == [0, 1]
    offer(block, Frame(7))
    assert block.acknowledge() == MB
    assert [frame.id for frame in block.retrieve()] == [7]


@pytest.mark.conforms("AC-30")
def test_frames_are_retrieved_in_order_and_as_many_as_asked_for() -> None:
    block = TaskBlock([Filter.any()])
    for number in range(5):
        offer(block, Frame(number))
    assert [frame.id for frame in block.retrieve(2)] == [0, 1]
    assert [frame.id for frame in block.retrieve(9)] == [2, 3, 4]
    assert block.retrieve(1) == []


@pytest.mark.conforms("AC-25")
def test_one_notification_until_it_is_acknowledged() -> None:
    block = TaskBlock([Filter.any()], conditions=Condition.BUSERR)
    offer(block, Frame(1))
    assert block.take_notification()
    offer(block, Frame(2))
    block.occurred(Occurrence(int(Condition.BUSERR), 8, 0))
    assert not block.take_notification()
    assert block.acknowledge() == Condition.BUSERR << 8 | SC | MB
    assert not block.take_notification()
    offer(block, Frame(3))
    assert block.take_notification()


@pytest.mark.conforms("AC-25", "AC-26")
def test_a_filter_that_only_queues_is_seen_when_something_else_notifies() -> None:
    block = TaskBlock([Filter.one(1, actions=QUEUE), Filter.one(2, actions=NOTIFY)])
    offer(block, Frame(1))
    assert block.status == MB
    assert not block.take_notification()
    offer(block, Frame(2))
    assert block.take_notification()
    assert block.acknowledge() == MB
    assert block.acknowledge() == 0


@pytest.mark.conforms("AC-27")
@each("asked", list(Condition))
@each("happened", list(Condition))
def test_only_conditions_asked_for_are_told(asked: Condition, happened: Condition) -> None:
    block = TaskBlock(conditions=asked)
    block.occurred(Occurrence(int(happened), 96, 17))
    assert (block.tec, block.rec) == (96, 17)
    if asked == happened:
        assert block.take_notification()
        assert block.status == int(asked) << 8 | 1
        assert block.status.conditions == asked
        assert block.acknowledge().flags == SC
    else:
        assert not block.take_notification()
        assert block.acknowledge() == 0


@pytest.mark.conforms("AC-27")
def test_conditions_add_up_until_they_are_acknowledged() -> None:
    block = TaskBlock(conditions=0xFF)
    for condition in Condition:
        block.occurred(Occurrence(int(condition), 0, 0))
    assert block.acknowledge() == 0xFF01
    assert block.acknowledge() == 0


@pytest.mark.conforms("AC-28")
def test_captures_hold_what_they_were_given_last() -> None:
    block = TaskBlock(conditions=0xFF)
    block.occurred(Occurrence(int(Condition.ARBLOST), 1, 2, alc=11))
    block.occurred(Occurrence(int(Condition.BUSERR), 9, 2, ecc=0xD9))
    block.occurred(Occurrence(int(Condition.BUSOFF), 256, 0))
    assert (block.alc, block.ecc, block.tec, block.rec) == (11, 0xD9, 255, 0)


@pytest.mark.conforms("AC-25")
def test_callbacks_events_and_queues_are_told() -> None:
    class Flag:
        raised = 0

        def set(self) -> None:
            self.raised += 1

    told: list[TaskBlock] = []
    flag, posted = Flag(), queue.SimpleQueue[TaskBlock]()
    blocks = [TaskBlock([Filter.any()], notify=notify) for notify in (told.append, flag, posted, None)]
    for block in blocks:
        block.notify()
    assert told == [blocks[0]]
    assert flag.raised == 1
    assert posted.get(timeout=0) is blocks[2]


@pytest.mark.conforms("AC-35")
def test_a_block_is_registered_once_and_begins_anew() -> None:
    block = TaskBlock([Filter.any()], conditions=0xFF, size=1)
    offer(block, Frame(1))
    offer(block, Frame(2))
    block.attach(Nobody())
    assert (block.registered, block.status, block.occupation, block.lost) == (True, 0, 0, 0)
    with pytest.raises(WrongState):
        block.attach(Nobody())
    offer(block, Frame(3))
    block.detach()
    assert [frame.id for frame in block] == [3]
    with pytest.raises(WrongState):
        block.wait(0)


def test_a_status_word_reads_well() -> None:
    status = Status(0x8003)
    assert status.flags == SC | MB
    assert status.conditions == Condition.BUSERR
    assert not Status(0)
    assert "BUSERR" in repr(status)
    assert "registered" in repr(TaskBlock([Filter.any()]))


class Nobody:
    """A keeper that nothing comes from."""

    def __init__(self) -> None:
        self.lock = contextlib.nullcontext()

    def wait(self, ready: Any, timeout: float | None) -> bool:
        return bool(ready())

    def deregister(self, block: TaskBlock) -> None:
        block.detach()


class BlockMachine(RuleBasedStateMachine):
    """A block against the plainest model of FIFO, status word and notification."""

    @initialize(size=st.integers(1, 4), conditions=st.integers(0, 255))
    def made(self, size: int, conditions: int) -> None:
        self.block = TaskBlock(
            [Filter.one(1), Filter.one(2, actions=QUEUE), Filter.one(3, actions=NOTIFY)],
            conditions=conditions,
            size=size,
        )
        self.wanted, self.size = conditions, size
        self.fifo: deque[Frame] = deque()
        self.status = self.lost = self.count = 0
        self.told = self.due = False

    @rule(id=st.integers(1, 4))
    def frame(self, id: int) -> None:
        self.count += 1
        frame = Frame(id, self.count.to_bytes(4, "big"))
        offer(self.block, frame)
        if id in (1, 2) and len(self.fifo) < self.size:
            self.fifo.append(frame)
            self.status |= MB
        elif id in (1, 2):
            self.lost += 1
            self.status |= OVERFLOW
        self.due |= id in (1, 3)

    @rule(conditions=st.integers(1, 255))
    def condition(self, conditions: int) -> None:
        self.block.occurred(Occurrence(conditions, 0, 0))
        if conditions & self.wanted:
            self.status |= (conditions & self.wanted) << 8 | SC
            self.due = True

    @rule()
    def service(self) -> None:
        assert self.block.take_notification() is (self.due and not self.told)
        self.told, self.due = self.told or self.due, False if not self.told else self.due

    @rule()
    def acknowledge(self) -> None:
        assert self.block.acknowledge() == self.status
        self.status, self.told, self.due = 0, False, False

    @rule(limit=st.one_of(st.none(), st.integers(-1, 5)))
    def retrieve(self, limit: int | None) -> None:
        count = len(self.fifo) if limit is None else min(max(limit, 0), len(self.fifo))
        assert self.block.retrieve(limit) == [self.fifo.popleft() for _ in range(count)]

    @invariant()
    def agrees(self) -> None:
        if hasattr(self, "block"):
            assert self.block.status == self.status
            assert (self.block.occupation, self.block.lost) == (len(self.fifo), self.lost)


TestBlockMachine = pytest.mark.conforms("AC-25", "AC-26", "AC-29")(BlockMachine.TestCase)
