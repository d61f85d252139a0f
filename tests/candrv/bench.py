"""What stands around a CANDRV handle in tests: another machine, and a hub in virtual time."""

from __future__ import annotations

import os
from contextlib import ExitStack
from typing import Any

import canwire
from canwire import BitTiming, ChannelMode, Frame, LineMode, candrv
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.candrv import Handle
from canwire.candrv.registry.registry import RegistryStore
from canwire.hub.owner.engine import Engine
from tests.hubs import LONG_S, connected

BOARD, PEER_BOARD = "HW000104", "HW000001"
RATE = 1_000_000  # the registry's default


class Peer:
    """Another machine's line, started or (as long as `off`) not there at all."""

    def __init__(self, hub: canwire.Hub, *, off: bool = False, rate: int = RATE) -> None:
        board = hub.board(PEER_BOARD)
        self._control = hub.open_control(board.id, 0)
        self._control.initialise(LineMode(BitTiming.for_bit_rate(rate, clock_hz=8_000_000)))
        self._channel = hub.open_channel(board.id, 0)
        self._channel.set_up(ChannelMode(4000, 4000, filter_size=0))
        self._channel.activate()
        if not off:
            self._control.start()

    def start(self) -> None:
        self._control.start()

    def stop(self) -> None:
        self._control.stop()

    def send(self, *frames: Frame) -> None:
        for frame in frames:
            self._channel.send(frame, timeout=LONG_S)

    def receive(self, timeout: float | None = LONG_S) -> Frame | None:
        return self._channel.receive(timeout)

    def received(self, count: int) -> list[Frame]:
        frames = [self.receive() for _ in range(count)]
        assert None not in frames, f"{frames}: not {count}"
        return [frame for frame in frames if frame is not None]

    def close(self) -> None:
        self._channel.close()
        self._control.close()


class Bench:
    """A hub in virtual time with several programs, a peer, and what only a bench can do."""

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.hub = self.program("program")
        bus = engine.world.buses["can0"]
        assert isinstance(bus, CanBus)
        self.faults = Faults(bus, 1)
        self._closing = ExitStack()
        self._peer: Peer | None = None

    def program(self, name: str) -> canwire.Hub:
        return connected(self.engine, name)

    def open(self, *, accept: bool = True, hub: canwire.Hub | None = None, **how: Any) -> Handle:
        """A handle on CID1:; with `accept` every frame passes its filter."""
        made = candrv.open(hub=hub or self.hub, **how)
        self._closing.callback(made.close)
        if accept and made.readable:
            made.accept_all()
        return made

    @property
    def peer(self) -> Peer:
        if self._peer is None:
            self._peer = Peer(self.program("the rest"))
        return self._peer

    def absent_peer(self) -> Peer:
        self._peer = Peer(self.program("the rest"), off=True)
        return self._peer

    @property
    def board(self) -> int:
        """That of CID1:."""
        return self.hub.board(str(RegistryStore(os.environ["CANWIRE_CONFIG"]).get("CID1", "Board"))).id

    def unplug(self) -> None:
        """CID1:'s board."""
        self.hub.unplug(next(board.hardware_id for board in self.hub.boards() if board.id == self.board))

    def run(self, seconds: float) -> None:
        self.hub.run_for(seconds)

    def registers(self) -> dict[str, int]:
        found = self.hub.registers(self.board, 0)
        return {register.name: register.value for register in found}

    def __enter__(self) -> Bench:
        return self

    def __exit__(self, *error: object) -> None:
        self._closing.close()
        self.hub.close()
