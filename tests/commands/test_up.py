"""`canwire up` and `canwire stop`: a line goes on as it was set up."""

from __future__ import annotations

from dataclasses import replace

import pytest

import canwire
from canwire import BitTiming, LineMode
from canwire.commands import main

MODE = LineMode(BitTiming.for_bit_rate(250_000), listen_only=True)


def _run(address: str, *words: str) -> int:
    return main([*words, "--hub", address])


@pytest.fixture
def stopped(hub_address: str) -> str:
    """A hub whose HW000001:0 was set up by a program that has left it, and was stopped."""
    with canwire.connect(hub_address, name="engine") as hub:
        board = hub.board("HW000001").id
        with hub.open_control(board, 0) as control:
            control.initialise(replace(MODE, persistent=True))
            control.start()
    assert _run(hub_address, "stop", "HW000001:0") == 0
    return hub_address


@pytest.mark.conforms("N-03")
def test_a_stopped_line_goes_on_as_it_was_set_up(stopped: str, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert _run(stopped, "up", "HW000001:0") == 0
    assert capsys.readouterr().out == "HW000001:0 on can0: 250000 bit/s\n"
    with canwire.connect(stopped) as hub:
        status = hub.line_status(hub.board("HW000001").id, 0)
    assert status.running
    assert status.mode is not None
    assert (status.mode.listen_only, status.mode.persistent) == (True, True)


@pytest.mark.smoke
def test_another_rate_sets_it_up_anew(stopped: str, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert _run(stopped, "up", "HW000001:0", "--bit-rate", "125000") == 0
    assert capsys.readouterr().out.startswith("HW000001:0 on can0: 125000 bit/s")
    with canwire.connect(stopped) as hub:
        mode = hub.line_status(hub.board("HW000001").id, 0).mode
    assert mode is not None
    assert not mode.listen_only


def test_reset_forgets(stopped: str, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert _run(stopped, "stop", "HW000001:0", "--reset") == 0
    assert capsys.readouterr().out == "HW000001:0 reset\n"
    assert _run(stopped, "up", "HW000001:0") == 0
    assert capsys.readouterr().out.startswith("HW000001:0 on can0: 500000 bit/s")
