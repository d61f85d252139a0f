"""What CAN and LIN buses of a lab have in common: nodes by name, the bus load, and a trace of the level."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Generic, TypeVar

from canwire.bus.can.bus import CanBus
from canwire.bus.lin.bus import LinBus
from canwire.bus.vcd import VcdTrace
from canwire.errors import BadValue
from canwire.lab.node import BenchNode
from canwire.lab.recent import Recent, Witness
from canwire.lab.time import LabTime
from canwire.lab.trace_file import TraceFile

NodeT = TypeVar("NodeT", bound=BenchNode[Any, Any])
FrameT = TypeVar("FrameT")
WireT = TypeVar("WireT", bound=CanBus | LinBus)


class BenchBus(Generic[NodeT, FrameT, WireT]):
    """One bus on `wire`; subclasses put nodes on it."""

    def __init__(self, time: LabTime, name: str, wire: WireT) -> None:
        self.name = name
        self.wire = wire
        self.time = time
        self.nodes: dict[str, NodeT] = {}
        self._trace: tuple[VcdTrace, TraceFile] | None = None
        self._tap: Recent[FrameT] | None = None
        self._closes = False

    @property
    def load(self) -> float:
        """Bus load in the last second, 0..100 %: busy time divided by elapsed time."""
        return self.wire.account().percent(self.time.now_ns)

    @property
    def mean_load(self) -> float:
        """Bus load since the lab began, 0..100 %."""
        return 100.0 * self.wire.busy_ns() / max(1, self.time.now_ns)

    @property
    def peak_load(self) -> float:
        """Largest bus load in 100 ms so far, 0..100 %."""
        return self.wire.account().peak()

    def trace_levels(self, path: str | Path) -> None:
        """Write the level on the bus to a VCD file (sigrok, PulseView, GTKWave) from now on."""
        with self.time.touch():
            self.end_trace()
            file = TraceFile(path)
            self._trace = VcdTrace(self.wire, file, self.name), file

    def end_trace(self) -> None:
        """Finish the VCD file, if one is being written."""
        if self._trace is not None:
            (trace, file), self._trace = self._trace, None
            if file.left:
                trace.leave()
            else:
                trace.close()
            file.close()

    def recent(self) -> list[tuple[str, FrameT]]:
        """Sender and frame of the last frames; empty unless `remember` was called before."""
        return [] if self._tap is None else self._tap.frames()

    def remember(self, limit: int) -> None:
        """Keep the last `limit` frames of the wire for `recent`."""
        raise NotImplementedError

    def tell(self, witness: Witness) -> None:
        """Call `witness(sender, record, time in ns)` for each transmitted frame; `remember` continues to work."""
        if self._tap is None:
            self.remember(0)
        if self._tap is not None:
            self._tap.witness = witness

    def _keep_in(self, tap: Recent[FrameT]) -> None:
        if self._tap is not None:
            tap.witness = self._tap.witness
        self._tap = tap

    def close(self) -> None:
        self._closes = True  # the nodes remain in `nodes`, for use after the end
        with self.time.touch():
            self.end_trace()
            for node in self.nodes.values():
                node.close()

    def forget(self, node: NodeT) -> None:
        """Remove a closed node from the wire, and free its name."""
        if not self._closes and self.nodes.get(node.name) is node:
            with self.time.touch():
                del self.nodes[node.name]
                self._unplug(node)

    def _unplug(self, node: NodeT) -> None:
        raise NotImplementedError

    def _check_new(self, name: str) -> None:
        self.time.check_open()
        if name in self.nodes:
            raise BadValue(f"{self.name}: there is a node {name!r} already")
