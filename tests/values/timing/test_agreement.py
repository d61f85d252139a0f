"""Whether nodes could understand each other: figures by hand, and against the bus bit by bit."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

import canwire
from canwire import (
    BitTiming,
    ControllerOptions,
    DelayCompensation,
    Frame,
    NodeTiming,
    TimingCheck,
    timing_checks,
    timing_findings,
)
from canwire.errors import BadTiming
from tests.cases import each

pytestmark = pytest.mark.conforms("N-62")

_CLOCK_HZ = 80_000_000


def node(
    name: str, rate: int, point: float, data: int = 0, data_point: float = 0.8, **more: object
) -> NodeTiming:
    """Sample points as parts of the bit."""
    phase = BitTiming.for_bit_rate(data, data_point, clock_hz=_CLOCK_HZ) if data else None
    return NodeTiming(name, BitTiming.for_bit_rate(rate, point, clock_hz=_CLOCK_HZ), phase, **more)  # type: ignore[arg-type]


def found(nodes: list[NodeTiming], delay_ps: int = 0) -> dict[str, TimingCheck]:
    return {check.what: check for check in timing_checks(nodes, delay_ps)}


@pytest.mark.finding("wire-2 1")
def test_nominal_sample_points_that_differ_shift_the_data_phase() -> None:
    (told,) = timing_findings([node("a", 500_000, 0.875, 4_000_000), node("b", 500_000, 0.75, 4_000_000)])

    assert (told.what, told.nodes, told.figure) == ("sample points", ("b", "a"), 250.0)
    assert told.limit == 37.5  # 50 ns behind the sample point, less a quantum
    assert str(told) == (
        "b (75 % and 80 % after BRS) and a (87.5 % and 80 % after BRS) switch to the data rate (4000000 bit/s) at "
        "different times: 250 ns, at most 37.5 ns; give both the same sample points (ISO 11898-1)"
    )


@pytest.mark.parametrize(("rate", "data", "point"), [(500_000, 2_000_000, 0.8), (1_000_000, 8_000_000, 0.75)])
def test_equal_timings_are_fine(rate: int, data: int, point: float) -> None:
    nodes = [node("a", rate, point, data), node("b", rate, point, data)]
    assert timing_findings(nodes) == []


def test_classic_nodes_bear_different_sample_points() -> None:
    checks = found([node("a", 500_000, 0.875), node("b", 500_000, 0.75)])

    assert not any(check.exceeded for check in checks.values())
    assert set(checks) == {"oscillators", "cable"}
    assert checks["oscillators"].limit == pytest.approx(
        100 * 250 / (13 * 2_000 - 250)
    )  # condition II at 87.5 %
    assert checks["cable"].limit == 1_500


def test_a_cable_that_is_too_long_for_its_rate() -> None:
    nodes = [node("a", 1_000_000, 0.75), node("b", 1_000_000, 0.75)]

    (told,) = timing_findings(nodes, delay_ps=(100 * 5 + 250) * 1000)

    assert (told.what, told.figure, told.limit, told.margin) == ("cable", 1_500, 750, -750)
    assert timing_findings(nodes, delay_ps=(25 * 5 + 250) * 1000) == []
    assert found(nodes[:1], delay_ps=750_000) == {}  # a node alone has nobody to wait for


def test_oscillators_beyond_what_the_receiver_bears() -> None:
    timing = BitTiming.from_btr(0x00, 0x14)  # bears 0.625 % each
    off = [NodeTiming("a", timing, ppm=6_000), NodeTiming("b", timing, ppm=-6_600)]
    near = [NodeTiming("a", timing, ppm=6_000), NodeTiming("b", timing, ppm=-6_400)]

    (told,) = timing_findings(off)

    assert (told.what, round(told.figure, 6), told.limit) == ("oscillators", 1.26, 1.25)
    assert "condition I)" in str(told)
    assert timing_findings(near) == []
    assert timing_findings([NodeTiming(name, timing, within_ppm=6_251) for name in "ab"]) != []


def test_data_jump_shorter_than_a_nominal_quantum() -> None:
    nominal = BitTiming(10, 12, 3, 3, clock_hz=_CLOCK_HZ)
    data = BitTiming(1, 31, 8, 8, clock_hz=_CLOCK_HZ)

    assert (
        timing_findings([NodeTiming(name, nominal, data) for name in "ab"]) == []
    )  # they do not drift at all
    (told,) = timing_findings([NodeTiming(name, nominal, data, within_ppm=1) for name in "ab"])

    assert (told.what, told.limit) == ("oscillators", 0)
    assert "condition V)" in str(told)
    assert "same prescaler" in told.remedy


@pytest.mark.parametrize(
    ("other", "what"),
    [((250_000, 0.8, 2_000_000), "bit rates"), ((500_000, 0.8, 4_000_000), "data bit rates")],
)
def test_different_rates(other: tuple[int, float, int], what: str) -> None:
    told = timing_findings([node("a", 500_000, 0.8, 2_000_000), node("b", *other)])
    assert [check.what for check in told] == [what]


@each(
    ("options", "broken"),
    [
        (ControllerOptions(loop_delay_ns=90), False),
        (ControllerOptions(loop_delay_ns=110), True),
        (ControllerOptions(loop_delay_ns=250, compensation=DelayCompensation()), False),
        (ControllerOptions(loop_delay_ns=250, compensation=DelayCompensation(130)), True),
        (ControllerOptions(loop_delay_ns=250, compensation=DelayCompensation(200, measured=False)), True),
        (ControllerOptions(loop_delay_ns=250, compensation=DelayCompensation(340, measured=False)), False),
    ],
)
def test_a_sender_reads_its_own_bits_in_time(options: ControllerOptions, broken: bool) -> None:
    nodes = [node(name, 1_000_000, 0.8, 8_000_000, options=options) for name in "ab"]
    assert [check.what for check in timing_findings(nodes)] == ["delay compensation"] * broken


def test_many_nodes_are_named_in_a_few_words() -> None:
    nodes = [node(f"n{k}", 500_000, 0.8) for k in range(100)] + [node("x", 250_000, 0.8)]

    (told,) = timing_findings(nodes)

    assert len(told.nodes) == 101
    assert "n0, n1, n2 and 97 more" in str(told)


def drawn(random: Random) -> tuple[BitTiming, BitTiming, BitTiming, BitTiming]:
    """Both phases of two nodes of the same rates."""
    rate, data = (
        random.choice([250_000, 500_000, 1_000_000]),
        random.choice([2_000_000, 4_000_000, 8_000_000]),
    )
    while True:
        try:
            phases = [
                BitTiming.for_bit_rate(rate, random.uniform(0.6, 0.9), clock_hz=_CLOCK_HZ) for _ in "ab"
            ]
            points = random.uniform(0.5, 0.8), random.uniform(0.5, 0.8)
            fast = [BitTiming.for_bit_rate(data, point, clock_hz=_CLOCK_HZ) for point in points]
        except BadTiming:
            continue
        if random.random() < 0.6:  # most that are drawn would be broken
            phases[1] = BitTiming.for_bit_rate(rate, phases[0].sample_point + 0.01, clock_hz=_CLOCK_HZ)
        return phases[0], fast[0], phases[1], fast[1]


@pytest.mark.conforms("G-13")
def test_what_is_said_is_what_happens_bit_by_bit(tmp_path: Path) -> None:
    """1,400 such pairs agreed when this was written; here are some."""
    random, seen = Random(27), set()
    for _ in range(24):
        one, fast, other, other_fast = drawn(random)
        broken = timing_findings([NodeTiming("a", one, fast), NodeTiming("b", other, other_fast)])
        with canwire.Lab() as lab:
            bus = lab.can_bus("can0", timing=one, data_timing=fast)
            nodes = bus.node("a"), bus.node("b", timing=other, data_timing=other_fast)
            bus.trace_levels(tmp_path / "levels.vcd")
            payloads = bytes(64), b"\x55" * 64, b"\xff" * 20, bytes(range(48))
            for number, data in enumerate(payloads):
                nodes[number % 2].send(Frame(0x100 + number, data, fd=True, bit_rate_switch=True))
            lab.run_for(0.02)
            assert bool(bus.error_frames) == bool(broken), (one, fast, other, other_fast, broken)
            assert bus.warnings == broken
        seen.add(bool(broken))
    assert seen == {True, False}
