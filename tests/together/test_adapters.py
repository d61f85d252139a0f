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
from canwire import ErrorState, Event, Frame, WantedMode, acan, slcan
from canwire.boards.config.configuration import Config
from canwire.bus.can.faults.faults import Faults
from tests.drivers.outside_bench import fresh_hub
from tests.hubs import LONG_S, connected
from tests.together.players.player import DONE, OTHER_RATE, RATE, Player
from tests.together.scene import BOARD, PEER_BOARD, PROVOKED, Peer, Scene, config_of
from tests.together.table import (
    ACAN,
    CANDRV,
    INT2D,
    JOIN_RUNNING,
    KINDS,
    PYTHON,
    RECOVER,
    SEES,
    SET_RATE,
    V4,
    VERBS,
    Cell,
    Line,
)
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


class OnCopper(Peer):
    """Another machine on the copper of an emulated dongle, and what disturbs that copper."""

    def __init__(self, hub: canwire.Hub) -> None:
        super().__init__(hub)
        self._engine = hub._link._engine  # type: ignore[attr-defined]
        self._faults = Faults(self._engine.world.buses["can0"], 1)

    def disturb(self, identifier: int, times: int | None) -> None:
        """The next so many attempts to send it fail (None: all of them)."""
        self._engine.call(lambda: self._faults.inject("bit", frame_id=identifier, times=times))

    def leave_in_peace(self) -> None:
        self._engine.call(self._faults.clear)


class FdOnCopper(OnCopper):
    """Likewise, with CAN FD: 2 Mbit/s after BRS, and frames of 12 bytes."""

    def __init__(self, hub: canwire.Hub) -> None:
        super().__init__(hub)
        capabilities = hub.board(PEER_BOARD).lines[0].capabilities
        self._control.stop()
        self._control.initialise(WantedMode(RATE, 2_000_000).mode(capabilities))
        self._control.start()

    def send(self, identifier: int) -> None:
        self._channel.send(Frame(identifier, bytes(12), fd=True, bit_rate_switch=True))


@contextmanager
def dongle_on(
    path: Path, machine: type[OnCopper] = OnCopper, dialect: slcan.Dialect = slcan.CANBUS
) -> Iterator[OnCopper]:
    """An emulated dongle on a pseudo terminal; the machine on its copper."""
    text = config_of("usb-to-can")
    if dialect is slcan.CANABLE:
        text = text.replace('"usb-to-can"', '"usb-to-can-fd"').replace('["can0", ""]', '["can0", "", ""]')
    copper = canwire.connect(time="real", config=Config.parse(text))
    stop, service = Event(manual_reset=True), slcan.Service()
    plugged = slcan.PluggedDongle(copper, slcan.Settings(dialect=dialect))
    with closing(slcan.PtyWire(path)) as wire:
        service.add(plugged.dongle, plugged.event, wire)
        thread = threading.Thread(target=service.run, args=(stop,), daemon=True)
        thread.start()
        try:
            yield machine(copper)
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
        made = Scene(lambda name: stack.enter_context(connected(engine, name)), request.param, peer)
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


@pytest.fixture
def on_dongle(tmp_path: Path) -> Iterator[Scene]:
    """The shared board is a dongle, whose copper can be disturbed."""
    with ExitStack() as stack:
        hub = stack.enter_context(fresh_hub())
        peer = stack.enter_context(dongle_on(tmp_path / "tty"))
        hub.plug(SLCAN, BOARD, port=str(tmp_path / "tty"))
        yield _scene_on(hub, SLCAN, peer, stack)


def _scene_on(hub: canwire.Hub, kind: str, peer: OnCopper, stack: ExitStack) -> Scene:
    engine = hub._link._engine  # type: ignore[attr-defined]
    made = Scene(lambda name: stack.enter_context(connected(engine, name)), kind, peer)
    stack.callback(made.close)
    return made


def _bus_off(scene: Scene, program: Player, peer: OnCopper) -> None:
    """Step by step: all that a dongle tells are changes, and only when it is asked."""
    for state, times in (
        (ErrorState.ERROR_WARNING, 13),
        (ErrorState.ERROR_PASSIVE, 4),
        (ErrorState.BUS_OFF, None),
    ):
        peer.disturb(PROVOKED, times)
        assert program.send(PROVOKED) == DONE
        assert scene.until(lambda wanted=state: scene.status().state == wanted), state  # type: ignore[misc]
    peer.leave_in_peace()


@pytest.mark.parametrize("actor", [V4, CANDRV, PYTHON, VERBS])
@pytest.mark.conforms("N-02", "N-06")
def test_after_bus_off_of_a_dongle_anybody_begins_again(on_dongle: Scene, actor: str) -> None:
    scene = on_dongle
    first, second = scene.play(PLAYERS[VERBS]), scene.play(PLAYERS[actor])
    assert first.set_up() == DONE
    assert scene.until(_at_work(scene))
    assert second.join() == DONE
    assert isinstance(scene.peer, OnCopper)
    _bus_off(scene, first, scene.peer)
    assert second.state() == SEES[actor][Line.BUS_OFF]
    assert second.recover() == Cell(scene.kind, VERBS, actor, RECOVER).told
    assert scene.until(_at_work(scene))
    assert scene.hear(first, second)


@pytest.mark.parametrize("starter", STARTERS)
@pytest.mark.conforms("N-01", "N-06")
def test_a_dongle_is_pulled_and_plugged(tmp_path: Path, starter: str) -> None:
    """The board stays; the hub waits for its adapter, and goes on with the line as it was."""
    with ExitStack() as stack:
        hub = stack.enter_context(fresh_hub())
        with dongle_on(tmp_path / "tty") as peer:
            hub.plug(SLCAN, BOARD, port=str(tmp_path / "tty"))
            scene = _scene_on(hub, SLCAN, peer, stack)
            first, second = scene.play(PLAYERS[starter]), scene.play(PLAYERS[VERBS])
            assert first.set_up() == DONE
            assert scene.until(_at_work(scene))
            assert second.join() == DONE
            assert scene.hear(first, second)
        assert scene.until(lambda: scene.status().state == ErrorState.STOPPED)
        with dongle_on(tmp_path / "tty") as again:
            scene.peer = again
            assert scene.until(_at_work(scene))
            assert scene.hear(first, second)
            assert scene.send(first) == DONE
        scene.peer = peer


@pytest.mark.parametrize("starter", [V4, VERBS])
@pytest.mark.conforms("N-01", "N-06")
def test_can_fd_on_a_shared_dongle(tmp_path: Path, starter: str) -> None:
    with ExitStack() as stack:
        hub = stack.enter_context(fresh_hub())
        peer = stack.enter_context(dongle_on(tmp_path / "tty", FdOnCopper, slcan.CANABLE))
        hub.plug("slcan-fd", BOARD, port=str(tmp_path / "tty"))
        scene = _scene_on(hub, "slcan-fd", peer, stack)
        first, second, third = (scene.play(PLAYERS[kind]) for kind in (starter, PYTHON, VERBS))
        assert first.set_up() == DONE
        assert scene.until(_at_work(scene))
        assert (second.join(), third.join()) == (DONE, DONE)
        assert scene.hear(first, third)
        assert (scene.send(first), scene.send(third)) == (DONE, DONE)
        mode = scene.status().mode
        assert mode is not None
        assert mode.data_timing is not None
        assert mode.data_timing.bit_rate == 2_000_000
