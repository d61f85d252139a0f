"""Bus load in a rolling window against a list of everything that was ever busy."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.bus.load import BUCKET_NS, BUCKETS, BusLoad
from tests.cases import each

pytestmark = pytest.mark.core

SECOND = BUCKET_NS * BUCKETS


class Reference:
    """Every busy stretch kept; the window is the bucket that `now_ns` ends in and the nine before it."""

    def __init__(self) -> None:
        self.busy: list[tuple[int, int]] = []

    def between(self, start_ns: int, end_ns: int) -> int:
        return sum(max(0, min(end, end_ns) - max(start, start_ns)) for start, end in self.busy)

    def percent(self, now_ns: int) -> float:
        bucket = max(0, -(-now_ns // BUCKET_NS) - 1)
        start_ns = max(0, bucket - BUCKETS + 1) * BUCKET_NS
        return 100.0 * self.between(start_ns, now_ns) / (now_ns - start_ns) if now_ns else 0.0

    def peak(self, now_ns: int) -> float:
        buckets = range(0, now_ns + 1, BUCKET_NS)
        return max(100.0 * self.between(at, at + BUCKET_NS) / BUCKET_NS for at in buckets)


# gap before, busy time, and rest before the next look at the meter: from bits to many seconds
spans = st.one_of(
    st.integers(0, 300_000),
    st.integers(0, 2 * BUCKET_NS),
    st.sampled_from([0, BUCKET_NS, SECOND, 3 * SECOND]),
)
histories = st.lists(st.tuples(spans, spans, st.none() | spans), max_size=25)


@pytest.mark.conforms("G-16")
@given(histories)
def test_agrees_with_the_reference(history: list[tuple[int, int, int | None]]) -> None:
    load, reference = BusLoad(), Reference()
    now_ns = 0
    for gap_ns, busy_ns, rest_ns in history:
        start_ns, now_ns = now_ns + gap_ns, now_ns + gap_ns + busy_ns
        load.add(start_ns, now_ns)
        reference.busy.append((start_ns, now_ns))
        if rest_ns is not None:
            now_ns += rest_ns
            assert load.percent(now_ns) == pytest.approx(reference.percent(now_ns), abs=1e-9)
        assert load.peak() == pytest.approx(reference.peak(now_ns), abs=1e-9)
    assert load.busy_ns == sum(end - start for start, end in reference.busy)


@pytest.mark.conforms("G-16")
@given(st.lists(st.tuples(spans, spans.filter(bool), st.floats(0, 1)), max_size=25))
def test_never_above_100_percent(history: list[tuple[int, int, float]]) -> None:
    """Somebody also looks in the middle of a frame, which is added once it has ended."""
    load = BusLoad()
    now_ns = 0
    for gap_ns, busy_ns, part in history:
        start_ns, now_ns = now_ns + gap_ns, now_ns + gap_ns + busy_ns
        assert 0.0 <= load.percent(start_ns + int(part * busy_ns)) <= 100.0
        load.add(start_ns, now_ns)
        assert 0.0 <= load.percent(now_ns) <= 100.0
        assert 0.0 <= load.peak() <= 100.0


@pytest.mark.conforms("G-16")
@each("frame_ns", [111_000, 130_000, 1_100_000, 7_000_000])
def test_a_saturated_bus_shows_100_percent(frame_ns: int) -> None:
    load = BusLoad()
    for start_ns in range(0, 3 * SECOND, frame_ns):
        load.add(start_ns, start_ns + frame_ns)
        assert load.percent(start_ns + frame_ns) == pytest.approx(100.0)
    assert load.peak() == pytest.approx(100.0)


@pytest.mark.conforms("G-16")
def test_looking_into_a_frame_spoils_no_peak() -> None:
    """A saturated 10 kbit/s bus: a frame of 11 ms lies across the end of a bucket while somebody looks."""
    load = BusLoad()
    frame_ns = 11_000_000
    for start_ns in range(0, SECOND, frame_ns):
        load.percent(start_ns + frame_ns // 2)
        load.add(start_ns, start_ns + frame_ns)
    assert load.peak() == pytest.approx(100.0)


@each("percent", [0, 25, 50, 75, 100])
def test_a_known_schedule(percent: int) -> None:
    load = BusLoad()
    period_ns = 10_000_000
    for start_ns in range(0, 2 * SECOND, period_ns):
        load.add(start_ns, start_ns + period_ns * percent // 100)
    assert load.percent(2 * SECOND) == pytest.approx(percent)
    assert load.peak() == pytest.approx(percent)


def test_what_is_longer_ago_than_a_second_is_forgotten() -> None:
    load = BusLoad()
    load.add(0, SECOND)
    assert load.percent(SECOND) == 100.0
    assert load.percent(SECOND + SECOND // 2) == pytest.approx(50.0)
    assert load.percent(2 * SECOND) == 0.0
    assert load.percent(1000 * SECOND) == 0.0
    assert (load.peak(), load.busy_ns) == (100.0, SECOND)


def test_before_anything_happened() -> None:
    load = BusLoad()
    assert (load.percent(0), load.peak(), load.busy_ns) == (0.0, 0.0, 0)
