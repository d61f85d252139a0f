"""A hub for commands to share."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from canwire import Event, serve
from canwire.boards.config.configuration import Config


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
    yield address
    stop.set()
    thread.join(30)
    stop.close()
