"""AutoResetEvent, ManualResetEvent and waiting for them; nothing here waits for long."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest

import canwire
from canwire.vci.v3 import AutoResetEvent, ManualResetEvent, WaitHandle


@pytest.fixture
def events() -> Iterator[Any]:
    made = [AutoResetEvent(), AutoResetEvent(), ManualResetEvent()]
    yield made
    for event in made:
        event.close()


def test_whoever_waits_takes_the_signal_of_an_auto_reset_event(events: Any) -> None:
    auto = events[0]
    assert not auto.wait_one(0)
    auto.set()
    assert auto.wait_one()
    assert not auto.wait_one(0)


@pytest.mark.finding("dialects 4")
def test_waits_have_nets_two_argument_form(events: Any) -> None:
    """.NET's exitContext: public programs write WaitOne(100, false)."""
    auto = events[0]
    assert not auto.wait_one(0, False)
    auto.set()
    assert auto.wait_one(100, False)
    auto.set()
    assert WaitHandle.wait_all([auto], 100, False)


def test_a_manual_reset_event_stays_signalled(events: Any) -> None:
    manual = events[2]
    manual.set()
    assert manual.wait_one()
    assert manual.wait_one(0)
    manual.reset()
    assert not manual.wait_one(0)


@pytest.mark.parametrize("kind", [AutoResetEvent, ManualResetEvent])
def test_events_may_begin_signalled(kind: type[WaitHandle]) -> None:
    event = kind(True)
    assert isinstance(event, canwire.Event)
    assert event.wait_one(0)
    event.close()


def test_wait_all_waits_for_all(events: Any) -> None:
    for event in events:
        event.set()
    assert WaitHandle.wait_all(events, 0)
    assert [event.is_set() for event in events] == [False, False, True]


@pytest.mark.finding("vci F11")
def test_wait_alls_timeout_is_for_all_of_them_together(events: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first signal comes after 250 of 400 ms of a clock that is handed in; the second wait has the rest."""
    clock_s, waited_s = [0.0], []

    def wait(event: Any, timeout_s: float) -> bool:
        waited_s.append(timeout_s)
        clock_s[0] += 0.25
        return len(waited_s) == 1

    monkeypatch.setattr(AutoResetEvent, "wait", wait)
    monkeypatch.setattr(AutoResetEvent, "clock_s", lambda event: clock_s[0])
    assert not WaitHandle.wait_all(events, 400)
    assert waited_s == pytest.approx([0.4, 0.15])
    assert [event.is_set() for event in events] == [True, False, False]


@pytest.mark.finding("vci F11")
def test_wait_alls_timeout_is_virtual_where_time_is(events: Any) -> None:
    with canwire.connect(time="virtual") as hub, hub.open_channel(hub.boards()[0].id, 0) as channel:
        channel.set_up(canwire.ChannelMode(10, 0))
        channel.reading.assign(events[0])
        before_ns = hub.now_ns()
        assert not WaitHandle.wait_all(events[:1], 60_000)
        assert hub.now_ns() - before_ns == 60_000_000_000


def test_wait_all_gives_signals_back(events: Any) -> None:
    events[0].set()
    assert not WaitHandle.wait_all(events, 0)
    assert [event.is_set() for event in events] == [True, False, False]
