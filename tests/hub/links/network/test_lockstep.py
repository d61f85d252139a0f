"""What a timed program's connection is made of: the place that is held for it, and its stirs. No network."""

from __future__ import annotations

import itertools
import queue
from collections.abc import Iterator
from contextlib import closing
from typing import Any

import pytest

from canwire import BadMessage, ChannelMode
from canwire.hub.links.network import wire
from canwire.hub.links.network.calls import Asked, Positions, answered_in, encode
from canwire.hub.links.network.guest import Guest
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.lockstep.held_place import HeldPlace
from canwire.hub.links.network.lockstep.stirs import IncomingStirs, OutgoingStirs
from canwire.hub.links.network.mirrors import Outgoing
from canwire.hub.links.network.wire import Report
from canwire.hub.owner.held.shared_ring import SharedRings
from canwire.hub.owner.lockstep.shared_page import SharedPage
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.hub.protocol.turn_wait import TurnWait
from canwire.platform import EventDescriptor
from tests.hubs import LONG_S, until


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


class PageLink:
    """A hub of which a guest sees the page for its program's one thread, and the queues of one channel."""

    time = "lockstep"

    def __init__(self, page: SharedPage) -> None:
        self.page = page
        self.doorbell = EventDescriptor(shared=True)
        self.rings = SharedRings(8, 8, exact=True, doorbell=self.doorbell, halts=None)

    def call(self, request: m.Message) -> Answer:
        if isinstance(request, m.SetUpChannel):
            return m.ChannelOpened(8, 8), self.rings.hand_over()
        assert isinstance(request, m.JoinTime)
        return m.Joined("hub", 0), self.page.hand_over()

    def listen(self, listener: object) -> None:
        """There are no notices."""

    def close(self) -> None:
        self.rings.close()
        self.doorbell.close()


class Remote:
    """A program elsewhere that takes part in the hub's time, and the hub's end of its connection."""

    def __init__(self, page: SharedPage) -> None:
        self.link = PageLink(page)
        link: Any = self.link
        self.stirs = OutgoingStirs()
        self.sent: list[bytes] = []
        self.guest = Guest(link, "somebody", "configure", self.sent.append, lambda: True)
        self.answers: queue.Queue[m.Message] = queue.Queue()
        self.serials = itertools.count(1)

    def ask(self, request: m.Message, positions: Positions = ()) -> None:
        """The call says which data were sent before it."""
        serial = next(self.serials)
        payload = m.encode_request(serial, request)[m.LENGTH.size :]
        self.guest.ask(encode(Asked(serial, serial, "elsewhere", positions, payload)), self.answered)

    def answered(self, payload: bytes) -> None:
        self.answers.put(m.decode_reply(answered_in(payload).reply)[2])

    def answer(self) -> m.Message:
        return self.answers.get(timeout=LONG_S)

    def send_stirs(self, count: int) -> None:
        for _ in range(count):
            self.stirs.stir()
            for payload in self.stirs.batches(0):
                self.guest.take(payload)


@pytest.fixture
def remote(page: SharedPage) -> Iterator[Remote]:
    made = Remote(page)
    with closing(made.guest):
        yield made


def test_a_wait_begins_at_once_if_all_that_was_sent_before_it_has_come(
    page: SharedPage, remote: Remote
) -> None:
    remote.ask(m.JoinTime("1-a", 5, "a"))
    assert isinstance(remote.answer(), m.Joined)
    for stirs, until_ns in enumerate((700, 800, 900)):
        remote.ask(m.AwaitTurn(5, until_ns), ((wire.STIRS, stirs),))
        assert (page.words.asked(), page.words.until_ns()) == (True, until_ns)
        page.give(until_ns - 1)
        assert remote.answer() == m.Number(until_ns - 1)
        remote.send_stirs(1)


def test_a_wait_that_overtakes_what_was_sent_before_it_begins_after_that(
    page: SharedPage, remote: Remote
) -> None:
    remote.ask(m.JoinTime("1-a", 5, "a"))
    assert isinstance(remote.answer(), m.Joined)
    remote.send_stirs(1)
    remote.ask(m.AwaitTurn(5, 700), ((wire.STIRS, 2),))
    assert (page.words.asked(), remote.answers.empty()) == (False, True)
    remote.send_stirs(1)
    until(page.words.asked)
    page.give(600)
    assert remote.answer() == m.Number(600)


@pytest.mark.conforms("G-17")
def test_a_wait_right_after_the_answer_that_opened_queues_finds_them(
    page: SharedPage, remote: Remote
) -> None:
    """A wait whose call overtook them was not ended by frames: seen as a log that differed in one run of hundreds."""
    remote.link.rings.receive.put_bytes(bytes(80))
    found: list[tuple[list[object], list[bytes]]] = []

    def answered(payload: bytes) -> None:
        mirror = remote.guest.pump.mirror
        kinds: list[object] = [type(mirror(number)) for number, _ in answered_in(payload).rings]
        found.append((kinds, batches(remote)))

    serial = next(remote.serials)
    request = m.encode_request(serial, m.SetUpChannel(1, ChannelMode(8, 8)))[m.LENGTH.size :]
    remote.guest.ask(encode(Asked(serial, serial, "elsewhere", (), request)), answered)
    until(lambda: batches(remote))  # only then: the client would drop them
    assert found == [([Outgoing, Incoming], [])]


def batches(remote: Remote) -> list[bytes]:
    """The records that were sent to the program."""
    return [payload for payload in remote.sent if payload[0] in (*wire.BATCHES, wire.TOGETHER)]


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


def test_each_number_that_comes_or_is_asked_for_is_reported_once() -> None:
    stirred: list[None] = []
    hub = IncomingStirs(lambda: stirred.append(None))
    assert hub.report(0) is None
    for _ in range(2):  # the second one is not new; its report may have been lost
        assert hub.accept(4, memoryview(b""))
        assert hub.report(0) == Report(wire.STIRS, 5, 5, False)
        assert hub.report(0) is None
    hub.sent(5)
    assert hub.report(0) == Report(wire.STIRS, 5, 5, False)
    hub.sent(6)
    assert hub.report(0) == Report(wire.STIRS, 5, 5, True)
    assert hub.report(0) is None
    assert len(stirred) == 1
