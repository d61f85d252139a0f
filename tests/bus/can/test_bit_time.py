"""How long the bus is busy: exact to the bit, at one bit rate and at two."""

from __future__ import annotations

import itertools
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import Frame, Lab, LabBus, NodeScript
from tests.tables.frame_vectors import CLASSIC, FD, FRAME_RATES

pytestmark = pytest.mark.core

BOTH_WAYS = pytest.mark.parametrize("bitwise", [False, True], ids=["whole frames", "bit by bit"])
INTERMISSION = 3
SHORTEST_8 = Frame(0x2AA, b"\xaa" * 8)  # C08: 108 bits, without a single stuff bit
SHORTEST_0 = Frame(0x084)


def frame_of(vector: Any) -> Frame:
    return Frame(vector.id, vector.data, **vector.keywords)


def ends(lab: Lab, frames: list[Frame], *, bitwise: bool = False, **rates: int) -> list[int]:
    """When each of the frames, sent at once at 0, was over."""
    bus = lab.can_bus("measured", **rates)
    bus.wire.bitwise = bitwise
    sender, receiver = bus.node("sender"), bus.node("receiver")
    sender.send_many(frames)
    lab.run_until_idle()
    return [frame.timestamp_ns for frame in receiver.receive_many(len(frames))]


@pytest.mark.conforms("G-06")
@BOTH_WAYS
@pytest.mark.parametrize("vector", CLASSIC, ids=lambda vector: vector.name)
def test_classic_vectors_to_the_nanosecond(lab: Lab, vector: Any, bitwise: bool) -> None:
    bit_ns = 8_000
    first, second = ends(lab, [frame_of(vector)] * 2, bitwise=bitwise, bit_rate=125_000)
    assert first == vector.bits * bit_ns
    assert second == (2 * vector.bits + INTERMISSION) * bit_ns


@pytest.mark.conforms("G-06")
@BOTH_WAYS
@pytest.mark.parametrize("vector", FD, ids=lambda vector: vector.name)
def test_fd_vectors_to_the_nanosecond(lab: Lab, vector: Any, bitwise: bool) -> None:
    """One bit has both rates: BRS, up to its sample point, and the CRC delimiter from there on.

    With the same sample point in both phases the two halves make one bit of each.
    """
    nominal_ns, data_ns = 2_000, 500
    (end,) = ends(lab, [frame_of(vector)], bitwise=bitwise, bit_rate=500_000, data_bit_rate=2_000_000)
    fast = vector.data_bits + 1 if vector.data_bits else 0
    assert end == (vector.bits - fast) * nominal_ns + fast * data_ns


@pytest.mark.conforms("G-06")
@BOTH_WAYS
@pytest.mark.parametrize(("name", "end_ns"), [("D06", 122_000), ("D12", 343_500)])
def test_two_rates_worked_out_by_hand(lab: Lab, name: str, end_ns: int, bitwise: bool) -> None:
    vector = next(vector for vector in FD if vector.name == name)
    rates = {"bit_rate": 500_000, "data_bit_rate": 2_000_000}
    assert ends(lab, [frame_of(vector)], bitwise=bitwise, **rates) == [end_ns]


