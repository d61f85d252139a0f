"""The faults of a lab's CAN bus: disturbed bits, disconnected nodes, a short."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from functools import partial
from typing import Any

from canwire.boards.can.line import Line
from canwire.boards.catalogue import plug, unplug
from canwire.boards.islands import Islands
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.disturbance import Changes
from canwire.bus.can.faults.faults import Fault, Faults
from canwire.bus.can.faults.forcing import When
from canwire.bus.can.node import Node
from canwire.bus.scripted import Scripted
from canwire.lab.can.node import CanBenchNode
from canwire.lab.selection import FAULTS, NOISE, call, selected
from canwire.lab.time import LabTime
from canwire.values.checks import instance
from canwire.values.mistakes.names import answers_wrong_names


@answers_wrong_names
class LabFaults(Faults):
    """Faults of bus/can/faults/faults.py for nodes of the lab, and nodes that can be disconnected."""

    def __init__(self, time: LabTime, bus: CanBus, seed: int) -> None:
        super().__init__(bus, seed)
        self._time = time
        self._home = bus
        self._islands: Islands[Line, CanBus] = Islands(time.timeline, CanBus, plug, unplug)
        if time.selection is not None:
            self.inverts = partial(time.selection.takes, NOISE)

    def flip(
        self,
        *,
        bit: int | str,
        frame_id: int | None = None,
        extended: bool | None = None,
        times: int | None = 1,
        seen_by: str | Node | CanBenchNode[Any] = "all",
    ) -> Fault:
        """Invert one bit of matching frames for `seen_by`: "all", "receivers", "sender" or one node."""
        viewer = self._controller(seen_by) if isinstance(seen_by, CanBenchNode) else seen_by
        with self._touch():
            fault = super().flip(bit=bit, frame_id=frame_id, extended=extended, times=times, seen_by=viewer)
        given = {"bit": bit, "frame_id": frame_id, "extended": extended, "times": times, "seen_by": seen_by}
        return selected(self._time.selection, fault, partial(self._words, "flip", given))

    def add_noise(self, bit_error_rate: float) -> Scripted:
        """Add noise to the noise set before."""
        noise = super().add_noise(bit_error_rate)
        given = {"bit_error_rate": bit_error_rate}
        return selected(self._time.selection, noise, partial(self._words, "noise", given))

    def _add(
        self, at: When, shape: Callable[[int, int], Changes], seen_by: object, times: int | None
    ) -> Scripted:
        forced = super()._add(at, shape, seen_by, times)
        given = {"at": at, "seen_by": seen_by, "times": times}
        return selected(self._time.selection, forced, partial(self._words, "a forced level", given))

    def _words(self, name: str, given: Mapping[str, object]) -> str:
        return f"{self._home.name}: {call(name, given)}"

    def _takes(self, name: str, **given: object) -> bool:
        """Whether the lab's selection lets a fault take place that has no object to cancel, such as a short."""
        selection = self._time.selection
        return selection is None or selection.takes(FAULTS, partial(self._words, name, given))

    def _controller(self, node: object) -> Node:
        if not isinstance(node, CanBenchNode):
            return super()._controller(node)
        controller: Node = node.line.controller
        return controller

    def _touch(self) -> AbstractContextManager[object]:
        return self._time.touch()

    def islands(self) -> list[CanBus]:
        """The stubs of the disconnected nodes."""
        return self._islands.stubs()

    def disconnect(self, node: CanBenchNode[Any]) -> None:
        """Disconnect the node: it is alone on a separate stub immediately, even in the middle of a frame."""
        instance("node", node, CanBenchNode)
        if self._takes("disconnect", node=node):
            with self._time.touch():
                self._islands.pull(node.line, node.name)

    def reconnect(self, node: CanBenchNode[Any]) -> None:
        """Connect the node again; it waits for 11 recessive bits, as after a start."""
        instance("node", node, CanBenchNode)
        with self._time.touch():
            self._islands.put_back(node.line, self._go_home)

    def short(self) -> None:
        """Short the wires: the bus is dominant until `clear_short`."""
        if self._takes("short"):
            with self._time.touch():
                super().short()

    def clear_short(self) -> None:
        """Remove the short."""
        with self._time.touch():
            super().clear_short()

    def _go_home(self, line: Line) -> None:
        plug(line, self._home)
        line.driver.rejoin(self._time.timeline.now_ns)
