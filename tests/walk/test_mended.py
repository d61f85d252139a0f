"""What the walk found, each by itself: numbers out of range, and objects that were never initialised."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest

import canwire
from canwire.boards.can.channel import Channel
from canwire.boards.can.line import Line
from canwire.bus.can.bit_level import BitLevel
from canwire.bus.can.bits import measure
from canwire.bus.can.bus import CanBus
from canwire.bus.can.clock import Clock
from canwire.bus.can.echo import Echo
from canwire.bus.can.node import Mailbox, Node
from canwire.bus.can.station import WAITING, Station
from canwire.bus.can.stepped import losing_bit
from canwire.bus.can.stimulus import Stimulus
from canwire.bus.can.tally import Tally
from canwire.bus.load import BusLoad
from canwire.chips.confinement import Confinement
from canwire.chips.ideal.can_fd import CanFdController
from canwire.chips.sja1000.controller import Sja1000
from canwire.hub.protocol.turn_page import TurnPage
from canwire.timeline import Timeline
from tests.cases import each

pytestmark = [pytest.mark.core, pytest.mark.finding("faults-2 11")]
compiled_only = pytest.mark.skipif(canwire.core_mode() == "uncompiled", reason="an AttributeError there")


@each("rule", [-1, 9, 1000])
def test_a_rule_that_there_is_not_is_refused(rule: int) -> None:
    counters = Confinement()
    with pytest.raises(ValueError, match=f"rule {rule}: there are 0 to 8"):
        counters.apply(rule)
    assert (counters.tec, counters.rec) == (0, 0)


def test_equal_fields_lose_at_their_last_bit() -> None:
    assert losing_bit(5, 5) == 31


def test_a_stimulus_is_over_at_the_end_of_time() -> None:
    stimulus = Stimulus([100, 200], [0, 1], None)
    for at_ps in (2**63 - 1, 2**63 - 1):
        stimulus.advance(at_ps)
        assert (stimulus.level, stimulus.over()) == (1, True)
    stimulus.position, stimulus.next_ps = -5, 0
    stimulus.advance(10)
    assert stimulus.level == 1


def test_a_bus_that_is_busy_for_ages_is_looked_at_in_an_instant() -> None:
    load = BusLoad()
    load.add(7, 2**62)  # ten thousand million buckets
    assert (load.percent(2**62), load.peak(), load.busy_ns) == (100.0, 100.0, 2**62 - 7)


def test_a_replay_has_the_bits_of_one_frame() -> None:
    with canwire.Lab() as lab:
        node = lab.can_bus("can0").node("a")
        node.send(canwire.Frame(0x123))
        lab.run_for(0.000_020)
        bits = node.line.controller.bus.bits
        bits.enter([node.line.controller], 5, 0)
        with pytest.raises(ValueError, match="now_ns 9223372036854775807: 1099511627776 ns at most after"):
            bits.replay(2**63 - 1)


def test_an_end_of_a_ring_that_there_is_not_is_the_producers() -> None:
    ring = canwire.Ring(4)
    assert ring._settled(2**31)
    ring.threshold = 9
    ring.arm()
    assert (ring._settled(-(2**31)), ring.wanted, ring.free_wanted) == (True, 9, 0)


@compiled_only
def test_a_mailbox_that_was_never_initialised_has_a_record() -> None:
    with canwire.Lab() as lab:
        chip: Any = lab.can_bus("can0").node("a", controller="sja1000").line.controller
        chip.received(Mailbox.__new__(Mailbox), 1)
        box = Mailbox.__new__(Mailbox)
        measure(box, 0)
    assert (box.key, box.bits) == (0, 50)  # three of them are stuff bits


@compiled_only
def test_what_was_never_initialised_answers_or_raises() -> None:
    page, echo, station = TurnPage.__new__(TurnPage), Echo.__new__(Echo), Station.__new__(Station)
    assert (page.asked(), page.now_ns(), page.give(7)) == (False, 0, None)
    echo.drive(1, 0)
    assert echo.level_at(0) == 1
    station.sample(0)
    assert station.state == WAITING
    with pytest.raises(AttributeError, match="NoneType"):
        CanBus.__new__(CanBus).idle()


@compiled_only
def test_what_c_reads_unseen_is_never_none() -> None:
    """These files are compiled without checks for None, so nothing may put one there."""
    station = Station(Node(), Tally())
    clock = Clock(station, 0)
    for thing, names in (
        (station, ("node", "tally", "reader", "layout", "box", "sent", "levels")),
        (clock, ("station", "node", "echo")),
        (clock.echo, ("node",)),
        (BitLevel(), ("tally", "clocks", "stimuli")),
        (Channel(1, 1), ("receive", "transmit")),
        (CanFdController(Line("", Timeline())), ("host", "confinement", "normal", "high")),
        (Sja1000(), ("cells", "interrupts", "fifo", "filter", "confinement")),
    ):
        for name in names:
            with pytest.raises(AttributeError):
                setattr(thing, name, None)
            with pytest.raises(AttributeError):
                delattr(thing, name)
    for refused in (
        partial(Station, None, Tally()),
        partial(Station, Node(), None),
        partial(Clock, None, 0),
        partial(CanFdController, None),
        partial(Channel, 1, 1, rings=(None, None)),
    ):
        with pytest.raises(TypeError, match="None: must be"):
            refused()
