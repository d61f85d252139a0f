"""A dongle without a bus."""

from __future__ import annotations

from collections.abc import Sequence

from canwire import BusEvent, Frame, LineError
from canwire.slcan import Dongle, Eeprom, Settings, Setup


class FakeCan:
    """CanSide that notes what it is asked; tests put in what it has seen."""

    def __init__(self) -> None:
        self.opened: list[Setup] = []
        self.closed = 0
        self.sent: list[Frame] = []
        self.single_shots = 0
        self.frames: list[Frame] = []
        self.happened: list[BusEvent] = []
        self.lost_frames = 0
        self.refused = 0
        self.refuses: LineError | None = None

    def open(self, setup: Setup) -> None:
        if self.refuses is not None:
            raise self.refuses
        self.opened.append(setup)

    def close(self) -> None:
        self.closed += 1

    def send(self, frame: Frame, *, single_shot: bool = False) -> None:
        if self.refuses is not None:
            raise self.refuses
        self.sent.append(frame)
        self.single_shots += single_shot

    def poll(self) -> Sequence[Frame]:
        frames, self.frames = self.frames, []
        return frames

    def events(self) -> Sequence[BusEvent]:
        happened, self.happened = self.happened, []
        return happened

    def count_refused(self, count: int) -> None:
        self.refused += count

    def lost(self) -> int:
        return self.lost_frames


class Bench:
    """A dongle, its CAN side, and a host that reads at once."""

    def __init__(self, settings: Settings | None = None, eeprom: Eeprom | None = None) -> None:
        self.can = FakeCan()
        self.now_ns = 5_000_000_000
        self.dongle = Dongle(self.can, lambda: self.now_ns, settings, eeprom)

    def ask(self, data: bytes) -> bytes:
        self.dongle.feed(data)
        return self.read()

    def read(self) -> bytes:
        text = bytes(self.dongle.output)
        self.dongle.written(len(text))
        return text

    def through(self, count: int = 1) -> None:
        """So many frames get through."""
        for _ in range(count):
            self.can.frames.append(Frame(0, self_received=True))
        self.dongle.pump()

    def receive(self, *frames: Frame) -> bytes:
        self.can.frames += frames
        self.dongle.pump()
        return self.read()

    def happen(self, *events: BusEvent) -> None:
        self.can.happened += events
        self.dongle.pump()
