"""Events, what waits for many of them, and pollers: Linux's own and the portable ones keep the same promises."""

from __future__ import annotations

import ctypes
import importlib
import inspect
import select
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import Any

import pytest

from canwire import HubError, pacing, platform
from canwire.hub.links.loopback import client
from canwire.platform.portable import events, memory, polling
from canwire.platform.portable.pairs import connected_pair
from canwire.timeline import Timeline
from tests.cases import each
from tests.descriptors import open_descriptors
from tests.missing import not_on_windows

linux: Any = importlib.import_module("canwire.platform.linux") if hasattr(select, "poll") else None
AGES = 60.0
PORTABLE = {
    "EventDescriptor": events,
    "shared_event": events,
    "AnyOf": events,
    "Poller": polling,
    "sharpen_sleep": polling,
    "create_memory": memory,
    "map_memory": memory,
    "duplicate": memory,
    "close_descriptors": memory,
}


needs_linux = pytest.mark.skipif(linux is None, reason="Windows has no poll")


@pytest.fixture(params=[pytest.param(linux, marks=needs_linux), events], ids=["linux", "portable"])
def kind(request: pytest.FixtureRequest) -> ModuleType:
    module: ModuleType = request.param
    return module


@pytest.fixture
def event(kind: ModuleType) -> Iterator[Any]:
    made = kind.EventDescriptor()
    yield made
    made.close()


def readable(source: Any) -> bool:
    return bool(select.select([source], [], [], 0)[0])


@needs_linux
@each("name", PORTABLE)
def test_both_variants_have_the_same_names(name: str) -> None:
    one, other = getattr(linux, name), getattr(PORTABLE[name], name)
    if not inspect.isclass(one):
        assert len(inspect.signature(one).parameters) == len(inspect.signature(other).parameters)
        return
    methods = {key for key in vars(one) if not key.startswith("_")} - {"leave", "copies"}
    assert methods <= set(dir(other))


def test_a_signal_is_taken_once(event: Any) -> None:
    assert not event.wait(0)
    event.signal()
    event.signal()
    assert event.wait(0)
    assert not event.wait(0)


def test_it_can_be_selected_whenever_it_was_signalled(event: Any) -> None:
    event.signal()  # before anybody asked for a descriptor
    assert readable(event)
    event.clear()
    assert not readable(event)
    event.signal()
    assert readable(event)
    assert event.wait(AGES)
    assert not readable(event)


def test_it_never_blocks_however_often_it_is_signalled(event: Any) -> None:
    event.fileno()
    for _ in range(100_000):
        event.signal()
    assert event.wait(0)


def test_a_thread_that_waits_is_woken(event: Any) -> None:
    woken: list[bool] = []
    waiter = threading.Thread(target=lambda: woken.append(event.wait(AGES)))
    waiter.start()
    event.signal()
    waiter.join(AGES)
    assert woken == [True]


def test_a_shared_event_wakes_whoever_waits_for_any_of_it(kind: ModuleType) -> None:
    own = kind.EventDescriptor(shared=True)
    other = kind.EventDescriptor.adopt(*own.copies())
    for signalled, waits in ((own, other), (other, own)):
        assert not waits.wait(0)
        signalled.signal()
        assert waits.wait(AGES)
        signalled.clear()  # on Linux both are one
    other.close()
    own.signal()
    assert own.wait(AGES)
    own.close()


def test_the_one_that_ever_takes_its_signals_rests_until_there_is_one(kind: ModuleType) -> None:
    own = kind.EventDescriptor(shared=True)
    other = kind.EventDescriptor.adopt(*own.copies())
    for _ in range(3):
        resting = threading.Thread(target=other.rest)
        resting.start()
        own.signal()
        resting.join(AGES)
        assert not resting.is_alive()
        assert not other.wait(0)
    own.signal()
    other.rest()
    for end in (own, other):
        end.close()


def test_of_many_threads_that_signal_no_signal_is_lost(event: Any) -> None:
    """Each waits until the one before was taken, so that none may go missing while the descriptor is made."""
    for _ in range(50):
        signalling = [threading.Thread(target=event.signal) for _ in range(3)]
        for thread in signalling:
            thread.start()
        assert event.wait(AGES)
        for thread in signalling:
            thread.join()
        event.clear()


def test_closed_it_is_quiet(kind: ModuleType) -> None:
    event = kind.EventDescriptor()
    event.fileno()
    event.close()
    event.close()
    event.signal()
    event.clear()
    assert not event.wait(0)
    assert "closed" in repr(event)


def test_what_nobody_holds_leaves_nothing_open(kind: ModuleType) -> None:
    def one() -> None:
        event = kind.EventDescriptor()
        event.signal()
        assert event.wait(0)
        readable(event)

    one()
    before = open_descriptors()
    for _ in range(20):
        one()
    assert open_descriptors() <= before


def test_any_of_some_is_readable_while_one_of_them_is(kind: ModuleType) -> None:
    made = [kind.EventDescriptor() for _ in range(3)]
    made[2].signal()
    some = kind.AnyOf(made[:2])
    assert not readable(some)
    some.add(made[2])
    assert readable(some)
    made[0].signal()
    made[2].clear()
    assert readable(some)
    assert made[0].wait(0)
    assert not readable(some)
    some.remove(made[1])
    made[1].signal()
    assert not readable(some)
    made[2].signal()
    assert readable(some)
    some.close()
    for event in made:
        event.close()


