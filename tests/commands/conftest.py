"""A hub for commands to share."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire import Event, serve
from canwire.boards.config.configuration import Config


@pytest.fixture
def hub_address(tmp_path: Path) -> Iterator[str]:
    """Socket of a hub with the default boards, served by a thread of this process in real time."""
    address = str(tmp_path / "hub.sock")
    ready, stop = threading.Event(), Event()
    thread = threading.Thread(
        target=serve,
        args=(address, Config.default()),
        kwargs={"ready": lambda text: ready.set(), "stop": stop},
    )
    thread.start()
    assert ready.wait(30)
    yield address
    stop.set()
    thread.join(30)
    stop.close()
