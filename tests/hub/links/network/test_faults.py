"""What a network does to a hub's clients: cut, broken, frozen, killed; and nothing is lost uncounted."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest

import canwire
from canwire import BadMessage, Frame, Hub, HubChannel, HubError, HubLost, InUse, WrongState
from canwire.hub.links.local import LocalLink
from canwire.hub.links.network import wire
from canwire.hub.links.network.bridge import Bridge
from canwire.hub.links.network.client import NetworkLink
from canwire.hub.links.network.session.settings import Patience, load_zenoh
from canwire.hub.offer import offered_hubs
from canwire.hub.protocol import messages as m
from tests.hub.links.network.places import (
    CONFIG,
    QUICK,
    Cable,
    Place,
    channel,
    elsewhere,
    offered,
    running,
)
from tests.hubs import LONG_S, Served, offering, serving, until

LEASE_S = 1.0  # of Zenoh's, which is ten times that otherwise
pytestmark = [pytest.mark.conforms("PL-11"), pytest.mark.realtime]


@pytest.fixture
def place() -> Iterator[Place]:
    with offered() as made:
        yield made


@pytest.fixture
def cable(place: Place) -> Iterator[Cable]:
    with closing(Cable(place.port)) as made:
        yield made


def over(cable: Cable) -> str:
    return f"zenoh://tests/bench?via=tcp/127.0.0.1:{cable.port}"


def lost_call(hub: Hub) -> HubLost:
    with little_patience(hub), pytest.raises(HubLost) as caught:
        hub.now_ns()
    return caught.value


@contextmanager
def little_patience(hub: Hub) -> Iterator[None]:
    """A call that gets no answer gives up soon, for once."""
    link = hub._link
    assert isinstance(link, NetworkLink)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(link, "_patience", link._patience._replace(call_s=0.4))
        yield


def send_all(sender: HubChannel, count: int) -> None:
    for number in range(count):
        sender.send(Frame(number & 0x7FF, number.to_bytes(4, "big")), timeout=LONG_S)
    until(lambda: sender.status().delivered >= count)


def numbers(receiver: HubChannel, count: int) -> list[int]:
    """Of so many frames, in the order they come."""
    found: list[int] = []
    while len(found) < count:
        frame = receiver.receive(LONG_S)
        assert frame is not None, f"{len(found)} of {count} came"
        found.append(int.from_bytes(frame.data, "big"))
    return found


class Cut:
    """A session of Zenoh's that cannot say goodbye."""

    def __init__(self, session: Any) -> None:
        self._session = session

    def close(self) -> None:
        self._session.close()
        raise load_zenoh().ZError("close operation timed out!")


def test_a_program_closes_its_hub_while_the_network_is_cut(place: Place) -> None:
    """A minute of the bench of three machines: `canwire record` ended with a traceback, and kept its descriptors."""
    hub = elsewhere(place.address)
    link = hub._link
    assert isinstance(link, NetworkLink)
    link._session = Cut(link._session)
    hub.close()
    assert link._doorbell._closed  # type: ignore[attr-defined]


@pytest.mark.conforms("N-30")
@pytest.mark.parametrize(("room", "lost"), [(256, 0), (64, 136)])
def test_a_cut_link_goes_on_and_what_is_lost_is_counted(
    place: Place, cable: Cable, room: int, lost: int
) -> None:
    with place.here() as here, elsewhere(over(cable)) as hub:
        running(here)
        receiver = channel(hub, 1, receive=room, transmit=0)
        sender = channel(here, 0)
        cable.cut()
        error = lost_call(hub)
        assert "no message from" in str(error)
        send_all(sender, 200)
        assert not hub.lost
        cable.mend()
        assert numbers(receiver, 200 - lost) == list(range(200 - lost))
        until(lambda: _answers(hub))
        assert receiver.status().lost == lost
        sender.send(Frame(1, b"\0\0\0\1"))
        assert numbers(receiver, 1) == [1]


def _answers(hub: Hub) -> bool:
    with little_patience(hub):
        try:
            hub.now_ns()
        except HubLost:
            return False
        return True


@pytest.mark.conforms("N-30")
def test_what_is_sent_while_the_link_is_cut_goes_out_once_when_it_is_back(place: Place, cable: Cable) -> None:
    with place.here() as here, elsewhere(over(cable)) as hub:
        running(here)
        sender = channel(hub, 0)
        receiver = channel(here, 1)
        cable.cut()
        for number in range(300):
            sender.send(Frame(number, number.to_bytes(4, "big")))
        assert sender.writing.ring.fill() == 300  # none of them counts as sent
        cable.mend()
        assert numbers(receiver, 300) == list(range(300))
        until(lambda: not sender.writing.ring.fill())


