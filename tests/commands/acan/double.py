"""Doubles of acan.Driver on a wire of their own: enough for the tools, without a hub, threads or time."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from canwire import CanwireError, Frame, InUse, NotInitialised, QueueFull, acan


class Wire:
    """Every driver on it hears the others."""

    def __init__(self) -> None:
        self.drivers: list[Driver] = []
        self.frames: list[Frame] = []  # everything that was sent

    def driver(self, config: acan.HardConfig | None = None, *, on_bus: bool = False) -> Driver:
        """One more machine."""
        self.drivers.append(Driver(self, config, on_bus))
        return self.drivers[-1]

    def put(self, frame: Frame, sender: Driver | None = None) -> None:
        """Sent by one of the machines, or from outside."""
        self.frames.append(frame)
        for driver in self.drivers:
            if driver is not sender:
                driver.hear(frame)


class Driver:
    """A machine's; `done` are the calls that change the controller."""

    version = (1, 0)
    controller = 0
    bus = ""  # nobody else is there

    def __init__(self, wire: Wire, config: acan.HardConfig | None, on_bus: bool) -> None:
        self.done: list[str] = []
        self.on_bus = on_bus
        self.holder = ""  # somebody else who holds the filters
        self.full = False
        self.failure: CanwireError | None = None
        self.blocks: list[acan.TaskBlock] = []
        self.lock: Any = threading.RLock()
        self.held = False
        self._wire = wire
        self._config = config

    @property
    def initialised(self) -> bool:
        return self._config is not None

    def config(self) -> acan.HardConfig | None:
        return self._config

    def configure(self, config: acan.HardConfig) -> None:
        if self.holder:
            raise InUse(f"INDU CAN 1: its control is held by {self.holder}")
        self._config, self.on_bus = config, False
        self.done.append("configure")

    @contextmanager
    def hold_filters(self) -> Iterator[None]:
        if self.holder:
            raise InUse(f"INDU CAN 1: its control is held by {self.holder}")
        self.held = True
        yield
        self.held = False

    def bus_on(self) -> bool:
        if self._config is None:
            raise NotInitialised("INDU CAN 1: configure it first")
        before, self.on_bus = self.on_bus, True
        if not before:
            self.done.append("on")
        return before

    def send(self, frame: Frame, priority: int = 1, timeout: float | None = 0) -> None:
        if self.full:
            raise QueueFull("INDU CAN 1", 256)
        assert priority == 1  # 0 would come back
        assert self.on_bus
        self._wire.put(frame, self)

    def register(self, block: acan.TaskBlock) -> acan.TaskBlock:
        block.attach(self)
        self.blocks.append(block)
        return block

    def deregister(self, block: acan.TaskBlock) -> None:
        if block in self.blocks:
            self.blocks.remove(block)
            block.detach()

    def wait(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        if self.failure is not None:
            raise self.failure
        return ready()

    def hear(self, frame: Frame) -> None:
        """From the bus, through the hardware filter, to the blocks."""
        config = self._config
        if config is None or not self.on_bus:
            return
        if not config.accepts(frame.id, frame.extended, frame.remote, frame.data):
            return
        for block in self.blocks:
            block.offer(frame, acan.acan_word(frame.id, frame.extended))
        self._notify()

    def happen(self, condition: acan.Condition, ecc: int | None = None, tec: int = 0, rec: int = 0) -> None:
        """A special condition."""
        from canwire.acan.task_block import Occurrence

        for block in self.blocks:
            block.occurred(Occurrence(int(condition), tec, rec, None, ecc))
        self._notify()

    def close(self) -> None:
        for block in list(self.blocks):
            self.deregister(block)

    def __enter__(self) -> Driver:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _notify(self) -> None:
        for block in self.blocks:
            if block.take_notification():
                block.notify()
