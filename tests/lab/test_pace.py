"""Virtual time that is held to the wall clock, in a lab and in a hub of this process; the clock is set by hand."""

from __future__ import annotations

import asyncio
from collections.abc import Callable

import can
import pytest

import canwire
from canwire import held_time

LONG_S = 3600.0


class Clock:
    """The computer's, which passes while somebody sleeps."""

    def __init__(self) -> None:
        self.now_ns = 0
        self.at: dict[int, Callable[[], object]] = {}  # what somebody else does meanwhile, by the time

    def monotonic_ns(self) -> int:
        return self.now_ns

    def sleep(self, seconds: float) -> None:
        self.now_ns += round(seconds * 1e9)
        for time_ns in [time_ns for time_ns in self.at if time_ns <= self.now_ns]:
            self.at.pop(time_ns)()

    @property
    def now_s(self) -> float:
        return self.now_ns / 1e9


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    found = Clock()
    monkeypatch.setattr(held_time, "time", found)
    return found


@pytest.mark.parametrize("factor", [0.1, 1, 10])
def test_a_lab_waits_for_the_clock(clock: Clock, factor: float) -> None:
    with canwire.Lab() as lab:
        bus = lab.can_bus()
        a, b = bus.node("a"), bus.node("b")
        lab.set_pace(factor)
        lab.run_for(0.5)
        assert clock.now_s == pytest.approx(0.5 / factor, rel=0.01)
        lab.at(1_000_000_000, lambda: a.send(canwire.Frame(1)))
        frame = b.receive(timeout=LONG_S)
        assert frame is not None
        assert frame.timestamp_ns == 1_000_094_000
        assert clock.now_s == pytest.approx(1.0 / factor, rel=0.01)
        lab.at(1_500_000_000, lambda: a.send(canwire.Frame(2)))
        lab.run_until_idle()
        assert clock.now_s == pytest.approx(1.5 / factor, rel=0.01)
        lab.set_pace(None)
        lab.run_for(LONG_S)
        assert clock.now_s == pytest.approx(1.5 / factor, rel=0.01)


def test_what_nodes_do_is_the_same_at_every_pace(clock: Clock) -> None:
    def played(factor: float | None) -> list[canwire.Frame]:
        with canwire.Lab() as lab:
            bus = lab.can_bus()
            a, b = bus.node("a"), bus.node("b")
            lab.set_pace(factor)
            for at_ms in range(0, 100, 7):
                lab.at(at_ms * 1_000_000, lambda: a.send(canwire.Frame(1)))
                lab.at(at_ms * 1_000_000, lambda: b.send(canwire.Frame(2)))
            lab.run_until_idle()
            return [*a.receive_many(99), *b.receive_many(99)]

    assert played(0.3) == played(None)


def test_a_labs_asyncio_and_its_threads_are_held(clock: Clock) -> None:
    with canwire.Lab() as lab:
        lab.set_pace(1)
        lab.run(asyncio.sleep(0.25))
        assert clock.now_s == pytest.approx(0.25, rel=0.02)
        asyncio.run(lab.sleep(0.25))
        assert clock.now_s == pytest.approx(0.5, rel=0.02)
        with canwire.in_time(lab), can.Bus(interface="canwire", channel=lab.can_bus()) as bus:
            assert bus.recv(0.5) is None
        assert clock.now_s == pytest.approx(1.0, rel=0.02)


def test_a_hub_is_held_and_switched_while_somebody_waits(clock: Clock) -> None:
    with canwire.connect(time="virtual") as hub, canwire.in_time(hub):
        hub.set_pace(0.5)
        assert hub.time_state().pace == 0.5
        clock.at[2_000_000_000] = lambda: hub.set_pace(10)
        with can.Bus(interface="canwire", channel="can0", bitrate=500_000, hub=hub) as bus:
            assert bus.recv(11.0) is None
        assert hub.now_ns() / 1e9 == pytest.approx(11.0, abs=0.01)
        assert clock.now_s == pytest.approx(3.0, rel=0.05)


def test_an_answer_that_takes_time_is_held(clock: Clock) -> None:
    with canwire.connect(time="virtual") as hub:
        hub.set_pace(1)
        fault = hub.bus("can0").faults.short(lasting=0.3)
        fault.wait(LONG_S)
        assert clock.now_s == pytest.approx(0.3, rel=0.05)


def test_real_time_has_a_pace_of_its_own() -> None:
    with canwire.Lab(time="real") as lab, pytest.raises(canwire.WrongState, match="clock"):
        lab.set_pace(2)
    with canwire.connect(time="real") as hub, pytest.raises(canwire.WrongState, match="clock"):
        hub.set_pace(2)
    with canwire.Lab() as lab, pytest.raises(canwire.BadValue):
        lab.set_pace(0)
