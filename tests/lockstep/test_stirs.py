"""A thread that takes no turns has one that does look again."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

import canwire
from tests.hubs import serving


@pytest.mark.timeout(30)
def test_a_call_from_outside_before_a_wait_ends_that_wait(tmp_path: Path) -> None:
    with (
        serving(tmp_path, "[[bus]]\nname = 'can0'\n", time="lockstep") as served,
        canwire.connect(served.address, timed=True) as hub,
    ):
        outside = threading.Thread(target=hub.stir)
        outside.start()
        outside.join()
        hub.wait_once(None)
        assert hub.now_ns() == 0
        hub.stir()  # its own: this is for the other threads of the program
        hub.wait_once(0.001)
        assert hub.now_ns() == 1_000_000
