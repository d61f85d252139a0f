"""Where each node's own bits begin and end between frames, and what happens in the middle of them.

Scenarios by hand, in which the bus once did something else than the rules; 500 kbit/s, 2 Mbit/s in data phases.
"""

from __future__ import annotations

import pytest

from canwire import Frame
from canwire.bus.can import station as states
from tests.bus.can.reference.compare import differences
from tests.bus.can.reference.frames import Heard
from tests.bus.can.reference.node import Order
from tests.bus.can.reference.players import Outcome, on_the_bench
from tests.bus.can.reference.schedule import Member, Schedule
from tests.bus.can.test_around_frames import Recorder, in_third_bit, offered
from tests.cases import each

pytestmark = pytest.mark.core

BIT_NS = 2_000
ACTIVE, PASSIVE = 0, 200  # TEC
EOF_END = 62 * BIT_NS  # of classic(0x100), whose SOF is at 0
RECESSIVE, DOMINANT = 1, 0


def classic(id: int) -> Order:
    return Order(Heard(id, False, False, False, False, False, 2, b"\x55\x55"), False)


def flexible(id: int) -> Order:
    return Order(Heard(id, False, False, True, True, False, 8, b"\x55" * 8), False)


def scene(*tecs: int, end_ns: int = 900_000) -> Schedule:
    return Schedule([Member(True, False, tec, 0) for tec in tecs], end_ns)


def agreed(schedule: Schedule) -> Outcome:
    """What came of it, both ways and by the rules."""
    assert differences(schedule) == []
    return on_the_bench(schedule, bitwise=False)


def ends(outcome: Outcome, node: int) -> list[tuple[int, int]]:
    """When this node received which identifiers."""
    return [(at_ns, heard.id) for at_ns, heard in outcome.received[node]]


# an SOF in the intermission, or right behind it


def test_who_joins_an_sof_in_the_third_bit_drives_nothing_before_its_next_bit() -> None:
    node = Recorder()
    clock = in_third_bit(node)
    node.offer = offered(Frame(0x400))
    station = clock.station
    station.sample(0)
    assert (station.transmitting, station.out) == (True, 1)
    station.begin_bit()
    assert (station.index, station.out) == (1, 1)
    assert station.state == states.FRAME


def test_an_edge_in_the_second_bit_of_the_intermission_is_a_hard_synchronisation() -> None:
    """ISO 11898-1: in the interframe space but for the first bit of the intermission."""
    scenario = scene(ACTIVE, ACTIVE, ACTIVE)
    scenario.sends = [(0, 0, classic(0x100)), (0, 1, classic(0x101))]
    scenario.holds = [(EOF_END + 3_000, 1, DOMINANT, None)]
    # the overload flag begins a bit behind the edge, not behind the boundary 1 us earlier
    overload_ns = 6 + 8 + 3
    first, second = ends(agreed(scenario), 2)
    assert first == (EOF_END, 0x100)
    assert second == (EOF_END + 3_000 + (1 + overload_ns) * BIT_NS + EOF_END, 0x101)


def test_who_has_counted_its_eleventh_bit_hears_the_frame_that_begins_before_that_bit_is_over() -> None:
    scenario = scene(ACTIVE, ACTIVE, ACTIVE, end_ns=400_000)
    scenario.stops = [(1_000, 2_500, 2)]
    scenario.sends = [(2_500 + 11 * BIT_NS - 125, 0, classic(0x100))]
    assert [id for _, id in ends(agreed(scenario), 2)] == [0x100]


def test_no_sof_is_sent_onto_a_dominant_wire() -> None:
    """Node 1 reads the SOF wrong, and has a frame to send: it takes the next dominant bit for the SOF."""
    scenario = scene(ACTIVE, ACTIVE, ACTIVE, end_ns=400_000)
    scenario.sends = [(0, 0, classic(0x000)), (1_000, 1, classic(0x001))]
    scenario.flips = [(0, 1, 1)]
    outcome = agreed(scenario)
    assert not any(told[0] == "error" and told[4] for told in outcome.events[1])


# nodes out of step


@each(("bit", "end_ns"), [(60, 220_000), (75, 227_000), (90, 233_500)])
def test_after_an_error_in_a_data_phase_each_node_starts_at_its_own_boundary(bit: int, end_ns: int) -> None:
    """A passive sender's error brings no edge that would put the nodes in step again."""
    scenario = scene(PASSIVE, PASSIVE, PASSIVE)
    scenario.sends = [(0, 0, flexible(0x100)), (10_000, 1, classic(0x101)), (10_000, 2, classic(0x102))]
    scenario.flips = [(bit, 1, 0)]
    assert ends(agreed(scenario), 0)[0] == (end_ns, 0x101)


def test_a_suspended_node_starts_eight_bits_behind_its_own_intermission() -> None:
    """Forcing a level that is there already must not move its bits."""
    scenario = scene(PASSIVE, ACTIVE)
    scenario.members.append(Member(True, True, 0, 0))
    scenario.sends = [(0, 0, classic(0x100)), (0, 0, classic(0x100))]
    scenario.holds = [(EOF_END + 10_700, 10, RECESSIVE, 2)]
    first, second = ends(agreed(scenario), 1)
    assert second[0] - first[0] == (3 + 8) * BIT_NS + EOF_END


def test_a_level_forced_in_the_last_quarter_bit_of_an_intermission_ends_no_suspension() -> None:
    """The sample has been taken, the bit is not over: who sent knows by then that it is suspended."""
    scenario = scene(PASSIVE, ACTIVE)
    scenario.members.append(Member(True, True, 0, 0))
    scenario.sends = [(0, 0, classic(0x100)), (EOF_END + 10_500, 0, classic(0x101))]
    scenario.holds = [(EOF_END + 5_900, 10, RECESSIVE, 2)]
    assert ends(agreed(scenario), 1) == [(EOF_END, 0x100), (EOF_END + (3 + 8) * BIT_NS + EOF_END, 0x101)]