@pytest.mark.conforms("N-30")
def test_a_broken_connection_is_made_anew_and_nothing_is_missing(place: Place, cable: Cable) -> None:
    with place.here() as here, elsewhere(over(cable), QUICK._replace(broken_s=LONG_S)) as hub:
        running(here)
        receiver = channel(hub, 1, transmit=0)
        sender = channel(here, 0)
        send_all(sender, 50)
        cable.hang_up()
        send_all(sender, 50)
        assert numbers(receiver, 100) == [*range(50)] * 2
        assert receiver.status().lost == 0


@pytest.mark.conforms("N-30")
@pytest.mark.parametrize(("room", "lost"), [(256, 0), (64, 136)])
def test_a_cut_beyond_the_lease_goes_on_and_what_is_lost_is_counted(room: int, lost: int) -> None:
    """Zenoh gives the connection up at both ends, and makes a new one once it can."""
    patience = QUICK._replace(lease_s=LEASE_S, cut_s=LONG_S)
    with (
        offered(lease_s=LEASE_S, cut_s=LONG_S) as place,
        closing(Cable(place.port)) as cable,
        place.here() as here,
        elsewhere(over(cable), patience) as hub,
    ):
        running(here)
        receiver = channel(hub, 1, receive=room, transmit=0)
        sender, theirs = channel(here, 0), channel(hub, 0)
        there = here.boards()[0].id
        cable.cut()
        assert "no message from" in str(lost_call(hub))
        until(lambda: bool(place.bridge._absent) and not transports(hub))
        assert "no message from" in str(lost_call(hub))
        send_all(sender, 200)
        if not lost:  # behind the others, and not one more that does not fit
            theirs.send(Frame(7))
            assert theirs.writing.ring.fill() == 1
            with pytest.raises(HubLost):
                offered_hubs(f"tcp/127.0.0.1:{cable.port}")
        cable.mend()
        assert numbers(receiver, 200 - lost) == list(range(200 - lost))
        until(lambda: _answers(hub))
        assert receiver.status().lost == lost
        until(lambda: not theirs.writing.ring.fill())
        assert here.line_status(there, 0).channels == 2
        assert [one.name for one in offered_hubs(f"tcp/127.0.0.1:{cable.port}")] == ["bench"]


def transports(hub: Hub) -> list[object]:
    """Zenoh's connections of this program."""
    link = hub._link
    assert isinstance(link, NetworkLink)
    return list(link._session.info.transports())


def test_a_cut_that_lasts_is_a_hub_lost_and_gives_everything_back() -> None:
    patience = QUICK._replace(lease_s=LEASE_S, cut_s=0.1)
    with (
        offered(lease_s=LEASE_S, cut_s=0.1) as place,
        closing(Cable(place.port)) as cable,
        place.here() as here,
        elsewhere(over(cable), patience) as hub,
    ):
        running(here)
        board = here.boards()[1].id
        hub.open_control(board, 0)
        receiver = channel(hub, 1, transmit=0)
        cable.cut()
        with pytest.raises(HubLost):
            receiver.receive(LONG_S)
        assert hub.lost
        until(lambda: not here.line_status(board, 0).control_holder)
        cable.mend()


def test_a_hub_that_is_back_under_its_name_is_another_one() -> None:
    """Clients of the one before are told so as soon as they reach it: nothing of theirs is there any more."""
    patience = QUICK._replace(lease_s=LEASE_S, cut_s=10 * LONG_S)
    with (
        offered(lease_s=LEASE_S) as place,
        closing(Cable(place.port)) as cable,
        place.here() as here,
        elsewhere(over(cable), patience) as hub,
    ):
        running(here)
        receiver = channel(hub, 1, transmit=0)
        cable.cut()  # so that nobody says farewell
        until(lambda: not transports(hub))
        place.bridge.close()
        again = Bridge(lambda name: LocalLink(place.engine, name), place.bridge._offered, lambda: None)
        with closing(again):
            assert again.offer.name == place.bridge.offer.name
            assert not hub.lost
            cable.mend()
            with pytest.raises(HubLost):
                receiver.receive(LONG_S)
            assert "connect again" in str(lost_call(hub))
            with elsewhere(over(cable)) as other:
                assert len(other.boards()) == 2


def test_a_connection_that_stays_broken_is_a_hub_lost(place: Place, cable: Cable) -> None:
    with elsewhere(over(cable)) as hub, place.here() as here:
        running(here)
        receiver = channel(hub, 1, transmit=0)
        cable.close()
        with pytest.raises(HubLost):
            receiver.receive(LONG_S)
        assert hub.lost
        lost_call(hub)