def test_one_of_some_that_was_closed_before_it_is_removed(kind: ModuleType) -> None:
    made = [kind.EventDescriptor() for _ in range(2)]
    some = kind.AnyOf(made)
    made[0].close()
    some.remove(made[0])
    assert not readable(some)
    made[1].signal()
    assert readable(some)
    some.close()
    made[1].close()


# the hub's events and clients' copies of them


def test_every_copy_hears_the_hub() -> None:
    shared = events.shared_event()
    one, other = (events.EventDescriptor.adopt(*shared.copies()) for _ in range(2))
    shared.signal()
    assert (one.wait(0), other.wait(0)) == (True, True)
    one.signal()  # its owner wakes itself: nobody else's business
    assert (one.wait(0), other.wait(0)) == (True, False)


def test_copies_hear_each_other_where_they_are_meant_to() -> None:
    shared = events.shared_event(both_ways=True)
    one, other = (events.EventDescriptor.adopt(*shared.copies()) for _ in range(2))
    one.signal()
    assert other.wait(0)
    other.close()
    one.signal()
    shared.close()
    shared.signal()
    assert one.wait(0)
    assert not one.wait(0)


# pairs and pollers


def fill(writer: socket.socket) -> None:
    while writer.send(bytes(65_536)):
        pass


def test_a_pair_never_blocks_and_ends_with_either_end() -> None:
    reader, writer = connected_pair()
    with pytest.raises(BlockingIOError):
        reader.recv(1)
    with pytest.raises(BlockingIOError):
        fill(writer)
    writer.close()
    reader.close()


def test_a_stranger_who_is_quicker_gets_no_end_of_a_pair(monkeypatch: pytest.MonkeyPatch) -> None:
    strangers: list[socket.socket] = []

    class Intruded(socket.socket):
        def connect(self, address: Any) -> None:
            if not strangers:
                strangers.append(socket.socket())
                strangers[0].connect(address)
            super().connect(address)

    monkeypatch.setattr("canwire.platform.portable.pairs.socket.socket", Intruded)
    reader, writer = connected_pair()
    writer.send(b"x")
    assert select.select([reader], [], [], AGES)[0]
    assert reader.recv(2) == b"x"
    strangers[0].settimeout(AGES)
    assert strangers[0].recv(1) == b""
    for end in (reader, writer, *strangers):
        end.close()


@pytest.fixture(params=[pytest.param("linux", marks=needs_linux), "portable"])
def poller(request: pytest.FixtureRequest) -> Iterator[Any]:
    made = (linux if request.param == "linux" else polling).Poller()
    yield made
    made.close()


def test_a_poller_tells_what_is_ready(poller: Any) -> None:
    reader, writer = connected_pair()
    poller.watch(reader.fileno(), poller.READABLE)
    assert poller.wait(0) == []
    writer.send(b"x")
    assert poller.wait(AGES) == [(reader.fileno(), poller.READABLE)]
    poller.watch(reader.fileno(), poller.READABLE | poller.WRITABLE)
    [(descriptor, found)] = poller.wait(AGES)
    assert (descriptor, found) == (reader.fileno(), poller.READABLE | poller.WRITABLE)
    reader.recv(1)
    writer.close()
    [(_, found)] = poller.wait(AGES)
    assert found & poller.READABLE  # an end is something to read
    poller.unwatch(reader.fileno())
    poller.unwatch(reader.fileno())
    poller.watch(reader.fileno(), poller.READABLE)
    poller.unwatch(reader.fileno())
    reader.close()


def test_a_poller_waits_as_long_as_it_should(poller: Any) -> None:
    begun = time.monotonic()
    assert poller.wait(0.06) == []
    assert time.monotonic() - begun >= 0.06


@not_on_windows("counts sockets, whatever their numbers")
def test_the_portable_poller_refuses_what_select_cannot_watch() -> None:
    poller = polling.Poller()
    with pytest.raises(OSError, match="1024 sockets"):
        poller.watch(5000, polling.Poller.READABLE)
    poller.close()


def test_on_windows_sockets_are_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(polling.sys, "platform", "win32")
    monkeypatch.setattr(polling, "_SELECT_TAKES", 1)
    poller, (reader, writer) = polling.Poller(), connected_pair()
    poller.watch(reader.fileno(), poller.READABLE)
    with pytest.raises(OSError, match="1 sockets"):
        poller.watch(writer.fileno(), poller.READABLE)
    for end in (poller, reader, writer):
        end.close()


def test_where_select_refuses_to_wait_for_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise OSError(10022, "Invalid argument")

    monkeypatch.setattr(
        polling.selectors,
        "SelectSelector",
        type("Refusing", (polling.selectors.SelectSelector,), {"select": refuse}),
    )
    poller = polling.Poller()
    assert poller.wait(0) == []
    poller.close()


def test_sleeps_on_windows_end_within_a_millisecond(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[int] = []
    monkeypatch.setattr(polling.sys, "platform", "win32")
    monkeypatch.setattr(
        ctypes, "windll", SimpleNamespace(winmm=SimpleNamespace(timeBeginPeriod=asked.append)), False
    )
    polling.sharpen_sleep()
    assert asked == [1]


def test_a_lab_in_real_time_and_programs_on_a_hub_have_their_sleeps_sharp(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sharp = threading.Event()
    monkeypatch.setattr(platform, "sharpen_sleep", sharp.set)
    with closing(pacing.Pacer(Timeline())):
        assert sharp.wait(AGES)
    sharp.clear()
    monkeypatch.setattr(client, "sharpen_sleep", sharp.set)
    with pytest.raises(HubError):
        client.LoopbackLink(str(tmp_path / "hub"), "program")
    assert sharp.is_set()
