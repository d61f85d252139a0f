"""A hub for commands to share."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

from canwire import ChannelMode, Event, Hub, HubChannel, LinePlace, WantedMode, serve
from canwire.boards.config.configuration import Config
from canwire.commands.can_line import bring_up
from canwire.commands.shared_hub import find_line


@pytest.fixture
def hub_address(tmp_path: Path) -> Iterator[str]:
    """Socket of a hub with the default boards, served by a thread of this process in real time."""
    with served_here(tmp_path, Config.default()) as address:
        yield address


@contextmanager
def served_here(folder: Path, config: Config) -> Iterator[str]:
    """The same with other boards; its socket is in that folder."""
    address = str(folder / "hub.sock")
    ready, stop = threading.Event(), Event()
    thread = threading.Thread(
        target=serve,
        args=(address, config),
        kwargs={"ready": lambda text: ready.set(), "stop": stop},
    )
    thread.start()
    assert ready.wait(30)
    try:
        yield address
    finally:
        stop.set()
        thread.join(30)
        stop.close()


def running_lines(
    hub: Hub, closing: ExitStack, *names: str, transmit: int = 1
) -> list[tuple[LinePlace, HubChannel]]:
    """These lines brought up as verbs do it, each with a channel that is active: they acknowledge each other."""
    found = []
    for name in names:
        place = find_line(hub, name)
        channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
        channel.set_up(ChannelMode(receive=1, transmit=transmit))
        bring_up(hub, place, WantedMode())
        channel.activate()
        found.append((place, channel))
    return found
