"""A monitor of a LIN line and how its program waits for what comes: in time of the hub, and asleep in real time."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from canwire import (
    Closed,
    Hub,
    HubError,
    HubLost,
    LinControl,
    LinFrame,
    LinMode,
    LinMonitorMode,
    Monitor,
    NotInitialised,
    Unplugged,
)
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig, BusConfig
from tests.hub.handles.test_waiting import Waiter, in_real_time, until_asleep
from tests.hub.in_memory import Bench, bench_of

RATE = 20_000
LINE = 2
WORLD = Config(
    bus=(BusConfig(name="can0"), BusConfig(name="lin0", type="lin")),
    board=(BoardConfig(kind="usb-to-can-fd", serial="HW000001"),),
)
FRAME = LinFrame(0x11, b"\1\2")


bench = bench_of(WORLD)


@pytest.fixture
def hub(bench: Bench) -> Hub:
    return bench.hub("one")


@pytest.fixture
def master(bench: Bench) -> LinControl:
    """Of another program, so that its line goes on whatever becomes of the first one."""
    control = bench.hub("other").open_lin_control(bench.board, LINE)
    control.initialise(LinMode(True, RATE))
    control.start()
    return control


def monitor_of(bench: Bench, hub: Hub) -> Monitor:
    monitor = hub.open_monitor(bench.board, LINE)
    monitor.set_up(LinMonitorMode(16))
    monitor.activate()
    while monitor.receive() is not None:
        pass  # what the line has said of itself
    return monitor


def test_waiting_ends_with_the_frame_and_not_later(bench: Bench, hub: Hub, master: LinControl) -> None:
    monitor = monitor_of(bench, hub)
    for timeout in (10.0, None):
        master.send(FRAME)
        began_ns = hub.now_ns()
        frame = monitor.receive(timeout)
        assert frame == FRAME
        assert isinstance(frame, LinFrame)
        assert frame.timestamp_ns == hub.now_ns() > began_ns
    before_ns = hub.now_ns()
    assert monitor.receive(0.25) is None
    assert hub.now_ns() - before_ns == 250_000_000
    assert monitor.receive() is monitor.receive(0) is None
    assert hub.now_ns() - before_ns == 250_000_000


def test_what_is_there_is_not_waited_for(bench: Bench, hub: Hub, master: LinControl) -> None:
    monitor = monitor_of(bench, hub)
    for _ in range(2):
        master.send(FRAME)
        hub.run_for(0.1)
    now_ns = hub.now_ns()
    assert [monitor.receive(timeout) for timeout in (1.0, None, 0)] == [FRAME, FRAME, None]
    assert hub.now_ns() == now_ns


def test_waiting_for_ever_for_nothing_says_so(bench: Bench, hub: Hub) -> None:
    monitor = monitor_of(bench, hub)
    with pytest.raises(HubError, match="would never end"):
        monitor.receive(None)


def test_a_queue_keeps_what_came_until_its_monitor_stopped(
    bench: Bench, hub: Hub, master: LinControl
) -> None:
    monitor = monitor_of(bench, hub)
    master.send(FRAME)
    hub.run_for(0.1)
    monitor.deactivate()
    master.send(LinFrame(0x12, b"\3"))
    hub.run_for(0.1)
    assert (monitor.status().active, monitor.receive(), monitor.receive()) == (False, FRAME, None)
    monitor.activate()
    master.send(LinFrame(0x13, b"\4"))
    assert monitor.receive(1.0) == LinFrame(0x13, b"\4")
    monitor.set_up(LinMonitorMode(4))  # inactive again, and empty
    master.send(FRAME)
    assert (monitor.receive(0.1), monitor.status().active) == (None, False)


def test_before_its_queue_is_made_a_monitor_says_what_it_needs(bench: Bench, hub: Hub) -> None:
    monitor = hub.open_monitor(bench.board, LINE)
    with pytest.raises(NotInitialised, match="set it up first"):
        monitor.receive()
    monitor.close()
    with pytest.raises(Closed):
        monitor.receive()


@pytest.mark.parametrize(
    ("end", "outcome"),
    [
        (lambda bench, hub, monitor: monitor.close(), Closed),
        (lambda bench, hub, monitor: bench.hub("other").unplug("HW000001"), Unplugged),
        (lambda bench, hub, monitor: bench.link(hub).vanish(), HubLost),
        (lambda bench, hub, monitor: monitor.set_up(LinMonitorMode(4)), None),
    ],
    ids=["close", "unplug", "vanish", "set up"],
)
def test_whoever_waits_for_a_monitor_wakes_up(
    bench: Bench, hub: Hub, end: Callable[[Bench, Hub, Monitor], object], outcome: object
) -> None:
    monitor = monitor_of(bench, hub)
    in_real_time(bench, hub)
    waiter = Waiter(lambda: monitor.receive(None))
    until_asleep(bench, hub, monitor)
    end(bench, hub, monitor)
    assert waiter.result() == outcome
