"""What is a shared dongle's own: its firmware's settings, its plug while the board stays, and CAN FD.

In real time; what programs do to each other on it is adapter_table.py's.
"""

from __future__ import annotations

import threading
from contextlib import ExitStack, closing
from pathlib import Path

import pytest

from canwire import ErrorState, acan, slcan
from tests.drivers.outside_bench import fresh_hub
from tests.drivers.slcan_dongle.fake_dongle import FakeDongle, usual
from tests.hubs import LONG_S
from tests.together.adapter_table import SLCAN
from tests.together.adapters import AdapterScene, FdOnCopper, adapter_scene, dongle_on
from tests.together.players.every import PLAYERS
from tests.together.players.player import DONE
from tests.together.scene import BOARD
from tests.together.table import ACAN, CANDRV, PYTHON, V4, VERBS, Line
from tests.together.test_matrix import program_settings

__all__ = ["program_settings"]  # pytest finds the fixture by its name here

pytestmark = pytest.mark.realtime

STARTERS = (VERBS, V4, CANDRV, PYTHON)


@pytest.mark.conforms("N-02")
@pytest.mark.finding("acan A2")
def test_acan_reads_and_sets_what_a_shared_dongle_has(tmp_path: Path) -> None:
    """Its OCR and IER are the firmware's own, so that asking for them is no reason to refuse."""
    with adapter_scene(SLCAN, tmp_path / "tty", "") as scene:
        first = scene.play(PLAYERS[ACAN])
        assert first.set_up() == DONE
        scene.settle(Line.ON)
        assert first.state() == "0x0100, hi_rat 250"
        assert scene.hear(first)
        with acan.open(scene.connect("another ACAN program")) as driver:
            config = driver.config()
            assert config is not None
            assert (config.rate_kbps, config.ts1, config.ts2) == (250, 13, 3)


@pytest.mark.parametrize("kind", [CANDRV, PYTHON])
@pytest.mark.conforms("N-01")
def test_who_sets_the_line_up_as_it_is_does_not_take_the_adapter_off_its_bus(
    tmp_path: Path, kind: str
) -> None:
    """It would lose the frames that it has acknowledged and not handed on yet."""
    dongle = FakeDongle(tmp_path / "tty")
    with closing(dongle), closing(fresh_hub()) as hub:
        board = hub.plug("slcan", BOARD, port=f"{dongle.link}?timeout={LONG_S}")
        starter, actor = PLAYERS[ACAN](hub, board), PLAYERS[kind](hub, board)
        assert starter.set_up() == DONE
        dongle.wait_for(b"F", 2)  # the second one is asked on the bus
        closed = dongle.lines.count(b"C")
        assert actor.join() == DONE
        dongle.wait_for(b"F", dongle.lines.count(b"F") + 2)
        assert dongle.lines.count(b"C") == closed
        actor.end()
        starter.end()


@pytest.mark.parametrize("kind", [CANDRV, PYTHON])
@pytest.mark.conforms("N-01")
def test_who_sets_the_line_up_as_it_is_while_its_adapter_is_being_opened_does_not_have_it_opened_anew(
    tmp_path: Path, kind: str
) -> None:
    """It would leave its bus again just after it has joined it."""
    asked, goes_on = threading.Event(), threading.Event()

    def slow(line: bytes) -> bytes:
        if line.startswith((b"S", b"s")):
            asked.set()
            assert goes_on.wait(LONG_S)
        return usual(line)

    dongle = FakeDongle(tmp_path / "tty", slow)
    with closing(dongle), closing(fresh_hub()) as hub:
        board = hub.plug("slcan", BOARD, port=f"{dongle.link}?timeout={LONG_S}")
        starter, actor = PLAYERS[ACAN](hub, board), PLAYERS[kind](hub, board)
        assert starter.set_up() == DONE
        assert asked.wait(LONG_S)
        assert actor.join() == DONE
        goes_on.set()
        dongle.wait_for(b"F", 3)
        assert dongle.lines.count(b"O") == 1
        actor.end()
        starter.end()


@pytest.mark.parametrize("starter", STARTERS)
@pytest.mark.conforms("N-01", "N-06")
def test_a_dongle_is_pulled_and_plugged(tmp_path: Path, starter: str) -> None:
    """The board stays; the hub waits for its adapter, and goes on with the line as it was."""
    with ExitStack() as stack:
        hub = stack.enter_context(fresh_hub())
        with dongle_on(tmp_path / "tty") as peer:
            scene = AdapterScene(hub, SLCAN, str(tmp_path / "tty"), peer, stack)
            first, second = scene.play(PLAYERS[starter]), scene.play(PLAYERS[VERBS])
            assert first.set_up() == DONE
            scene.settle(Line.ON)
            assert second.join() == DONE
            assert scene.hear(first, second)
        assert scene.until(lambda: scene.status().state == ErrorState.STOPPED)
        with dongle_on(tmp_path / "tty") as again:
            scene.peer = again
            scene.settle(Line.ON)
            assert scene.hear(first, second)
            assert scene.send(first) == DONE
        scene.peer = peer


@pytest.mark.parametrize("starter", [V4, VERBS])
@pytest.mark.conforms("N-01", "N-06")
def test_can_fd_on_a_shared_dongle(tmp_path: Path, starter: str) -> None:
    with ExitStack() as stack:
        hub = stack.enter_context(fresh_hub())
        peer = stack.enter_context(dongle_on(tmp_path / "tty", FdOnCopper, slcan.CANABLE))
        scene = AdapterScene(hub, "slcan-fd", str(tmp_path / "tty"), peer, stack)
        first, second, third = (scene.play(PLAYERS[kind]) for kind in (starter, PYTHON, VERBS))
        assert first.set_up() == DONE
        scene.settle(Line.ON)
        assert (second.join(), third.join()) == (DONE, DONE)
        assert scene.hear(first, third)
        assert (scene.send(first), scene.send(third)) == (DONE, DONE)
        mode = scene.status().mode
        assert mode is not None
        assert mode.data_timing is not None
        assert mode.data_timing.bit_rate == 2_000_000
