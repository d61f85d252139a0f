"""Fault confinement, row by row of reference/can-protocol.md section 7 (ISO 11898-1, 12.1.4)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.bus.can import node
from canwire.chips.confinement import ACTIVE, BUS_OFF, PASSIVE, WARNING, Confinement
from canwire.values.event import ErrorState
from tests.cases import each

pytestmark = pytest.mark.core


def at(tec: int, rec: int) -> Confinement:
    """A controller with these counters, which got there by errors and successes alone."""
    confinement = Confinement()
    for _ in range(rec):
        confinement.apply(node.RECEIVE_ERROR)
    if tec % 8:
        confinement.apply(node.TRANSMIT_ERROR)
        for _ in range(8 - tec % 8):
            confinement.transmitted()
    for _ in range(tec // 8):
        confinement.apply(node.TRANSMIT_ERROR)
    assert (confinement.tec, confinement.rec) == (tec, rec)
    return confinement


def test_states_are_the_first_four_of_error_state() -> None:
    assert [ErrorState(number).name for number in (ACTIVE, WARNING, PASSIVE, BUS_OFF)] == [
        "ERROR_ACTIVE",
        "ERROR_WARNING",
        "ERROR_PASSIVE",
        "BUS_OFF",
    ]


# rule of the table, what bus/can/node.py calls it, TEC step, REC step
STEPS = [
    ("1", node.RECEIVE_ERROR, 0, 1),
    ("2", node.DOMINANT_AFTER_FLAG, 0, 8),
    ("3", node.TRANSMIT_ERROR, 8, 0),
    ("3, its exceptions", node.NO_RULE, 0, 0),
    ("4", node.FLAG_BIT_ERROR_TRANSMITTER, 8, 0),
    ("5", node.FLAG_BIT_ERROR_RECEIVER, 0, 8),
    ("6 as transmitter", node.LONG_DOMINANT_TRANSMITTER, 8, 0),
    ("6 as receiver", node.LONG_DOMINANT_RECEIVER, 0, 8),
]


@pytest.mark.conforms("G-09")
class TestTable:
    @each(("row", "rule", "tec", "rec"), STEPS)
    def test_rules_that_count_up(self, row: str, rule: int, tec: int, rec: int) -> None:
        for start in ((0, 0), (5, 7), (90, 100)):
            confinement = at(*start)
            confinement.apply(rule)
            assert (confinement.tec, confinement.rec) == (start[0] + tec, start[1] + rec), row

    @each(("before", "after"), [(0, 0), (1, 0), (8, 7), (128, 127), (255, 254)])
    def test_rule_7_successful_transmission(self, before: int, after: int) -> None:
        confinement = at(before, 3)
        confinement.transmitted()
        assert (confinement.tec, confinement.rec) == (after, 3)

    @each(("before", "after"), [(0, 0), (1, 0), (127, 126)])
    def test_rule_8_successful_reception(self, before: int, after: int) -> None:
        confinement = at(8, before)
        confinement.received()
        assert (confinement.tec, confinement.rec) == (8, after)

    @each("before", [128, 129, 200, 255])
    def test_rule_8_from_above_127(self, before: int) -> None:
        confinement = at(0, before)
        confinement.received()
        assert 119 <= confinement.rec <= 127

    def test_rule_8_by_number(self) -> None:
        one, other = at(8, 50), at(8, 50)
        assert one.apply(node.RECEIVED) == other.received()
        assert (one.tec, one.rec, one.state) == (other.tec, other.rec, other.state) == (8, 49, ACTIVE)

    @each(
        ("tec", "rec", "state"),
        [
            (0, 0, ACTIVE),
            (95, 95, ACTIVE),
            (96, 0, WARNING),
            (0, 96, WARNING),
            (127, 127, WARNING),
            (128, 0, PASSIVE),  # rule 9
            (0, 128, PASSIVE),
            (255, 0, PASSIVE),
            (0, 255, PASSIVE),
            (255, 255, PASSIVE),
            (256, 0, BUS_OFF),  # rule 10
        ],
    )
    def test_rules_9_and_10_limits(self, tec: int, rec: int, state: int) -> None:
        assert at(tec, rec).state == state

    def test_rule_11_active_again_only_when_both_are_below(self) -> None:
        confinement = at(128, 128)
        assert not confinement.transmitted()
        assert (confinement.tec, confinement.state) == (127, PASSIVE)
        assert confinement.received()
        assert confinement.state in (ACTIVE, WARNING)

    def test_rule_12_recovery(self) -> None:
        confinement = at(256, 17)
        confinement.reset()
        assert (confinement.tec, confinement.rec, confinement.state) == (0, 0, ACTIVE)

    def test_rec_alone_never_leads_to_bus_off(self) -> None:
        confinement = Confinement()
        for _ in range(1000):
            confinement.apply(node.DOMINANT_AFTER_FLAG)
        assert (confinement.rec, confinement.state) == (255, PASSIVE)

    def test_another_warning_limit(self) -> None:
        confinement = Confinement()
        confinement.warning_limit = 40
        assert [confinement.apply(node.TRANSMIT_ERROR) for _ in range(5)] == [False] * 4 + [True]
        assert (confinement.tec, confinement.state) == (40, WARNING)


class TestCrossings:
    @pytest.mark.conforms("G-09")
    def test_each_is_told_once_on_the_way_up(self) -> None:
        confinement = Confinement()
        told = [
            (confinement.apply(node.TRANSMIT_ERROR), confinement.tec, confinement.state) for _ in range(40)
        ]
        assert [entry for entry in told if entry[0]] == [
            (True, 96, WARNING),
            (True, 128, PASSIVE),
            (True, 256, BUS_OFF),
        ]

    @pytest.mark.conforms("G-09")
    def test_each_is_told_once_on_the_way_down(self) -> None:
        confinement = at(255, 0)
        told = [(confinement.transmitted(), confinement.tec, confinement.state) for _ in range(300)]
        assert [entry for entry in told if entry[0]] == [(True, 127, WARNING), (True, 95, ACTIVE)]

    @pytest.mark.conforms("G-09")
    def test_receiver_up_and_down(self) -> None:
        confinement = Confinement()
        up = [(confinement.apply(node.RECEIVE_ERROR), confinement.rec) for _ in range(300)]
        assert [rec for told, rec in up if told] == [96, 128]
        down = [(confinement.received(), confinement.rec) for _ in range(300)]
        assert [rec for told, rec in down if told][1:] == [95]
        assert [told for told, _ in down].index(True) == 0

    @pytest.mark.conforms("G-08")
    def test_a_lone_transmitter_stops_at_128(self) -> None:
        """16 attempts, then passive: the acknowledge exception of rule 3 leaves TEC alone."""
        confinement = Confinement()
        for attempt in range(1, 101):
            confinement.apply(node.NO_RULE if confinement.state == PASSIVE else node.TRANSMIT_ERROR)
            assert confinement.tec == min(8 * attempt, 128)
        assert confinement.state == PASSIVE

    @pytest.mark.conforms("G-09")
    def test_32_disturbed_attempts_lead_to_bus_off(self) -> None:
        confinement = Confinement()
        for _ in range(31):
            confinement.apply(node.TRANSMIT_ERROR)
        assert (confinement.tec, confinement.state) == (248, PASSIVE)
        assert confinement.apply(node.TRANSMIT_ERROR)
        assert (confinement.tec, confinement.state) == (256, BUS_OFF)

    @pytest.mark.conforms("G-11")
    @each("rule", [rule for _, rule, _, _ in STEPS] + [node.RECEIVED])
    def test_bus_off_holds_whatever_is_counted(self, rule: int) -> None:
        confinement = at(256, 5)
        assert not confinement.apply(rule)
        assert (confinement.tec, confinement.rec, confinement.state) == (256, 5, BUS_OFF)

    @pytest.mark.conforms("G-11")
    def test_bus_off_holds_whatever_goes_through(self) -> None:
        confinement = at(256, 5)
        assert not confinement.transmitted()
        assert not confinement.received()
        assert (confinement.tec, confinement.state) == (256, BUS_OFF)


@given(st.lists(st.sampled_from([*(rule for _, rule, _, _ in STEPS), node.RECEIVED, -7]), max_size=400))
def test_state_follows_counters(steps: list[int]) -> None:
    """Any history: ranges hold, the state is what the counters say, a crossing is told when it happens."""
    confinement = Confinement()
    for step in steps:
        if step == -7 and confinement.state == BUS_OFF:
            break  # a controller that is off the bus transmits nothing
        before = confinement.state
        told = confinement.transmitted() if step == -7 else confinement.apply(step)
        tec, rec, state = confinement.tec, confinement.rec, confinement.state
        assert told == (state != before)
        assert 0 <= tec <= 256
        assert 0 <= rec <= 255
        assert (state == BUS_OFF) == (tec == 256)
        if state != BUS_OFF:
            assert (state == PASSIVE) == (max(tec, rec) >= 128)
            assert (state == ACTIVE) == (max(tec, rec) < 96)


def test_success_says_whether_the_state_changed() -> None:
    assert Confinement().transmitted() is False
    assert Confinement().received() is False
    assert at(96, 0).transmitted() is True  # no longer a warning
    assert at(0, 96).received() is True
    assert at(95, 0).transmitted() is False
