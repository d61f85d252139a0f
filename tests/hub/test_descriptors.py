"""What hubs, channels and events have open goes with them, closed or not."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path

import pytest

import canwire
from canwire import ChannelMode, LinMonitorMode, candrv, vci
from canwire.errors import CanwireError
from canwire.hub.handles.channel import HubChannel
from canwire.vci import server
from tests.descriptors import nothing_left_open, open_descriptors
from tests.hubs import serving

LIN_LINE = 2


def _hub() -> canwire.Hub:
    return canwire.connect(time="virtual")


def _channel(hub: canwire.Hub) -> HubChannel:
    channel = hub.open_channel(hub.board("usb-to-can-fd").id, 0)
    channel.set_up(ChannelMode(10, 10))
    channel.activate()
    return channel


def _event() -> None:
    canwire.Event().fileno()


def _dropped_hub() -> None:
    _hub().boards()


def _dropped_channel() -> None:
    """Held in a circle: only the collector finds it."""
    circle: list[object] = [_channel(_hub())]
    circle.append(circle)


def _dropped_monitor() -> None:
    hub = _hub()
    monitor = hub.open_monitor(hub.board("usb-to-can-fd").id, LIN_LINE)
    monitor.set_up(LinMonitorMode(10))
    monitor.activate()


def _vci_program_that_lost_its_hub() -> None:
    hub = _hub()
    vci.initialize(hub)
    devices, event = vci.get_device_manager().enum_devices(), canwire.Event()
    devices.assign_event(event)
    hub.close()


def _candrv_program_that_lost_its_hub() -> None:
    hub = _hub()
    handle = candrv.open("CID1:", hub=hub)
    hub.close()
    assert handle.device.hub.lost


@pytest.mark.finding("faults 8")
@pytest.mark.parametrize(
    "program",
    [
        _event,
        _dropped_hub,
        _dropped_channel,
        _dropped_monitor,
        _vci_program_that_lost_its_hub,
        _candrv_program_that_lost_its_hub,
    ],
    ids=lambda program: program.__name__.strip("_"),
)
def test_what_nobody_holds_is_closed(program: Callable[[], None]) -> None:
    program()  # what is loaded and opened once
    server._process.clear()
    with nothing_left_open():
        for _ in range(3):
            program()
            vci.initialize(_hub())
        server._process.clear()


@pytest.mark.finding("faults 8")
def test_a_dropped_hub_ends_with_its_threads() -> None:
    canwire.connect(time="real").boards()
    with nothing_left_open():
        before = threading.active_count()
        for _ in range(3):
            canwire.connect(time="real").boards()
    assert threading.active_count() <= before  # those of the very first may have been about to end


@pytest.mark.finding("faults 8")
def test_what_a_dropped_client_held_is_free(tmp_path: Path) -> None:
    def take() -> None:
        hub = canwire.connect(address, name="forgetful")
        hub.open_control(hub.board("usb-to-can-fd").id, 0)

    with serving(tmp_path) as (address, _), canwire.connect(address, name="next") as hub, nothing_left_open():
        take()
        open_descriptors()  # and so waits for the thread that gives it back
        hub.open_control(hub.board("usb-to-can-fd").id, 0).close()


def test_a_channel_keeps_its_hub() -> None:
    """A program may hold what it uses, and nothing else."""
    channel = _channel(_hub())
    assert not channel.over
    assert channel.status().lost == 0
    channel.hub.close()


@pytest.mark.finding("faults 8")
def test_set_up_racing_close_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    """The channel is closed while the answer of `set_up` is on its way."""
    with _hub() as hub:
        board = hub.board("usb-to-can-fd").id
        ask = hub.ask

        def closed_meanwhile(request: object) -> object:
            answer = ask(request)  # type: ignore[arg-type]
            if type(request).__name__ in ("SetUpChannel", "SetUpMonitor"):
                monkeypatch.setattr(hub, "ask", ask)
                lease.close()
            return answer

        with nothing_left_open():
            for opened, mode in (
                (lambda: hub.open_channel(board, 0), ChannelMode(10, 10)),
                (lambda: hub.open_monitor(board, LIN_LINE), LinMonitorMode(10)),
            ):
                lease = opened()
                monkeypatch.setattr(hub, "ask", closed_meanwhile)
                lease.set_up(mode)  # type: ignore[arg-type]
                with pytest.raises(CanwireError, match="closed"):
                    _ = lease.reading
