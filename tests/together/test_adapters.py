"""Real adapters that are shared, as far as their own behaviour differs: an emulated dongle on a pseudo terminal, and an
adapter of python-can. In real time; what another program does to them is table.py's."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import can
import pytest

import canwire
from canwire import ErrorState, Event, acan, slcan
from canwire.boards.config.configuration import Config
from tests.drivers.outside_bench import fresh_hub
from tests.hubs import LONG_S, connected
from tests.together.players.player import DONE, OTHER_RATE, Player
from tests.together.scene import BOARD, Peer, Scene, config_of
from tests.together.table import ACAN, CANDRV, INT2D, JOIN_RUNNING, KINDS, PYTHON, SET_RATE, V4, VERBS, Cell
from tests.together.test_matrix import PLAYERS, program_settings

__all__ = ["program_settings"]  # pytest finds the fixture by its name here

pytestmark = pytest.mark.realtime

SLCAN, PYTHON_CAN = "slcan", "python-can"
REFUSES = {
    (kind, PYTHON_CAN): "ACAN_Init 0" for kind in (ACAN, INT2D)
}  # no SJA1000 there, as far as anybody knows
STARTERS = (VERBS, V4, CANDRV, PYTHON)
ACTORS = [kind for kind in KINDS if kind != "dongle host"]


class OnPythonCan:
    """Another machine behind python-can's `virtual`, the adapter's own bus."""

    def __init__(self, channel: str) -> None:
        self._bus = can.Bus(interface="virtual", channel=channel)
        self._heard: set[int] = set()

    def send(self, identifier: int) -> None:
        self._bus.send(can.Message(arbitration_id=identifier, is_extended_id=False))

    def hears(self, identifier: int) -> bool:
        while (message := self._bus.recv(0)) is not None:
            self._heard.add(message.arbitration_id)
        return identifier in self._heard

    def close(self) -> None:
        self._bus.shutdown()


@contextmanager
def dongle_on(path: Path) -> Iterator[Peer]:
    """An emulated dongle on a pseudo terminal; the machine on its copper."""
    copper = canwire.connect(time="real", config=Config.parse(config_of("usb-to-can")))
    stop, service = Event(manual_reset=True), slcan.Service()
    plugged = slcan.PluggedDongle(copper, slcan.Settings())
    with closing(slcan.PtyWire(path)) as wire:
        service.add(plugged.dongle, plugged.event, wire)
        thread = threading.Thread(target=service.run, args=(stop,), daemon=True)
        thread.start()
        try:
            yield Peer(copper)
        finally:
            stop.set()
            thread.join(LONG_S)
    plugged.close()
    copper.close()


@pytest.fixture(params=[SLCAN, PYTHON_CAN])
def scene(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Scene]:
    with ExitStack() as stack:
        hub = stack.enter_context(fresh_hub())
        engine = hub._link._engine  # type: ignore[attr-defined]
        peer: Peer | OnPythonCan
        if request.param == SLCAN:
            peer = stack.enter_context(dongle_on(tmp_path / "tty"))
            hub.plug(SLCAN, BOARD, port=str(tmp_path / "tty"))
        else:
            peer = stack.enter_context(closing(OnPythonCan(request.node.name)))
            hub.plug(PYTHON_CAN, BOARD, port=f"virtual/{request.node.name}")
        made = Scene(lambda name: stack.enter_context(connected(engine, name)), request.param, engine, peer)
        stack.callback(made.close)
        yield made


def _at_work(scene: Scene) -> Callable[[], bool]:
    return lambda: scene.status().running and scene.status().state == ErrorState.ERROR_ACTIVE


@pytest.mark.parametrize("actor", ACTORS)
@pytest.mark.parametrize("starter", STARTERS)
@pytest.mark.conforms("N-01", "N-02", "N-06")
@pytest.mark.finding("acan A2")
def test_an_adapter_is_shared(scene: Scene, starter: str, actor: str) -> None:
    first = scene.play(PLAYERS[starter])
    assert first.set_up() == DONE
    assert scene.until(_at_work(scene))
    second = scene.play(PLAYERS[actor])
    if (actor, scene.kind) in REFUSES:
        assert second.join() == REFUSES[actor, scene.kind]
        assert scene.hear(first)
        return
    assert second.join() == Cell(scene.kind, starter, actor, JOIN_RUNNING).told
    assert scene.hear(first, second)
    assert (scene.send(first), scene.send(second)) == (DONE, DONE)
    told = Cell(scene.kind, starter, actor, SET_RATE).told
    assert second.set_rate(OTHER_RATE) == told
    assert told == DONE or scene.hear(first, second)


@pytest.mark.conforms("N-02")
@pytest.mark.finding("acan A2")
def test_acan_reads_and_sets_what_a_shared_dongle_has(scene: Scene) -> None:
    """Its OCR and IER are the firmware's own, so that asking for them is no reason to refuse."""
    if scene.kind != SLCAN:
        pytest.skip("ACAN drives no adapter of python-can")
    first: Player = scene.play(PLAYERS[ACAN])
    assert first.set_up() == DONE
    assert scene.until(_at_work(scene))
    assert first.state() == "0x0100, hi_rat 250"
    assert scene.hear(first)
    with acan.open(scene.connect("another ACAN program")) as driver:
        config = driver.config()
        assert config is not None
        assert (config.rate_kbps, config.ts1, config.ts2) == (250, 13, 3)
