"""Schedule tables: what can be said, and what is refused."""

from __future__ import annotations

import pytest

from canwire.errors import BadValue
from canwire.values.lin.schedule import LinSchedule, LinSlot, SlotKind
from tests.cases import each


def test_kinds_of_slots() -> None:
    assert LinSlot.frame(0x10, delay_ns=5).kind is SlotKind.FRAME
    assert LinSlot.sporadic([0x12, 0x11]).ids == (0x12, 0x11)
    assert LinSlot.request().ids == (0x3C,)
    assert LinSlot.response().ids == (0x3D,)
    assert LinSlot.request(bytes(8)).data == bytes(8)


def test_the_resolving_slots_of_an_event_are_its_members_once_each() -> None:
    event = LinSlot.event(0x30, [0x11, 0x12], delay_ns=7)
    assert event.members == (0x11, 0x12)
    assert event.resolving == (LinSlot.frame(0x11, delay_ns=7), LinSlot.frame(0x12, delay_ns=7))
    own = LinSlot.event(0x30, [0x11], resolving=[LinSlot.frame(0x11, delay_ns=9)])
    assert own.resolving == (LinSlot.frame(0x11, delay_ns=9),)


@each(
    ("make", "message"),
    [
        (lambda: LinSlot.frame(64), "frame slot: LIN identifier 0x40"),
        (lambda: LinSlot.sporadic([]), "it needs one of them"),
        (lambda: LinSlot(SlotKind.FRAME, (1, 2)), "it needs one of them"),
        (lambda: LinSlot.event(0x30, []), "name the frames that answer it"),
        (lambda: LinSlot.event(0x30, [99]), "LIN identifier 0x63"),
        (lambda: LinSlot.frame(1, delay_ns=-1), "delay_ns -1"),
        (lambda: LinSlot.frame(1, length=9), "length 9"),
        (lambda: LinSlot.request(b"\1"), "8 bytes of it"),
        (lambda: LinSlot(SlotKind.FRAME, (1,), data=bytes(8)), "only a master request has it"),
        (lambda: LinSchedule("x", ()), "schedule 'x': one LinSlot at least"),
        (lambda: LinSchedule("x", (1,)), "one LinSlot at least, and nothing else"),
    ],
)
def test_what_no_slot_can_be(make: object, message: str) -> None:
    with pytest.raises(BadValue, match=message):
        make()  # type: ignore[operator]


def test_an_identifier_alone_is_an_unconditional_frame() -> None:
    assert LinSchedule.of([0x10, LinSlot.frame(0x11)], "t").slots == (
        LinSlot.frame(0x10),
        LinSlot.frame(0x11),
    )