def test_a_slow_client_loses_its_own_frames_and_holds_nobody_up(place: Place) -> None:
    with place.here() as here, elsewhere(place.address) as slow, elsewhere(place.address) as quick:
        running(here)
        idle = channel(slow, 1, receive=32, transmit=0)
        receiver = channel(quick, 1, receive=8192, transmit=0)
        send_all(channel(here, 0), 2000)
        assert numbers(receiver, 2000) == list(range(2000))
        assert (receiver.status().lost, idle.status().lost) == (0, 1968)
        assert numbers(idle, 32) == list(range(32))


def test_who_makes_room_and_then_sends_finds_that_room_there(place: Place) -> None:
    with elsewhere(place.address) as hub:
        running(hub)
        small, large = channel(hub, 1, receive=4, transmit=0), channel(hub, 1, transmit=0)
        sender = channel(hub, 0)
        for _ in range(100):
            for number in range(4):
                sender.send(Frame(number, b"\0\0\0" + bytes([number])))
            assert numbers(large, 4) == list(range(4))
            assert numbers(small, 4) == list(range(4))
        assert small.status().lost == 0


def test_what_was_sent_before_closing_at_once_has_arrived(place: Place) -> None:
    """Zenoh alone loses what is queued when its session is closed."""
    with place.here() as here, here.create_fifo(4096, 8) as fifo:
        with elsewhere(place.address) as hub:
            writer = hub.open_fifo(fifo.id, "writer")
            for number in range(400):
                assert writer.end_of_ring.ring.put_bytes(number.to_bytes(8, "big"))
        ring = here.open_fifo(fifo.id, "reader").end_of_ring.ring
        taken = [ring.take_bytes() for _ in range(400)]
        assert taken == [number.to_bytes(8, "big") for number in range(400)]


def test_calls_that_arrive_twice_are_carried_out_once(place: Place) -> None:
    with elsewhere(place.address) as hub:
        link = hub._link
        assert isinstance(link, NetworkLink)
        asker = link._asker
        send, query = asker._send, asker._query

        def twice(payload: bytes) -> None:
            send(payload)
            if payload[0] == wire.CALL:
                send(payload)
                query(payload[1:])

        asker._send = twice  # type: ignore[method-assign]
        luids = [hub.create_luid() for _ in range(20)]
        assert luids == list(range(luids[0], luids[0] + 20))


@pytest.mark.parametrize("which", [wire.CALL, wire.ANSWER])
def test_a_call_that_is_dropped_is_asked_again_and_carried_out_once(place: Place, which: int) -> None:
    with elsewhere(place.address) as hub:
        link = hub._link
        assert isinstance(link, NetworkLink)
        first = hub.create_luid()
        guest = next(iter(place.bridge._guests.values()))
        dropped: list[int] = []
        if which == wire.CALL:
            link._asker._send = lambda payload: dropped.append(payload[0])  # type: ignore[method-assign]
        else:
            guest._reply = lambda answer: dropped.append(wire.ANSWER)
        assert hub.create_luid() == first + 1
        assert which in dropped


def test_frames_still_come_to_one_that_may_not_keep_time_there(place: Place) -> None:
    with place.here() as here, elsewhere(place.address) as hub:
        running(here)
        with pytest.raises(WrongState, match="--time lockstep"):
            hub.keep_time("elsewhere")
        receiver, sender = channel(hub, 1, transmit=0), channel(here, 0)
        send_all(sender, 3)
        assert numbers(receiver, 3) == [0, 1, 2]


def test_another_version_is_named_at_both_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    own = m.VERSION
    monkeypatch.setattr(m, "VERSION", own + 1)
    with offered() as place:
        monkeypatch.setattr(m, "VERSION", own)
        with pytest.raises(BadMessage, match=rf"that hub speaks version {own + 1}, this program {own};"):
            elsewhere(place.address)


def test_a_second_hub_of_a_name_is_refused(place: Place) -> None:
    already = f"zenoh://tests/bench already .{place.bridge.offer.instance}"
    with pytest.raises(HubError, match=already), offered(via=(f"tcp/127.0.0.1:{place.port}",), insecure=True):
        pass
    there = f"tcp/127.0.0.1:{place.port}"
    with offered(name="other", via=(there,), insecure=True), elsewhere(place.address) as hub:
        assert hub.boards()


def test_nobody_there_is_said_soon() -> None:
    with pytest.raises(HubLost, match="no program answers"):
        elsewhere("zenoh://tests/bench?via=tcp/127.0.0.1:1", QUICK._replace(connect_s=0.1))


def test_a_name_that_nobody_has_is_told_with_those_there_are(place: Place) -> None:
    with pytest.raises(HubLost, match="in realm tests: bench"):
        canwire.connect(f"zenoh://tests/other?via=tcp/127.0.0.1:{place.port}")


# processes


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    with serving(tmp_path, CONFIG) as made:
        yield made


