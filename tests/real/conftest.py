"""Real programs' libraries over `interface="canwire"`, found by the entry point, on a hub of their own."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import can
import pytest

from canwire.python_can import CanwireBus
from tests.hubs import serving


@pytest.fixture
def hub(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[str]:
    """A hub in real time that every Bus of the test finds, and python-can's name for us."""
    with serving(tmp_path, time="real") as served:
        monkeypatch.setenv("CANWIRE_HUB", served.address)
        monkeypatch.setitem(can.interfaces.BACKENDS, "canwire", ("canwire.python_can", CanwireBus.__name__))
        assert os.environ["CANWIRE_HUB"] == served.address
        yield served.address