@pytest.mark.conforms("G-06")
@pytest.mark.parametrize("kilobits", FRAME_RATES, ids=lambda rate: f"{rate}k")
def test_best_case_frames_per_second(lab: Lab, kilobits: int) -> None:
    """The table of can-protocol.md section 9, its best cases."""
    shortest, best, _, extended_best, _ = FRAME_RATES[kilobits]
    extended = Frame(0x15555555, b"\x55" * 8, extended=True)  # C27
    for name, frame, rate in [
        ("SFF0", SHORTEST_0, shortest),
        ("SFF8", SHORTEST_8, best),
        ("EFF8", extended, extended_best),
    ]:
        bus = lab.can_bus(name, bit_rate=1000 * kilobits)
        sender, receiver = bus.node("sender"), bus.node("receiver", receive_queue=32_768)
        sender.send_many([frame] * min(rate // 10 + 10, 3000))
        start_ns = lab.now_ns
        lab.run_until_idle()
        times = [frame.timestamp_ns - start_ns for frame in receiver.receive_many(9999)]
        # a frame and its intermission are one period
        period_ns = times[1] - times[0]
        assert {later - earlier for earlier, later in itertools.pairwise(times)} == {period_ns}
        assert 10**9 // period_ns == rate


@pytest.mark.conforms("G-06")
def test_saturated_1_mbit_reaches_9009_frames_in_a_second_and_no_more(lab: Lab) -> None:
    bus = lab.can_bus(bit_rate=1_000_000)
    a, receiver = bus.node("a"), bus.node("receiver")
    a.send_many([SHORTEST_8] * 9100)
    lab.run_for(1.0)
    assert (bus.frames, receiver.waiting) == (9009, 9009)


@pytest.mark.conforms("G-06")
@settings(deadline=None)
@given(
    payloads=st.lists(st.binary(min_size=8, max_size=8), min_size=5, max_size=30), id=st.integers(0, 0x7FF)
)
def test_no_standard_8_byte_traffic_is_faster(payloads: list[bytes], id: int) -> None:
    with Lab() as lab:
        times = ends(lab, [Frame(id, data) for data in payloads], bit_rate=1_000_000)
        gaps_ns = [later - earlier for earlier, later in itertools.pairwise(times)]
        assert min(gaps_ns) >= 111_000
        assert max(gaps_ns) <= 135_000
        assert all(gap_ns % 1000 == 0 for gap_ns in gaps_ns)


def test_bit_times_that_are_no_whole_nanoseconds_do_not_drift(lab: Lab) -> None:
    bus = lab.can_bus(bit_rate=80_000_000 // 243)  # 3037.5 ns a bit
    assert bus.timing.bit_time_ps == 3_037_500
    sender, receiver = bus.node("sender"), bus.node("receiver")
    sender.send_many([SHORTEST_8] * 1001)
    lab.run_until_idle()
    last = receiver.receive_many(1001)[-1]
    assert last.timestamp_ns == (1001 * 111 - INTERMISSION) * 3_037_500 // 1000


def test_a_frame_starts_when_it_is_sent_on_an_idle_bus(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    lab.run_until(1_234_567)
    a.send(SHORTEST_8)
    lab.run_until_idle()
    frame = b.receive()
    assert frame is not None
    assert frame.timestamp_ns == 1_234_567 + 108 * 2000


def test_a_frame_sent_in_the_intermission_starts_after_it(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(SHORTEST_8)
    lab.run_until(109 * 2000 + 77)
    b.send(SHORTEST_8)
    frame = a.receive(timeout=1.0)
    assert frame is not None
    assert frame.timestamp_ns == (108 + 3 + 108) * 2000


# load


LOADS = [next(vector for vector in CLASSIC if vector.name == name) for name in ("C08", "C07", "C31", "C15")]


class Schedule(NodeScript):
    """One frame, again and again, beginning with the first period's end."""

    def __init__(self, frame: Frame, period_s: float) -> None:
        self.frame = frame
        self.period_s = period_s

    def on_start(self) -> None:
        self.every(self.period_s, lambda: self.send(self.frame))


@pytest.mark.conforms("G-16")
@BOTH_WAYS
@pytest.mark.parametrize(
    "periods_ms",
    [[10], [1], [5, 7], [2, 3, 10, 100], [1, 1, 1.5, 50]],
    ids=lambda periods: "-".join(map(str, periods)),
)
def test_load_of_a_known_schedule(lab: Lab, can_bus: LabBus, periods_ms: list[float], bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    can_bus.node("listener", receives=False)
    computed = 0.0
    for vector, period_ms in zip(LOADS, periods_ms, strict=False):
        can_bus.node(vector.name, Schedule(frame_of(vector), period_ms / 1000), receives=False)
        computed += 100.0 * (vector.bits + INTERMISSION) * 0.002 / period_ms
    lab.run_for(0.3 if bitwise else 2.0)
    assert computed < 100
    assert can_bus.load == pytest.approx(computed, abs=1.0)
    assert can_bus.mean_load == pytest.approx(computed, abs=1.0)
    assert can_bus.peak_load >= computed - 1.0


@pytest.mark.conforms("G-16")
def test_load_counts_both_rates_in_bus_time(lab: Lab, can_bus: LabBus) -> None:
    frame = Frame(0x456, bytes(range(12)), fd=True, bit_rate_switch=True)  # D06: 122 us
    can_bus.node("sender", Schedule(frame, 0.001))
    can_bus.node("receiver", receives=False)
    lab.run_for(2.0)
    assert can_bus.load == pytest.approx(12.8, abs=0.2)  # 122 us and 6 us of intermission each millisecond


@pytest.mark.conforms("G-16")
def test_a_saturated_bus_has_100_percent_and_never_more(lab: Lab) -> None:
    bus = lab.can_bus(bit_rate=1_000_000)
    a, b = bus.node("a"), bus.node("b", receives=False)
    b.send_many([Frame(0x7FF, bytes(8))] * 12_000)
    a.send_many([Frame(0x123)] * 12_000)
    loads = []
    for _ in range(90):
        lab.run_for(0.011_117)
        loads += [bus.load, bus.mean_load, bus.peak_load]
    assert max(loads) <= 100.0
    assert min(loads[0::3]) >= 99.999
    assert min(loads[1::3]) >= 99.999
    assert a.pending + b.pending > 0


@pytest.mark.conforms("G-16")
def test_load_of_a_bus_full_of_errors_is_100_percent_too(lab: Lab, can_bus: LabBus) -> None:
    a = can_bus.node("a")
    a.send(Frame(0x1))
    lab.run_for(0.001)  # error active still: no suspend times
    assert can_bus.error_frames > 5
    assert 99.999 <= can_bus.load <= 100.0


@pytest.mark.finding("wire-2 7")
@BOTH_WAYS
def test_an_intermission_counts_only_as_it_passes(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    a, b = can_bus.node("a"), can_bus.node("b")
    lab.run_until(108 * 2000)
    a.send(SHORTEST_8)
    assert b.receive(timeout=1.0) is not None
    assert (can_bus.load, can_bus.mean_load) == (50.0, 50.0)
    lab.run_for(0.000_002)
    assert can_bus.wire.busy_ns() == 109 * 2000
    assert can_bus.load == pytest.approx(100 * 109 / 217)


@pytest.mark.conforms("G-16")
def test_load_falls_to_nothing_within_a_second_of_silence(lab: Lab, can_bus: LabBus) -> None:
    a, _ = can_bus.node("a"), can_bus.node("b")
    a.send_many([Frame(0x1, bytes(8))] * 2000)
    lab.run_until_idle()
    assert can_bus.load > 99
    lab.run_for(0.000_01)  # the last intermission
    peak = can_bus.peak_load
    busy_s = can_bus.mean_load / 100 * lab.now_ns / 1e9
    lab.run_for(1.2)
    assert can_bus.load == 0.0
    assert can_bus.peak_load == peak
    assert can_bus.mean_load == pytest.approx(100 * busy_s / (lab.now_ns / 1e9))


def test_load_before_anything_happened(lab: Lab, can_bus: LabBus) -> None:
    assert (can_bus.load, can_bus.mean_load, can_bus.peak_load, can_bus.frames) == (0.0, 0.0, 0.0, 0)
