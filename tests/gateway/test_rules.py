"""What a gateway does with one frame: filter, identifier, change, limit; each frame is counted once."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadFilter, BadValue, Frame, GatewayRules
from canwire.gateway.rules import Identifier, Passage
from tests.cases import each
from tests.effort import examples


def test_everything_passes_as_it_is() -> None:
    passage = Passage(GatewayRules())
    frames = [Frame(0x123, b"\x01"), Frame(0x123, extended=True), Frame(1, remote=True, dlc=4)]
    frames.append(Frame(2, bytes(64), fd=True))
    assert [passage.through(frame) for frame in frames] == frames
    assert passage.counts.heard == 4


def test_filters_are_the_labs() -> None:
    passage = Passage(GatewayRules(filters=[(0x120, 0x7F0), (0x18FEF100, 0x1FFFFFFF, True)]))
    heard = [Frame(0x12F), Frame(0x130), Frame(0x18FEF100, extended=True), Frame(0x120, extended=True)]
    assert [passage.through(frame) is not None for frame in heard] == [True, False, True, False]
    assert passage.counts.filtered == 2


CASES: list[tuple[Identifier, Identifier, Frame, Frame]] = [
    (0x100, 0x200, Frame(0x100, b"\x05"), Frame(0x200, b"\x05")),
    (0x100, 0x18FEF100, Frame(0x100, b"\x05"), Frame(0x18FEF100, b"\x05", extended=True)),
    (0x100, (0x100, True), Frame(0x100), Frame(0x100, extended=True)),
    ((0x100, True), 0x7FF, Frame(0x100, extended=True), Frame(0x7FF)),
    (0x100, 0x200, Frame(0x100, extended=True), Frame(0x100, extended=True)),
    (
        1,
        2,
        Frame(1, bytes(24), fd=True, bit_rate_switch=True),
        Frame(2, bytes(24), fd=True, bit_rate_switch=True),
    ),
    (1, 2, Frame(1, remote=True, dlc=3), Frame(2, remote=True, dlc=3)),
    (1, 2, Frame(1, bytes(8), dlc=12), Frame(2, bytes(8), dlc=12)),
]


@each(("old", "new", "heard", "sent"), CASES)
def test_another_identifier_and_nothing_else_changes(
    old: Identifier, new: Identifier, heard: Frame, sent: Frame
) -> None:
    assert Passage(GatewayRules(ids={old: new})).through(heard) == sent


def test_a_change_may_drop_frames() -> None:
    def even(frame: Frame) -> Frame | None:
        return None if frame.data[0] % 2 else Frame(frame.id, frame.data + b"!")

    passage = Passage(GatewayRules(ids={1: 2}, change=even))
    assert passage.through(Frame(1, b"\x02")) == Frame(2, b"\x02!")
    assert passage.through(Frame(1, b"\x03")) is None
    assert passage.counts.filtered == 1


def test_what_a_change_returns_is_looked_at() -> None:
    with pytest.raises(TypeError, match=r"change returned b'' .* must be a Frame or None"):
        Passage(GatewayRules(change=lambda frame: frame.data)).through(Frame(1))  # type: ignore[arg-type, return-value]


def test_fd_frames_do_not_fit_a_classic_line() -> None:
    passage = Passage(GatewayRules(), fd=False)
    assert passage.through(Frame(1, bytes(12), fd=True)) is None
    assert passage.counts.unfit == 1


@examples(100)
@given(st.integers(1, 50), st.lists(st.integers(0, 100_000_000), max_size=300))
def test_never_more_than_the_rate_in_any_second(rate: int, gaps: list[int]) -> None:
    passage, now, passed = Passage(GatewayRules(rate=rate)), 0, []
    for gap in gaps:
        now += gap
        if passage.through(Frame(1, timestamp_ns=now)) is not None:
            passed.append(now)
    assert all(sum(begin <= at < begin + 1_000_000_000 for at in passed) <= rate for begin in passed)
    assert passage.counts.limited == len(gaps) - len(passed)
    if now < 1_000_000_000:
        assert len(passed) == min(rate, len(gaps))


@each(
    ("rules", "error"),
    [
        ({"rate": 0}, BadValue),
        ({"rate": float("nan")}, BadValue),
        ({"filters": [(0x800, 0x7FF)]}, BadFilter),
        ({"ids": {0x100: 1 << 29}}, BadValue),
        ({"ids": {"100": 0x200}}, BadValue),
        ({"ids": [1, 2]}, TypeError),
        ({"change": 7}, TypeError),
    ],
)
def test_rules_that_cannot_be(rules: dict[str, object], error: type[Exception]) -> None:
    with pytest.raises(error):
        GatewayRules(**rules)  # type: ignore[arg-type]
