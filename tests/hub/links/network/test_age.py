"""Commands that were on their way for too long are not obeyed: frames and calls, by the hub's clock."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import closing

import pytest

from canwire import Frame, HubError
from canwire.hub.links.network import wire
from canwire.hub.links.network.calls import answered_in, asked_in, encode
from canwire.hub.links.network.client import NetworkLink
from canwire.hub.links.network.cuts.age import Age, OtherClock
from canwire.hub.links.network.cuts.late import Late
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.mirrors import Outgoing
from canwire.hub.links.network.offered import Offered
from canwire.hub.protocol import messages as m
from canwire.ring import Ring
from tests.hub.links.network.places import Cable, Place, channel, elsewhere, offered, running
from tests.hubs import LONG_S, until

pytestmark = pytest.mark.conforms("N-59")
_S = 1_000_000_000
LATE_S = 100.0  # so long that no busy machine takes it


def test_a_stamp_is_never_younger_than_the_command() -> None:
    clock = OtherClock()
    assert clock.stamp(5 * _S) == 0  # nothing is known yet
    for way_ns in (300_000_000, 20_000_000, 5 * _S):  # the quickest message says most
        clock.heard(1_000 * _S, 10 * _S + way_ns)
    age = Age(2.0)
    given_ns, ahead_ns = 20 * _S, 990 * _S
    for true_s in (0.0, 1.9, 2.1, 40.0):
        over_s = age.over_s(clock.stamp(given_ns), given_ns + ahead_ns + round(true_s * _S))
        assert (over_s > 0) == (true_s > 2)
        assert not over_s or true_s <= over_s < true_s + 0.1
    assert Age(0).over_s(clock.stamp(given_ns), 5_000 * _S) == 0


def test_two_seconds_are_usual() -> None:
    assert Offered().age_s == 2.0


def test_clocks_that_drift_apart_are_followed() -> None:
    clock = OtherClock()
    for second in range(0, 100_000, 100):  # the other one is slower by a ten-thousandth
        clock.heard(second * _S * 9_999 // 10_000, second * _S)
    assert Age(0.1).over_s(clock.stamp(99_900 * _S), 99_900 * _S * 9_999 // 10_000) == 0


def test_what_came_too_late_is_given_up_and_the_rest_goes_in_its_order() -> None:
    clock, given_up = OtherClock(), list[tuple[int, float]]()
    clock.heard(0, 0)
    original, copy = Ring(16, exact=True), Ring(16, exact=True)
    outgoing = Outgoing(1, original, clock=clock)
    incoming = Incoming(1, copy, Age(2.0), lambda *what: given_up.append(what))
    sent: list[bytes] = []
    for second in (1, 2, 4):  # the network is cut until 4.5 s
        for number in range(3):
            original.put_bytes(bytes([second, number]) + bytes(78))
        sent += outgoing.batches(second * _S, at_once=True)
    for payload in sent:
        _, first, records, stamp = wire.frames_in(payload)
        incoming.accept(first, records, stamp, round(4.5 * _S))
    assert [record[:2] for record in iter(copy.take_bytes, None)] == [b"\4\0", b"\4\1", b"\4\2"]
    assert [count for count, _ in given_up] == [3, 3]
    report = incoming.report(5 * _S, at_once=True)
    assert report is not None
    outgoing.acknowledge(report)
    assert (report.received, report.taken, original.fill()) == (
        9,
        9,
        0,
    )  # and all of their room is there again


@pytest.fixture
def warned() -> list[str]:
    return []


@pytest.fixture
def place(warned: list[str]) -> Iterator[Place]:
    with offered(age_s=2.0) as made:
        made.bridge._warn = warned.append  # type: ignore[method-assign]
        yield made


@pytest.mark.realtime
def test_frames_of_a_cut_are_counted_and_told_and_never_sent(place: Place, warned: list[str]) -> None:
    with (
        closing(Cable(place.port)) as cable,
        place.here() as here,
        elsewhere(f"zenoh://tests/bench?via=tcp/127.0.0.1:{cable.port}") as hub,
    ):
        running(here)
        sender, receiver = channel(hub, 0), channel(here, 1)
        guest = next(iter(place.bridge._guests.values()))
        cable.cut()
        for number in range(5):
            sender.send(Frame(number))
        late = guest.late.age
        late.over_s = lambda stamp, now_ns: LATE_S if stamp else 0.0  # type: ignore[method-assign]
        cable.mend()
        until(lambda: not sender.writing.ring.fill())
        del late.over_s
        until(lambda: sender.status().refused == 5)
        until(lambda: sum(int(line.split()[1]) for line in warned) == 5)
        assert warned[0].endswith("frames came after 100.0 s, and are not sent beyond 2 s")
        sender.send(Frame(0x77))
        frame = receiver.receive(LONG_S)
        assert frame is not None
        assert frame.id == 0x77
        status = sender.status()
        assert status.sent == status.delivered + status.refused + status.pending == 6


@pytest.mark.realtime
def test_a_call_that_was_given_up_is_not_carried_out_later(place: Place, warned: list[str]) -> None:
    with elsewhere(place.address) as hub, place.here() as here:
        link = hub._link
        assert isinstance(link, NetworkLink)
        calls: list[bytes] = []
        send = link._asker._send
        link._asker._send = lambda payload: calls.append(payload) or send(payload)  # type: ignore[method-assign, func-returns-value]
        hub.create_luid()
        asked = asked_in(calls[0][1:])
        assert asked.stamp
        asked.serial, asked.request = (
            1 << 20,
            m.encode_request(1 << 20, m.Unplug("HW000001"))[m.LENGTH.size :],
        )
        asked.stamp -= int(LATE_S * 1000)
        answers: list[bytes] = []
        guest = next(iter(place.bridge._guests.values()))
        guest.ask(encode(asked), answers.append)
        _, _, failed = m.decode_reply(answered_in(answers[0]).reply)
        assert isinstance(failed, m.Failed)
        assert (failed.error, "Unplug came after 100" in failed.text) == (HubError.__name__, True)
        assert len(here.boards()) == 2
        assert len(warned) == 1


def test_a_repetition_that_comes_after_the_next_call_is_not_carried_out(place: Place) -> None:
    """A query may be slower than the messages after it: a wait for a turn began once more, in the middle of a turn."""
    with elsewhere(place.address) as hub:
        link = hub._link
        assert isinstance(link, NetworkLink)
        calls: list[bytes] = []
        send = link._asker._send
        link._asker._send = lambda payload: calls.append(payload) or send(payload)  # type: ignore[method-assign, func-returns-value]
        first = hub.create_luid()
        assert hub.create_luid() == first + 1
        answers: list[bytes] = []
        next(iter(place.bridge._guests.values())).ask(calls[0][1:], answers.append)
        assert hub.create_luid() == first + 2
        _, _, failed = m.decode_reply(answered_in(answers[0]).reply)
        assert isinstance(failed, m.Failed)
        assert "answered already" in failed.text


def test_the_oldest_frame_of_each_report() -> None:
    said: list[str] = []
    late = Late(0.1, said.append)
    late.frames(2, 0.4)
    late.frames(1, 0.2)
    late.tell()
    late.tell()
    late.frames(1, 0.3)
    late.tell()
    assert said == [
        f"{count} frames came after {age} s, and are not sent beyond 0.1 s"
        for count, age in ((3, 0.4), (1, 0.3))
    ]
