"""A hub in real time with a program on the line of a real adapter; used by tests alone."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

import canwire
from canwire import (
    BitTiming,
    BoardInfo,
    BusEvent,
    ChannelMode,
    ErrorState,
    EventKind,
    Frame,
    Hub,
    LineMode,
)
from canwire.boards.config.configuration import Config

AGES_S = 60.0
CONFIRM = 1 << 13
TIMING = BitTiming.from_btr(0x00, 0x1C)
EVENTS = tuple(int(kind) for kind in EventKind)


def fresh_hub(time: str = "real") -> Hub:
    """A fresh one without boards, in this process."""
    return canwire.connect(time=time, config=Config())


class Program:
    """Holds the line of a board, with one channel that hears everything."""

    def __init__(self, hub: Hub, board: BoardInfo, mode: LineMode | None = None, queue: int = 4096) -> None:
        self.hub = hub
        self.board = board
        self.control = hub.open_control(board.id, 0)
        self.channel = hub.open_channel(board.id, 0)
        self.channel.set_up(ChannelMode(queue, queue, filter_size=0, events=EVENTS, confirms=True))
        self.channel.activate()
        self.control.initialise(mode or LineMode(TIMING, error_frames=True))

    def start(self) -> Program:
        """And wait until the adapter is on its bus."""
        self.control.start()
        self.wait(on_bus)
        return self

    def send(self, *frames: Frame) -> None:
        for frame in frames:
            self.channel.send(frame, CONFIRM, AGES_S)

    def next(self) -> Frame | BusEvent | None:
        return self.channel.receive_any(AGES_S)

    def wait(self, wanted: Callable[[Any], bool]) -> list[Frame | BusEvent]:
        """Everything up to what is wanted."""
        found: list[Frame | BusEvent] = []
        deadline = time.monotonic() + AGES_S
        while time.monotonic() < deadline:
            happening = self.channel.receive_any(max(0, deadline - time.monotonic()))
            if happening is not None:
                found.append(happening)
                if wanted(happening):
                    return found
        raise AssertionError(f"it never came; there were {found}")

    def status(self) -> Any:
        return self.hub.line_status(self.board.id, 0)


def on_bus(happening: Any) -> bool:
    return is_event(happening, EventKind.STATE) and happening.state is ErrorState.ERROR_ACTIVE


def gone(happening: Any) -> bool:
    return is_event(happening, EventKind.STATE) and happening.state is ErrorState.STOPPED


def is_event(happening: Any, kind: EventKind) -> bool:
    return isinstance(happening, BusEvent) and happening.kind is kind


def a_frame(happening: Any) -> bool:
    return isinstance(happening, Frame)


def trouble(code: int) -> Callable[[Any], bool]:
    return lambda happening: is_event(happening, EventKind.ERROR) and happening.code == code
