"""What stands around an ACAN driver in tests: another machine, and a hub in virtual time."""

from __future__ import annotations

from collections.abc import Callable

import canwire
from canwire import BitTiming, ChannelMode, EventKind, Frame, LineMode
from canwire.acan.driver import Driver
from canwire.acan.task_block import TaskBlock
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.hub.owner.engine import Engine
from tests.hubs import LONG_S

BOARD, PEER_BOARD = "HW000104", "HW000001"
RATE = BitTiming.from_btr(0xC1, 0x49)  # what HardConfig() makes: 250 kbit/s

Arrived = Callable[[TaskBlock, int], list[Frame]]  # the next so many frames of a block


class Peer:
    """Another machine's line, started or (as long as `off`) not there at all."""

    def __init__(self, hub: canwire.Hub, *, off: bool = False) -> None:
        board = hub.board(PEER_BOARD)
        self._control = hub.open_control(board.id, 0)
        self._control.initialise(LineMode(RATE))
        self._channel = hub.open_channel(board.id, 0)
        self._channel.set_up(ChannelMode(500, 500, events=(EventKind.STATE,), filter_size=0))
        self._channel.activate()
        if not off:
            self._control.start()

    def start(self) -> None:
        self._control.start()

    def stop(self) -> None:
        self._control.stop()

    def send(self, *frames: Frame) -> None:
        for frame in frames:
            self._channel.send(frame)

    def receive(self, timeout: float | None = LONG_S) -> Frame | None:
        """The next frame; events on the way are dropped."""
        while True:
            found = self._channel.receive_any(timeout)
            if found is None or isinstance(found, Frame):
                return found

    def received(self, count: int) -> list[Frame]:
        frames = [self.receive() for _ in range(count)]
        assert None not in frames, f"{frames}: not {count}"
        return [frame for frame in frames if frame is not None]

    def close(self) -> None:
        self._channel.close()
        self._control.close()


class Virtual:
    """Virtual time, with what only a bench can do: disturb bits, look at the chip."""

    def __init__(self, engine: Engine, hub: canwire.Hub, driver: Driver) -> None:
        self.engine = engine
        self.hub = hub
        self.driver = driver
        bus = engine.world.buses["can0"]
        assert isinstance(bus, CanBus)
        self.faults = Faults(bus, 1)

    def peer(self, *, off: bool = False) -> Peer:
        return Peer(self.hub, off=off)

    def registers(self) -> dict[str, int]:
        found = self.hub.registers(self.hub.board(BOARD).id, 0)
        return {register.name: register.value for register in found}
