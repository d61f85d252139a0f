"""Message generators and ranges: the manual's examples, on a clock that stands until it is moved."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue
from canwire.candrv import CandrvError
from canwire.web.cancheck.generators import MS, RETRY_NS, Generators
from canwire.web.cancheck.recipe import Outgoing, Range, Recipe


def example(*, wrap: bool = True, repeat: bool = True, delay_ms: int = 2000) -> Recipe:
    """The manual's: extended 0x025E0235, bytes 00 to 11, 11 to 22, 33 to 00."""
    return Recipe(
        Range(0x025E0235, 0x025E0235),
        (Range(0x00, 0x11), Range(0x11, 0x22), Range(0x33, 0x00)),
        extended=True,
        delay_ms=delay_ms,
        use_range=True,
        wrap=wrap,
        repeat=repeat,
    )


def fixed(identifier: int = 0x100, delay_ms: int = 10) -> Recipe:
    return Recipe(Range(identifier, identifier), delay_ms=delay_ms)


class Bench:
    """Generators, a clock, and a send buffer with so much room."""

    def __init__(self) -> None:
        self.now_ns = 0
        self.room = 1 << 30
        self.broken = False
        self.sent: list[tuple[int, int, Outgoing]] = []
        self.generators = Generators(self._send, lambda: self.now_ns)

    def _send(self, index: int, message: Outgoing) -> bool:
        if self.broken:
            raise CandrvError(1617, "CID1:")
        if len(self.sent) >= self.room:
            return False
        self.sent.append((self.now_ns // MS, index, message))
        return True

    def run(self, ms: int) -> None:
        end_ns = self.now_ns + ms * MS
        while True:
            wait_ns = self.generators.fire()
            if wait_ns is None or self.now_ns + wait_ns > end_ns:
                self.now_ns = end_ns
                return
            self.now_ns += wait_ns

    def data(self) -> list[str]:
        return [message.data.hex(" ").upper() for _, _, message in self.sent]


@pytest.fixture
def bench() -> Bench:
    return Bench()


# ranges


@pytest.mark.conforms("FT-18")
@pytest.mark.conforms("FT-15")
def test_example_1(bench: Bench) -> None:
    bench.generators.add(example(), active=True)
    bench.run(2000 * 59)
    sent = bench.data()
    assert len(sent) == 60
    assert sent[:3] == ["00 11 33", "01 12 32", "02 13 31"]
    assert sent[18 - 1] == "11 22 22"
    assert sent[19 - 1] == "00 11 21"
    assert sent[52 - 1] == "0F 20 00"
    assert sent[53 - 1] == "10 21 33"
    assert {(message.identifier, message.extended) for _, _, message in bench.sent} == {(0x025E0235, True)}
    assert [ms for ms, _, _ in bench.sent] == list(range(0, 2000 * 60, 2000))
    assert bench.generators.rows()[0].due_ns is not None


@pytest.mark.conforms("FT-16")
def test_example_2_sends_52_messages_and_pauses(bench: Bench) -> None:
    bench.generators.add(example(repeat=False), active=True)
    bench.run(2000 * 1000)
    assert len(bench.sent) == 0x34
    assert bench.data()[-1] == "0F 20 00"
    assert bench.generators.rows()[0].due_ns is None


@pytest.mark.conforms("FT-16")
def test_activated_again_it_runs_the_same_cycle_once_more(bench: Bench) -> None:
    bench.generators.add(example(repeat=False), active=True)
    bench.run(2000 * 1000)
    bench.generators.activate(0)
    bench.run(2000 * 1000)
    assert len(bench.sent) == 2 * 52
    assert bench.data()[52:] == bench.data()[:52]


@pytest.mark.conforms("FT-15")
def test_without_wrap_values_stay_at_to_while_others_go_on(bench: Bench) -> None:
    bench.generators.add(example(wrap=False), active=True)
    bench.run(2000 * 59)
    sent = bench.data()
    assert sent[18 - 1] == "11 22 22"
    assert sent[19 - 1] == "11 22 21"
    assert sent[52 - 1] == sent[53 - 1] == sent[60 - 1] == "11 22 00"


@pytest.mark.conforms("FT-15")
def test_the_identifier_has_a_range_too(bench: Bench) -> None:
    bench.generators.add(
        Recipe(Range(0x102, 0x100), delay_ms=1, use_range=True, wrap=True, repeat=True), active=True
    )
    bench.run(4)
    assert [message.identifier for _, _, message in bench.sent] == [0x102, 0x101, 0x100, 0x102, 0x101]


@pytest.mark.conforms("FT-15")
@given(first=st.integers(0, 255), last=st.integers(0, 255), step=st.integers(0, 2000))
def test_values_step_by_one_and_keep_between_from_and_to(first: int, last: int, step: int) -> None:
    one = Range(first, last)
    low, high = sorted((first, last))
    wrapping = [one.at(step + more, wrap=True) for more in range(2)]
    assert all(low <= value <= high for value in wrapping)
    if wrapping[0] == last:
        assert wrapping[1] == first
    else:
        assert wrapping[1] - wrapping[0] == (1 if last > first else -1)
    assert one.at(step, wrap=False) == (last if step >= one.difference else wrapping[0])


@pytest.mark.conforms("FT-15")
def test_without_use_range_it_repeats_one_message_for_ever(bench: Bench) -> None:
    bench.generators.add(Recipe(Range(1, 9), (Range(0, 9),), delay_ms=1), active=True)
    bench.run(100)
    assert {message for _, _, message in bench.sent} == {Outgoing(1, False, False, 1, b"\0")}
    assert len(bench.sent) == 101


@pytest.mark.conforms("FT-14")
def test_a_remote_message_has_a_length_and_no_data(bench: Bench) -> None:
    bench.generators.add(Recipe(Range(1, 1), (Range(5, 5),) * 3, rtr=True), active=True)
    bench.run(0)
    assert bench.sent[0][2] == Outgoing(1, False, True, 3, b"")


@pytest.mark.conforms("FT-14")
def test_more_than_eight_bytes_are_refused() -> None:
    with pytest.raises(BadValue, match="9 data bytes"):
        Recipe(Range(1, 1), (Range(0, 0),) * 9)


# the list


@pytest.mark.conforms("FT-13")
def test_a_row_shows_what_comes_next_and_when(bench: Bench) -> None:
    bench.generators.add(example(), active=True)
    bench.run(2000)
    (row,) = bench.generators.rows()
    assert (row.number, row.due_ns, row.message.data.hex()) == (0, 4000 * MS, "021331")
    bench.generators.pause(0)
    (row,) = bench.generators.rows()
    assert (row.due_ns, row.message.data.hex()) == (None, "021331")


@pytest.mark.conforms("FT-13")
def test_a_paused_range_goes_on_where_it_stood(bench: Bench) -> None:
    bench.generators.add(example(), active=True)
    bench.run(2000)
    bench.generators.pause(0)
    bench.run(60_000)
    assert len(bench.sent) == 2
    bench.generators.activate(0)
    bench.run(0)
    assert bench.data()[-1] == "02 13 31"


@pytest.mark.conforms("FT-14")
def test_all_are_paused_and_activated_at_once(bench: Bench) -> None:
    for identifier in (1, 2, 3):
        bench.generators.add(fixed(identifier), active=False)
    bench.run(100)
    assert bench.sent == []
    bench.generators.activate_all()
    bench.run(0)
    assert [index for _, index, _ in bench.sent] == [0, 1, 2]
    bench.generators.pause_all()
    assert {row.due_ns for row in bench.generators.rows()} == {None}
    assert bench.generators.fire() is None


@pytest.mark.conforms("FT-14")
def test_activating_an_active_one_changes_nothing(bench: Bench) -> None:
    bench.generators.add(fixed(), active=True)
    bench.run(5)
    bench.generators.activate(0)
    bench.run(5)
    assert [ms for ms, _, _ in bench.sent] == [0, 10]


@pytest.mark.finding("page 18")
@pytest.mark.conforms("FT-13")
def test_any_number_of_them_keep_their_cycles_and_unknown_ones_are_named(bench: Bench) -> None:
    for number in range(1000):
        bench.generators.add(fixed(number, delay_ms=1000), active=True)
    with pytest.raises(BadValue, match="generator 3E8: there are 1000"):
        bench.generators.activate(1000)
    bench.generators.pause(998)
    bench.run(2000)
    assert [index for _, index, _ in bench.sent] == [one for one in range(1000) if one != 998] * 3


def test_one_that_is_paused_and_activated_before_it_is_due_sends_once_a_cycle(bench: Bench) -> None:
    bench.generators.add(fixed(delay_ms=100), active=True)
    bench.run(50)
    for _ in range(3):
        bench.generators.pause(0)
        bench.generators.activate(0)
    bench.run(100)
    assert [ms for ms, _, _ in bench.sent] == [0, 50, 150]


# editing


@pytest.mark.conforms("FT-17")
@pytest.mark.parametrize("active", [True, False])
def test_editing_pauses_and_cancel_brings_the_state_before(bench: Bench, active: bool) -> None:
    bench.generators.add(fixed(), active=active)
    bench.run(5)
    count = len(bench.sent)
    assert bench.generators.begin_edit(0) == fixed()
    bench.run(1000)
    assert len(bench.sent) == count
    assert bench.generators.rows()[0].due_ns is None
    bench.generators.cancel_edit(0)
    bench.run(0)
    assert len(bench.sent) == count + active
    assert bench.generators.recipe(0) == fixed()


@pytest.mark.conforms("FT-17")
def test_activate_takes_the_new_settings_and_sends_at_once(bench: Bench) -> None:
    bench.generators.add(fixed(), active=True)
    bench.run(5)
    bench.generators.begin_edit(0)
    bench.generators.change(0, fixed(0x200, 50), active=True)
    bench.run(50)
    assert [(ms, message.identifier) for ms, _, message in bench.sent] == [
        (0, 0x100),
        (5, 0x200),
        (55, 0x200),
    ]


@pytest.mark.conforms("FT-17")
def test_pause_takes_the_new_settings_and_sends_nothing(bench: Bench) -> None:
    bench.generators.add(fixed(), active=True)
    bench.run(5)
    bench.generators.begin_edit(0)
    bench.generators.change(0, fixed(0x200), active=False)
    bench.generators.cancel_edit(0)  # too late
    bench.run(500)
    assert len(bench.sent) == 1
    assert bench.generators.rows()[0].message.identifier == 0x200


# what the manual leaves open: docs/cancheck.md


@pytest.mark.conforms("FT-14")
def test_delay_0_sends_as_fast_as_there_is_room_and_others_get_their_turn(bench: Bench) -> None:
    bench.room = 1000
    for identifier in (1, 2):
        bench.generators.add(fixed(identifier, 0), active=True)
    while len(bench.sent) < bench.room:
        assert bench.generators.fire() == 0 or len(bench.sent) == bench.room
    assert [index for _, index, _ in bench.sent] == [0, 1] * 500


@pytest.mark.conforms("FT-13")
def test_a_full_buffer_lets_it_wait_and_no_message_is_skipped(bench: Bench) -> None:
    bench.room = 2
    bench.generators.add(example(delay_ms=10), active=True)
    bench.run(1000)
    assert bench.generators.rows()[0].waits
    assert bench.generators.fire() == RETRY_NS
    bench.room = 5
    bench.run(30)
    assert bench.data() == ["00 11 33", "01 12 32", "02 13 31", "03 14 30", "04 15 2F"]
    gaps = [bench.sent[i + 1][0] - bench.sent[i][0] for i in range(2, 4)]
    assert gaps == [10, 10]  # no burst of what was missed


@pytest.mark.conforms("FT-13")
def test_what_fails_is_paused_and_told(bench: Bench) -> None:
    bench.broken = True
    bench.generators.add(fixed(), active=True)
    assert bench.generators.fire() is None
    (row,) = bench.generators.rows()
    assert row.due_ns is None
    assert "1617" in row.trouble