@pytest.mark.conforms("N-31")
def test_silence_is_borne_for_less_than_two_seconds() -> None:
    usual = Patience()
    assert max(usual.call_s, usual.broken_s) < 2


@pytest.mark.conforms("N-31")
@pytest.mark.parametrize("victim", ["hub", "bridge"])
def test_kill_9_of_the_owner_in_mid_batch_ends_every_call(served: Served, victim: str) -> None:
    with offering(served.address) as bridge, elsewhere(bridge.address) as hub:
        running(hub)
        sender, receiver = channel(hub, 0), channel(hub, 1)
        sender.send(Frame(1))
        assert receiver.receive(LONG_S) is not None
        found: list[Exception] = []

        def wait() -> None:
            try:
                while True:
                    receiver.receive(LONG_S)
            except HubLost as error:
                found.append(error)

        waiting = threading.Thread(target=wait)
        waiting.start()
        for number in range(200):
            sender.send(Frame(number))
        (served if victim == "hub" else bridge).process.kill()
        waiting.join(LONG_S)
        assert len(found) == 1
        lost_call(hub)
        assert hub.lost
        with pytest.raises(HubLost):
            sender.send(Frame(1))


_HOLDER = """
import sys
from canwire import *
hub = connect(sys.argv[1], name="holder")
board = hub.boards()[1].id
control = hub.open_control(board, 0)
channel = hub.open_channel(board, 0)
channel.set_up(ChannelMode(receive=16, transmit=1024))
channel.activate()
for number in range(200):  # extended: two that send one identifier at one time end in bus-off
    channel.send(Frame(number, extended=True))
print("holding", flush=True)
sys.stdin.read()
"""


def holder(address: str) -> subprocess.Popen[str]:
    process = subprocess.Popen(
        [sys.executable, "-c", _HOLDER, address], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "holding\n"
    return process


def end(process: subprocess.Popen[str]) -> None:
    process.kill()
    process.communicate(timeout=LONG_S)


def test_kill_9_of_a_client_in_mid_batch_gives_everything_back() -> None:
    with offered(grace_s=0.1) as place, place.here() as here:
        board = here.boards()[1].id
        process = holder(place.address)
        try:
            with pytest.raises(InUse, match="holder"):
                here.open_control(board, 0)
        finally:
            end(process)
        until(lambda: not here.line_status(board, 0).control_holder)
        with here.open_control(board, 0):
            assert here.line_status(board, 0).channels == 0


_FORKING = """
import gc, os, sys
from canwire import *
hub = connect(sys.argv[1])
if os.fork() == 0:
    try:
        hub.now_ns()
    except CanwireError as error:
        print(error, flush=True)
    hub.close()
    del hub
    gc.collect()
    sys.exit(0)
print(os.wait()[1], hub.now_ns() > 0)
"""


def test_a_fork_is_told_and_ends_and_its_parent_goes_on(place: Place) -> None:
    """Zenoh's threads are not in the fork: whatever touched its session there would wait for ever."""
    words = [sys.executable, "-c", _FORKING, place.address]
    found = subprocess.run(words, capture_output=True, text=True, timeout=LONG_S, check=True).stdout
    assert found.splitlines() == [
        "this connection belongs to the process that was forked; connect again in this one",
        "0 True",
    ]


def test_a_frozen_client_holds_nobody_up_and_goes_on() -> None:
    """As long as its lease lasts: on a busy machine what follows takes a while."""
    with (
        offered(lease_s=LONG_S, cut_s=LONG_S) as place,
        place.here() as here,
        elsewhere(place.address) as hub,
    ):
        running(here)
        process = holder(place.address)
        try:
            os.kill(process.pid, signal.SIGSTOP)
            receiver = channel(hub, 1, receive=4096, transmit=0)
            send_all(channel(here, 0), 1000)
            assert numbers(receiver, 1000) == list(range(1000))
            os.kill(process.pid, signal.SIGCONT)
            assert here.line_status(here.boards()[1].id, 0).control_holder.startswith("holder")
        finally:
            end(process)


@pytest.mark.parametrize("frozen", ["hub", "bridge"])
def test_a_frozen_owner_fails_calls_and_goes_on(served: Served, frozen: str) -> None:
    with offering(served.address) as bridge, elsewhere(bridge.address) as hub:
        running(hub)
        sender, receiver = channel(hub, 0), channel(hub, 1)
        process = (served if frozen == "hub" else bridge).process
        os.kill(process.pid, signal.SIGSTOP)
        try:
            until(lambda: not _answers(hub))
            assert not hub.lost
        finally:
            os.kill(process.pid, signal.SIGCONT)
        until(lambda: _answers(hub))
        sender.send(Frame(5, b"\0\0\0\5"))
        assert numbers(receiver, 1) == [5]
