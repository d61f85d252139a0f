"""Scenes on real adapters that are shared, in real time: an emulated dongle on a pseudo terminal, whose copper can be
disturbed, and an adapter of python-can."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path

import can

import canwire
from canwire import ChannelMode, ErrorState, Event, Frame, WantedMode, slcan
from canwire.boards.config.configuration import Config
from canwire.bus.can.faults.faults import Faults
from tests.drivers.outside_bench import fresh_hub
from tests.hubs import LONG_S, connected
from tests.together.adapter_table import PYTHON_CAN, SLCAN
from tests.together.players.player import RATE
from tests.together.scene import BOARD, PEER_BOARD, PROVOKED, OtherMachine, Peer, Scene, config_of
from tests.together.table import Line


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


class AdapterScene(Scene):
    """The shared board is an adapter at `port`. Its line is on the bus a while after the call that starts it."""

    def __init__(self, hub: canwire.Hub, kind: str, port: str, peer: OtherMachine, stack: ExitStack) -> None:
        engine = hub._link._engine  # type: ignore[attr-defined]
        super().__init__(lambda name: stack.enter_context(connected(engine, name)), kind, peer)
        self._port = port
        self.plug()
        stack.callback(self.close)

    def plug(self) -> None:
        self.hub.plug(self.kind, BOARD, port=self._port)

    def at_work(self) -> bool:
        status = self.status()
        return status.running and status.state == ErrorState.ERROR_ACTIVE

    def settle(self, line: Line) -> None:
        if line is Line.ON:
            assert self.until(self.at_work)

    def bus_off(self) -> None:
        """Step by step: all that a dongle tells are changes, and only when it is asked."""
        assert isinstance(self.peer, OnCopper)
        with self.hub.open_channel(self.board.id, 0) as channel:
            channel.set_up(ChannelMode(1, 8, frames=False))
            channel.activate()
            for wanted, times in _DOWN:
                self.peer.disturb(PROVOKED, times)
                channel.send(Frame(PROVOKED))
                assert self.until(lambda wanted=wanted: self.status().state == wanted), wanted  # type: ignore[misc]
            self.peer.leave_in_peace()
            channel.cancel()


_DOWN = ((ErrorState.ERROR_WARNING, 13), (ErrorState.ERROR_PASSIVE, 4), (ErrorState.BUS_OFF, None))


@contextmanager
def adapter_scene(kind: str, path: Path, channel: str) -> Iterator[AdapterScene]:
    """On an emulated dongle that appears at `path`, or on that channel of python-can's `virtual`."""
    with ExitStack() as stack:
        hub = stack.enter_context(fresh_hub())
        if kind == PYTHON_CAN:
            peer: OtherMachine = stack.enter_context(closing(OnPythonCan(channel)))
            yield AdapterScene(hub, kind, f"virtual/{channel}", peer, stack)
        else:
            assert kind == SLCAN, kind
            peer = stack.enter_context(dongle_on(path))
            yield AdapterScene(hub, kind, str(path), peer, stack)
