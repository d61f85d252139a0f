"""What the bus brings, handed to blocks. Source: INduCAN104 manual, "Notification", "CAN channels"."""

from __future__ import annotations

import pytest

from canwire import BusEvent, ErrorKind, ErrorState, EventKind, Frame
from canwire.acan.constants import Action, Condition
from canwire.acan.dispatch import Dispatch
from canwire.acan.filters import Filter
from canwire.acan.line import Arrival
from canwire.acan.task_block import TaskBlock
from tests.cases import each

ACTIVE, WARNING, PASSIVE, BUS_OFF, STOPPED = ErrorState
C = Condition


class Bench:
    """A dispatch, what its channels answer, and a block that wants every condition."""

    def __init__(self, state: ErrorState = ACTIVE, interrupts: int = 0xED) -> None:
        self.replies: list[tuple[Frame, bool]] = []
        self.dispatch = Dispatch(
            state, lambda frame, looped: self.replies.append((frame, looped)), lambda: interrupts
        )
        self.block = self.add(TaskBlock(conditions=0xFF))

    def add(self, block: TaskBlock) -> TaskBlock:
        self.dispatch.blocks.append(block)
        return block

    def event(self, kind: EventKind, **members: int) -> Condition:
        """The conditions that an event raises."""
        event = BusEvent(kind, error=ErrorKind.BIT if kind is EventKind.ERROR else ErrorKind.NONE, **members)
        self.dispatch.take(Arrival(event, False))
        return self.block.acknowledge().conditions

    def frame(self, frame: Frame, lost_before: bool = False) -> list[TaskBlock]:
        return self.dispatch.take(Arrival(frame, lost_before))


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.mark.conforms("AC-27")
@each(
    ("before", "now", "raised"),
    [
        (ACTIVE, ACTIVE, C(0)),
        (ACTIVE, WARNING, C.ERRLIM),
        (WARNING, WARNING, C(0)),
        (WARNING, PASSIVE, C.ERRPAS),
        (ACTIVE, PASSIVE, C.ERRLIM | C.ERRPAS),
        (PASSIVE, WARNING, C(0)),
        (PASSIVE, BUS_OFF, C.BUSOFF),
        (WARNING, BUS_OFF, C.BUSOFF),
        (ACTIVE, BUS_OFF, C.ERRLIM | C.BUSOFF),
        (BUS_OFF, STOPPED, C(0)),
        (STOPPED, WARNING, C.ERRLIM),
        (BUS_OFF, ACTIVE, C(0)),
    ],
)
def test_limits_are_told_when_they_are_passed(before: ErrorState, now: ErrorState, raised: Condition) -> None:
    assert Bench(before).event(EventKind.STATE, state=now, tec=97, rec=3) == raised


@pytest.mark.conforms("AC-27")
@pytest.mark.finding("acan A6")
@each(
    ("interrupts", "told"),
    [
        (0xAD, C.ERRLIM | C.ERRPAS | C.BUSOFF | C.BUSERR),
        (0xA9, C.ERRPAS | C.BUSERR),
        (0x8D, C.ERRLIM | C.BUSOFF | C.BUSERR),
        (0x89, C.BUSERR),
    ],
)
def test_limits_are_told_by_their_interrupts(interrupts: int, told: Condition) -> None:
    bench = Bench(interrupts=interrupts)
    found = C(0)
    for state in (WARNING, PASSIVE, BUS_OFF):
        found |= bench.event(EventKind.ERROR, state=state, code=0xD9)
    assert found == told


@pytest.mark.conforms("AC-28")
@pytest.mark.finding("acan A8")
def test_in_bus_off_the_counter_is_the_chips(bench: Bench) -> None:
    bench.event(EventKind.STATE, state=BUS_OFF, tec=256, rec=0)
    assert (bench.block.tec, bench.block.rec) == (127, 0)


@pytest.mark.conforms("AC-27", "AC-28")
def test_each_event_is_its_condition_with_counters_and_captures(bench: Bench) -> None:
    block = bench.block
    assert bench.event(EventKind.ERROR, code=0xD9, tec=8, rec=1) == C.BUSERR
    assert (block.tec, block.rec, block.ecc, block.alc) == (8, 1, 0xD9, 0)
    assert bench.event(EventKind.ARBITRATION_LOST, bit=11, tec=7, rec=2) == C.ARBLOST
    assert (block.tec, block.rec, block.ecc, block.alc) == (7, 2, 0xD9, 11)
    assert bench.event(EventKind.OVERRUN, rec=3) == C.OVERRUN
    assert bench.event(EventKind.INFO, code=1) == C(0)
    assert bench.event(EventKind.ERROR, state=PASSIVE, tec=128) == C.BUSERR | C.ERRLIM | C.ERRPAS


@pytest.mark.conforms("AC-27")
def test_frames_that_the_library_lost_are_told(bench: Bench) -> None:
    bench.event(EventKind.ERROR, tec=5, rec=6)
    assert bench.frame(Frame(1), lost_before=True) == [bench.block]
    assert bench.block.acknowledge().conditions == C.NOBUFF
    assert (bench.block.tec, bench.block.rec) == (5, 6)


@pytest.mark.conforms("AC-21")
def test_a_frame_reaches_every_block_in_the_order_of_registration(bench: Bench) -> None:
    blocks = [bench.add(TaskBlock([Filter.any()])) for _ in range(3)]
    assert bench.frame(Frame(1)) == blocks
    assert [block.occupation for block in blocks] == [1, 1, 1]
    assert bench.frame(Frame(2)) == []  # nobody has acknowledged the first one


def request(word: int, length: int = 8) -> bytes:
    return word.to_bytes(4, "little") + bytes([0, length])


@pytest.mark.conforms("AC-24")
def test_a_reply_is_looped_back_so_that_it_may_address_a_channel_here(bench: Bench) -> None:
    bench.add(TaskBlock([Filter.one(0x10, actions=Action.CHANSND, variable=bytearray(b"value"))]))
    bench.frame(Frame(0x10, request(0x20 << 18)))
    assert bench.replies == [(Frame(0x20, b"value"), True)]


@pytest.mark.conforms("AC-24")
def test_a_reply_that_asks_a_channel_here_is_not_looped_back(bench: Bench) -> None:
    variable = bytearray(request(0x10 << 18))
    bench.add(TaskBlock([Filter.one(0x10, actions=Action.CHANSND, variable=variable)]))
    bench.frame(Frame(0x10, request(0x10 << 18)))
    assert bench.replies == [(Frame(0x10, bytes(variable)), False)]
