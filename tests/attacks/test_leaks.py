"""What a program forgets, or does in two threads at once, costs it no descriptors, and its hub no sessions."""

from __future__ import annotations

import contextlib
import gc
import os
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

import canwire
from canwire import ChannelMode, Closed, HubError, LineMode
from canwire.boards.lin.modes import LinMonitorMode
from canwire.bus.can.bus import CanBus
from canwire.bus.lin.bus import LinBus
from tests.cases import each
from tests.hubs import LONG_S, connected, embedded, serving, until

pytestmark = pytest.mark.skipif(
    not os.path.exists("/proc/self/fd"), reason="descriptors are counted in /proc"
)


def descriptors() -> int:
    gc.collect()
    return len(os.listdir("/proc/self/fd"))


@pytest.fixture
def address(tmp_path: Path) -> Iterator[str]:
    with serving(tmp_path) as (path, _):
        yield path


@pytest.mark.finding("faults 8")
def test_a_set_up_that_races_a_close_leaves_nothing(address: str) -> None:
    with canwire.connect(address) as hub:
        board = hub.boards()[0].id
        before = descriptors()
        for _ in range(200):
            channel, monitor = hub.open_channel(board, 0), hub.open_monitor(board, 2)

            def set_up(channel: canwire.HubChannel = channel, monitor: canwire.Monitor = monitor) -> None:
                with contextlib.suppress(Closed, HubError):
                    channel.set_up(ChannelMode(8, 8))
                with contextlib.suppress(Closed, HubError):
                    monitor.set_up(LinMonitorMode(8))

            threads = [threading.Thread(target=set_up) for _ in range(2)]
            for thread in threads:
                thread.start()
            channel.close()
            monitor.close()
            for thread in threads:
                thread.join(LONG_S)
        assert descriptors() <= before + 1


@pytest.mark.finding("faults 8")
def test_hubs_that_are_forgotten_are_collected(address: str) -> None:
    with canwire.connect(address) as watching:
        board = watching.boards()[0].id
        before = descriptors()
        for _ in range(20):
            hub = canwire.connect(address)
            channel = hub.open_channel(board, 0)
            channel.set_up(ChannelMode(8, 8))
            hub.create_fifo(10, 10)
            del hub, channel
        gc.collect()
        until(lambda: watching.line_status(board, 0).channels == 0)
        until(lambda: descriptors() <= before)


@pytest.mark.finding("faults 8")
def test_a_forgotten_hub_in_this_process_ends(capfd: pytest.CaptureFixture[str]) -> None:
    before, threads = descriptors(), threading.active_count()
    for _ in range(5):
        hub = canwire.connect(time="fast")
        channel = hub.open_channel(hub.boards()[0].id, 0)
        channel.set_up(ChannelMode(8, 8))
        del hub, channel
        gc.collect()
    until(lambda: threading.active_count() <= threads)
    until(lambda: descriptors() <= before)
    assert "Traceback" not in capfd.readouterr().err


def test_a_channel_keeps_its_hub(address: str) -> None:
    hub = canwire.connect(address)
    channel = hub.open_channel(hub.boards()[0].id, 0)
    del hub
    gc.collect()
    channel.set_up(ChannelMode(8, 8))
    assert not channel.status().active
    channel.hub.close()  # type: ignore[attr-defined]


@each("buses", [("can0", "can0", "lin0"), ("", "", ""), ("can0", "", "lin0")], ids=str)
def test_boards_take_their_buses_with_them(buses: tuple[str, ...]) -> None:
    """One that stayed was looked at in every step of the hub's time, and in the soak some hundred a minute did."""
    with embedded("", time="virtual") as engine, connected(engine) as hub:
        before = buses_there()
        for _ in range(3):
            board = hub.plug("usb-to-can-fd", buses=buses)
            assert buses_there() == before + buses.count("")
            hub.unplug(board.hardware_id)
            assert buses_there() == before


def test_a_dongle_whose_outputs_float_takes_its_stub_with_it() -> None:
    with embedded("", time="virtual") as engine, connected(engine) as hub:
        before = buses_there()
        for bus in ("can0", ""):
            board = hub.plug("canbus-dongle", buses=(bus,))
            control = hub.open_control(board.id, 0)
            timing = board.lines[0].capabilities.timing(500_000)
            control.initialise(LineMode(timing, registers=(("OCR", 0),)))
            control.start()
            assert buses_there() == before + 1 + (not bus)
            hub.unplug(board.hardware_id)
            assert buses_there() == before


def buses_there() -> int:
    gc.collect()
    return sum(type(one) in (CanBus, LinBus) for one in gc.get_objects())
