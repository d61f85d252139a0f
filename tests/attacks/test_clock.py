"""A clock of the wall that somebody sets, while programs work: bus time does not follow it, stamps of the day do."""

from __future__ import annotations

import time

import pytest

import canwire
from canwire.hub.wall_clock import epoch_ns
from tests.hubs import LONG_S

DAY_NS = 86_400 * 10**9


def _channel(hub: canwire.Hub, number: int) -> canwire.HubChannel:
    """On the first line of a board, all of which are on can0."""
    board = hub.boards()[number].id
    with hub.open_control(board, 0) as control:
        control.initialise(canwire.LineMode(hub.boards()[number].lines[0].capabilities.timing(500_000)))
        channel = hub.open_channel(board, 0)
        channel.set_up(canwire.ChannelMode(16, 16))
        channel.activate()
        control.start()
    return channel


@pytest.mark.realtime
@pytest.mark.parametrize("jump_ns", [DAY_NS, -DAY_NS], ids=["forward", "back"])
def test_bus_time_goes_on_as_before(monkeypatch: pytest.MonkeyPatch, jump_ns: int) -> None:
    with canwire.connect(time="real") as hub:
        sending, receiving = (_channel(hub, number) for number in (0, 1))
        sending.send(canwire.Frame(1))
        first = receiving.receive(LONG_S)
        day_ns = epoch_ns(hub)
        ours, nanoseconds = time.time, time.time_ns
        monkeypatch.setattr(time, "time", lambda: ours() + jump_ns / 1e9)
        monkeypatch.setattr(time, "time_ns", lambda: nanoseconds() + jump_ns)
        sending.send(canwire.Frame(2))
        second = receiving.receive(LONG_S)
        assert first is not None
        assert second is not None
        assert 0 < second.timestamp_ns - first.timestamp_ns < DAY_NS // 2
        assert receiving.receive(0.001) is None  # not in a day, and not never
        assert abs(epoch_ns(hub) - day_ns - jump_ns) < DAY_NS // 2
