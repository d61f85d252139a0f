"""Levels forced anywhere: at times and at places, for all, several or one; and that nothing else changes by it."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import BadValue, ErrorState, Frame, Lab, LabBus, LabNode

pytestmark = pytest.mark.core

FRAME = Frame(0x123, b"\x11\x22")  # 62 bits at 2 us
OTHER = Frame(0x321, b"\x11\x22")
BIT = 2_000


def three(bus: LabBus) -> list[LabNode]:
    return [bus.node(name) for name in "abc"]


def ends(node: LabNode) -> list[int]:
    """When the frames it received ended, in bits."""
    return [frame.timestamp_ns // BIT for frame in node.receive_many(99)]


@pytest.mark.parametrize("traced", [False, True])
@pytest.mark.parametrize(("bit", "later"), [(1, 18), (2, 19)])
def test_a_dominant_bit_of_the_intermission_is_an_overload_frame(
    lab: Lab, can_bus: LabBus, tmp_path: Path, traced: bool, bit: int, later: int
) -> None:
    a, b, _ = three(can_bus)
    if traced:
        can_bus.trace_levels(tmp_path / "levels.vcd")
    faults = can_bus.faults
    faults.hold("dominant", at=faults.place("intermission", bit, frame_id=0x123))
    a.send_many([FRAME, OTHER])
    lab.run_until_idle()
    first, second = ends(b)
    assert second - first == later + len_of(OTHER)
    assert (a.tec, b.rec, can_bus.error_frames) == (0, 0, 0)


def len_of(frame: Frame) -> int:
    from canwire import BitLayout

    return len(BitLayout(frame).levels)


def test_a_time_in_the_intermission_is_the_same_with_and_without_a_trace(tmp_path: Path) -> None:
    found = []
    for traced in (False, True):
        with Lab() as lab:
            bus = lab.can_bus("can", bit_rate=500_000)
            a, b, _ = three(bus)
            if traced:
                bus.trace_levels(tmp_path / "levels.vcd")
            bus.faults.hold("dominant", at=63 * BIT)
            a.send_many([FRAME, OTHER])
            lab.run_until_idle()
            found.append(ends(b))
    assert found[0] == found[1] == [62, 62 + 19 + len_of(OTHER)]


def test_a_disturbed_error_flag_begins_anew(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    faults = can_bus.faults
    faults.flip(bit=30, seen_by="sender")
    faults.hold("recessive", at=faults.place("error flag", 3), seen_by=a)
    a.send(FRAME)
    lab.run_until_idle()
    assert a.tec == 8 + 8 - 1
    assert (b.rec, c.rec) == (0, 0)


@pytest.mark.finding("wire-2 7")
@pytest.mark.parametrize("traced", [False, True])
@pytest.mark.parametrize("armed", [False, True])
@pytest.mark.parametrize("at_bits", [5, 30.5, 63.2])
def test_a_place_named_in_mid_frame_counts_in_that_frame(
    lab: Lab, can_bus: LabBus, tmp_path: Path, traced: bool, armed: bool, at_bits: float
) -> None:
    """Whether the bits were looked at before, and whether another disturbance waits already, changes nothing."""
    a, _, _ = three(can_bus)
    if traced:
        can_bus.trace_levels(tmp_path / "levels.vcd")
    faults = can_bus.faults
    if armed:
        faults.hold("dominant", at=faults.place("data", frame_id=0x7FF))
    a.send(FRAME)
    lab.run_until(round(at_bits * BIT))
    late = at_bits > len_of(FRAME)
    place = faults.place("intermission", 3) if late else faults.place("ack delimiter")
    held = faults.hold("dominant", at=place)
    lab.run_until(70 * BIT)
    assert held.struck == 1
    assert can_bus.error_frames == (0 if late else 1)


def test_several_nodes_see_what_the_others_do_not(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.hold("recessive", at=can_bus.faults.place("ack"), seen_by=[b, c])
    a.send(FRAME)
    lab.run_until_idle()
    assert (b.counters.errors, c.counters.errors) == (1, 1)
    assert a.counters.errors == 1  # their flags


def test_only_the_sender_or_only_the_receivers(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    place = can_bus.faults.place("eof", 7)
    can_bus.faults.hold("dominant", at=place, seen_by="receivers")
    a.send(FRAME)
    lab.run_until_idle()
    assert (a.tec, b.rec, c.rec, can_bus.frames) == (0, 0, 0, 1)
    can_bus.faults.hold("dominant", at=place, seen_by="sender")
    a.send(FRAME)
    lab.run_until_idle()
    assert (a.tec, b.rec, c.rec) == (7, 0, 0)
    assert [len(ends(b)), len(ends(c))] == [3, 3]  # the receivers took the disturbed one too


@pytest.mark.parametrize(("from_ns", "width_ns", "errors"), [(0, 1_500, 0), (1_600, 300, 0), (1_000, 600, 1)])
def test_a_glitch_matters_where_it_meets_the_sample_point(
    lab: Lab, can_bus: LabBus, from_ns: int, width_ns: int, errors: int
) -> None:
    a, _, _ = three(can_bus)
    assert (
        a.settings.timing.sample_time_ps // 1000 in range(1_500, 1_600)
        or a.settings.timing.sample_point == 0.875
    )
    sample_ns = a.settings.timing.sample_time_ps // 1000
    faults = can_bus.faults
    shift = sample_ns - 1_550
    faults.glitch(
        "recessive", at=faults.place("frame", 12), from_ns=from_ns + (shift if from_ns else 0), width_ns=width_ns,
        seen_by="sender",
    )  # fmt: skip
    a.send(FRAME)
    lab.run_until_idle()
    assert a.counters.errors == errors
    assert can_bus.frames == 1


def test_an_edge_that_moves_is_followed_or_not(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    timing = b.settings.timing
    faults = can_bus.faults
    edge = 4  # identifier 001 0...: bit 3 is recessive, bit 4 dominant
    for quanta, errors in ((1, 0), (-1, 0), (timing.quanta - 1, 1)):
        before = b.counters.errors
        faults.move_edge(quanta, at=faults.place("frame", edge), seen_by=b)
        a.send(FRAME)
        lab.run_until_idle()
        assert b.counters.errors - before == errors, quanta


def test_levels_bit_by_bit(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    faults = can_bus.faults
    faults.play(
        "000----0", at=faults.place("intermission", 1)
    )  # an overload flag from bit 2 on, one bit longer
    a.send_many([FRAME, OTHER])
    lab.run_until_idle()
    first, second = ends(b)
    assert second - first == 1 + 6 + 1 + 8 + 3 + len_of(OTHER)


def test_suspend_and_idle_time(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    faults = can_bus.faults
    for _ in range(16):
        faults.flip(bit=30, seen_by="sender")
    a.send(FRAME)
    lab.run_until_idle()
    assert a.state is ErrorState.ERROR_PASSIVE or a.tec == 127
    before = can_bus.error_frames
    faults.hold("dominant", at=faults.place("idle", 5))
    a.send(FRAME)
    lab.run_until_idle()
    assert can_bus.error_frames == before + 1  # five recessive bits behind that SOF: nobody's frame
    assert b.rec > 0


def test_as_often_as_asked(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    faults = can_bus.faults
    faults.hold("dominant", at=faults.place("crc delimiter", frame_id=0x123), times=2)
    a.send_many([OTHER, FRAME])
    lab.run_until_idle()
    assert can_bus.error_frames == 2
    faults.hold("dominant", at=faults.place("crc delimiter"), times=None)
    a.send(OTHER, single_shot=True)
    lab.run_until_idle()
    faults.clear()
    a.send(OTHER)
    lab.run_until_idle()
    assert can_bus.error_frames == 3
    assert len(ends(b)) == 3


def test_what_all_see_is_in_the_trace_and_what_one_sees_is_not(
    lab: Lab, can_bus: LabBus, tmp_path: Path
) -> None:
    a, b, _ = three(can_bus)
    path = tmp_path / "levels.vcd"
    can_bus.trace_levels(path)
    faults = can_bus.faults
    faults.glitch("dominant", at=faults.place("intermission", 3), from_ns=100, width_ns=300)
    faults.glitch("dominant", at=faults.place("intermission", 3), from_ns=700, width_ns=300, seen_by=b)
    a.send(FRAME)
    lab.run_until_idle()
    can_bus.end_trace()
    begin = (62 + 2) * BIT
    text = path.read_text()
    assert f"#{begin + 100}\n0!\n#{begin + 400}\n1!" in text
    assert f"#{begin + 700}\n" not in text


def test_frames_that_no_disturbance_can_meet_are_stepped_over(lab: Lab, can_bus: LabBus) -> None:
    a, _, _ = three(can_bus)
    faults = can_bus.faults
    faults.hold("dominant", at=faults.place("eof", 3, frame_id=0x700))
    a.send(FRAME)
    lab.run_for(20 * BIT / 1e9)
    assert can_bus.wire.bits.clocks == []
    a.send(Frame(0x700))
    lab.run_for(80 * BIT / 1e9)
    assert can_bus.wire.bits.clocks != []
    lab.run_until_idle()
    assert can_bus.error_frames == 1


@pytest.mark.parametrize("asked", [
    {"part": "middle"}, {"part": "intermission", "bit": 4}, {"part": "error delimiter", "bit": 1},
    {"part": "eof", "bit": 0},
])  # fmt: skip
def test_places_that_there_are_not(can_bus: LabBus, asked: dict[str, object]) -> None:
    with pytest.raises(BadValue):
        can_bus.faults.place(**asked)  # type: ignore[arg-type]


def test_disturbances_that_cannot_be(lab: Lab, can_bus: LabBus) -> None:
    a, _, _ = three(can_bus)
    faults = can_bus.faults
    place = faults.place("ack")
    with pytest.raises(BadValue, match="level"):
        faults.hold("low", at=place)
    with pytest.raises(BadValue, match="bits"):
        faults.hold("dominant", at=place, bits=0)
    with pytest.raises(BadValue, match="seen_by"):
        faults.hold("dominant", at=place, seen_by="nobody")
    with pytest.raises(BadValue, match="levels"):
        faults.play("01x", at=place)
    with pytest.raises(BadValue, match="wider"):
        faults.glitch("dominant", at=place, width_ns=0)
    with pytest.raises(BadValue, match="quanta"):
        faults.move_edge(1, at=place)
    with pytest.raises(BadValue, match="times"):
        faults.hold("dominant", at=place, times=0)
    with pytest.raises(BadValue, match="seen_by"):
        faults.hold("dominant", at=0, seen_by="sender")
    a.send(FRAME)
    lab.run_until_idle()
    with pytest.raises(BadValue, match="already"):
        faults.hold("dominant", at=0)