GLITCH_NS = 10_000  # when it begins, on a bus that is idle


@each(
    ("asked_ns", "seen_by", "begins_ns"),
    [
        ([10_600], None, 12_000),
        ([10_600], 0, 12_000),
        ([11_800], None, 12_000),  # behind the sample point, too
        ([10_600, 11_800], 0, 12_000),  # and a second frame does not hasten the first
        ([10_600], 1, 10_600),  # somebody else's bit
    ],
)
def test_an_idle_bit_that_an_edge_began_lasts_its_time(
    asked_ns: list[int], seen_by: int | None, begins_ns: int
) -> None:
    """An edge sets a clock that has been nobody's business; an SOF begins where a bit of its sender's does."""
    scenario = scene(ACTIVE, ACTIVE)
    scenario.glitches = [(GLITCH_NS, 500, DOMINANT, seen_by)]
    scenario.sends = [(at_ns, 0, classic(0x100)) for at_ns in asked_ns]
    assert ends(agreed(scenario), 1)[0] == (begins_ns + EOF_END, 0x100)


def test_who_sees_the_edge_sets_its_own_clock_alone() -> None:
    """The other's SOF comes in the bit that the glitch began; two nodes with a frame do not wait for each other."""
    scenario = scene(ACTIVE, ACTIVE, ACTIVE)
    scenario.glitches = [(GLITCH_NS, 500, DOMINANT, 0)]
    scenario.sends = [(10_600, 0, classic(0x100)), (11_000, 1, classic(0x101))]
    (first, second) = ends(agreed(scenario), 2)
    assert first == (11_000 + EOF_END, 0x101)
    assert second == (11_000 + EOF_END + 3 * BIT_NS + EOF_END, 0x100)


def test_a_waiting_node_keeps_its_count_while_a_level_is_forced() -> None:
    scenario = scene(ACTIVE, ACTIVE, ACTIVE, end_ns=400_000)
    scenario.stops = [(1_000, 2_500, 2)]
    scenario.holds = [(12_300, 1, RECESSIVE, None)]
    scenario.sends = [(2_600, 2, classic(0x100))]
    assert ends(agreed(scenario), 0)[0][0] == 2_500 + 11 * BIT_NS + EOF_END


def test_recovery_begins_with_a_bit_of_its_own() -> None:
    scenario = scene(250, ACTIVE, end_ns=4_000_000)
    scenario.sends = [(0, 0, classic(0x100))]
    scenario.flips = [(20, 1, 0)]
    scenario.holds = [(200_000, 40, RECESSIVE, None)]
    scenario.restarts = [(230_025, 0)]
    recovered = agreed(scenario).events[0][-1]
    assert recovered == ("state", 230_025 + 128 * 11 * BIT_NS, 0, 0, 0)


# stimuli


def test_who_starts_while_a_level_is_forced_sees_it() -> None:
    scenario = scene(ACTIVE, ACTIVE, end_ns=400_000)
    scenario.stops = [(1_000, 12_000, 1)]
    scenario.holds = [(6_000, 20, DOMINANT, 1)]
    scenario.sends = [(13_000, 1, classic(0x001))]
    length_ns = ends(agreed(scenario), 0)[0][0] - (6_000 + 20 * BIT_NS + 11 * BIT_NS)
    assert length_ns == EOF_END + 2 * BIT_NS  # two stuff bits more


def test_a_frame_offered_in_the_last_bit_of_the_intermission_waits_for_its_end() -> None:
    scenario = scene(ACTIVE, ACTIVE, ACTIVE, end_ns=400_000)
    scenario.sends = [(0, 0, classic(0x100)), (EOF_END + 5_900, 1, classic(0x101))]
    scenario.holds = [(1_000, 100, RECESSIVE, 2)]
    agreed(scenario)


def test_the_trace_ends_with_the_bit_that_was_read_wrong() -> None:
    """Everybody reads one bit inverted, and its sender is bus-off by it: the wire is recessive again."""
    scenario = scene(250, end_ns=400_000)
    scenario.sends = [(0, 0, classic(0x100))]
    scenario.flips = [(22, 1, "all")]
    agreed(scenario)
    levels = on_the_bench(scenario, bitwise=True).levels
    assert levels is not None
    assert levels[-1] == (23 * BIT_NS, RECESSIVE)


# flags


def test_what_spares_a_missing_acknowledge_ends_with_its_flag() -> None:
    """Rule 3, exception A: a dominant bit in a later passive flag is not the one that would have cost 8 more."""
    schedule = scene(PASSIVE, end_ns=200_000)
    schedule.members.append(Member(True, True, 0, 0))
    schedule.sends.append((0, 0, classic(0x100)))
    ack_slot = 53
    delimiter = ack_slot + 1 + 6
    overload_flag = delimiter + 8
    for bit, level, node in (
        (delimiter + 7, DOMINANT, None),
        (overload_flag, RECESSIVE, 0),
        (overload_flag + 2, DOMINANT, None),
    ):
        schedule.holds.append((bit * BIT_NS, 1, level, node))
    schedule.looks = [(ack_slot + 1) * BIT_NS, (overload_flag + 6) * BIT_NS]
    outcome = agreed(schedule)
    assert [seen[1][1] for seen in outcome.seen] == [PASSIVE, PASSIVE + 8]
