"""What a timed program's connection is made of: the place that is held for it, and its stirs. No network."""

from __future__ import annotations

import queue
from collections.abc import Iterator
from contextlib import closing

import pytest

from canwire import BadMessage
from canwire.hub.links.network import wire
from canwire.hub.links.network.lockstep.held_place import HeldPlace
from canwire.hub.links.network.lockstep.stirs import IncomingStirs, OutgoingStirs
from canwire.hub.links.network.wire import Report
from canwire.hub.owner.lockstep.shared_page import SharedPage
from canwire.hub.protocol.turn_wait import TurnWait
from tests.hubs import LONG_S


@pytest.fixture
def page() -> Iterator[SharedPage]:
    with closing(SharedPage(0)) as made:
        yield made


def test_a_wait_is_told_its_end_and_one_that_was_interrupted_that_another_has_begun(page: SharedPage) -> None:
    rung: list[int] = []
    place = HeldPlace(TurnWait(lambda: rung.append(1), *page.hand_over()))
    told: queue.Queue[tuple[str, int | None]] = queue.Queue()
    place.begin(5, lambda now_ns: told.put(("interrupted", now_ns)))
    place.begin(7, lambda now_ns: told.put(("first", now_ns)))
    assert told.get(timeout=LONG_S) == ("interrupted", None)
    assert (page.words.asked(), page.words.until_ns(), len(rung)) == (True, 7, 2)
    page.give(6)
    assert told.get(timeout=LONG_S) == ("first", 6)
    place.begin(9, lambda now_ns: told.put(("ended", now_ns)))
    place.end()
    assert told.get(timeout=LONG_S) == ("ended", None)
    place.begin(9, lambda now_ns: told.put(("too late", now_ns)))
    assert told.get(timeout=LONG_S) == ("too late", None)
    assert told.empty()


def test_a_stir_comes_once_however_often_the_network_drops_or_repeats_it() -> None:
    stirred: list[int] = []
    here = OutgoingStirs()
    there = IncomingStirs(lambda: stirred.append(here.written))
    assert here.batches(0) == []
    here.stir()
    assert len(here.batches(0)) == 1  # dropped
    assert (here.unconfirmed, here.batches(0)) == (True, [])
    there.sent(here.sent)  # a sign of life tells of it
    missing = there.report(0)
    assert missing == Report(wire.STIRS, 0, 0, True)
    here.acknowledge(missing)
    here.stir()
    [again] = here.batches(0)
    for _ in range(2):
        there.accept(*wire.frames_in(again)[1:3])
    assert stirred == [2]
    come = there.report(0)
    assert come == Report(wire.STIRS, 2, 2, False)
    here.acknowledge(come)
    assert (here.unconfirmed, there.report(0)) == (False, None)
    with pytest.raises(BadMessage, match="of 2 stirs"):
        here.acknowledge(Report(wire.STIRS, 3, 3, False))
