"""A bus on the bench: nodes, faults, load, and a trace of its level."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from canwire.boards.catalogue import ideal_line, plug, sja1000_line, unplug
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults import Fault, Faults
from canwire.bus.can.node import Mailbox, Node
from canwire.bus.can.station import Tap
from canwire.bus.medium import one_way_delay_ps
from canwire.bus.vcd import VcdTrace
from canwire.drivers.driver import LineSettings
from canwire.errors import BadValue
from canwire.lab.node import LabNode
from canwire.lab.script import NodeScript
from canwire.values.acceptance import Acceptance
from canwire.values.frame import Frame, frame_of_record
from canwire.values.timing.bit_timing import BitTiming

if TYPE_CHECKING:
    from canwire.lab.bench import Lab

Filters = Iterable[Sequence[int]] | Acceptance


class LabBus:
    """One CAN bus; `faults` is what goes wrong on it."""

    def __init__(
        self,
        lab: Lab,
        name: str,
        timing: BitTiming,
        data_timing: BitTiming | None,
        iso_fd: bool,
        length_m: float,
        node_delay_ns: float,
    ) -> None:
        self.name = name
        self.timing = timing
        self.data_timing = data_timing
        self.iso_fd = iso_fd
        self.wire = CanBus(lab.timeline, name)
        self.wire.delay_ps = one_way_delay_ps(timing, length_m, node_delay_ns)
        self.faults = LabFaults(lab, self.wire, lab.seed)
        self.nodes: dict[str, LabNode] = {}
        self._lab = lab
        self._trace: tuple[VcdTrace, TextIO] | None = None
        self._tap: RecentFrames | None = None

    def node(
        self,
        name: str,
        script: NodeScript | None = None,
        *,
        filters: Filters | None = None,
        listen_only: bool = False,
        self_reception: bool = False,
        receives: bool = True,
        bit_rate: int | None = None,
        timing: BitTiming | None = None,
        data_timing: BitTiming | None = None,
        fd: bool = True,
        iso_fd: bool | None = None,
        oscillator_ppm: float = 0.0,
        receive_queue: int = 16_384,
        transmit_queue: int = 16_384,
        controller: str = "fd",
    ) -> LabNode:
        """A new node, started, on the bus since before its first frame.

        `controller` "sja1000" gives it that chip at 16 MHz with a driver that programs its registers, instead of the
        ideal one; it knows classic CAN only, and joins the bus after 11 recessive bits, as chips do.

        `filters` are (code, mask) pairs for 11-bit frames, (code, mask, True) for 29-bit ones; a mask bit of 1
        must match; without filters everything arrives. `self_reception` returns its own frames to it.
        `receives=False` makes a node that acknowledges but keeps nothing. Timing is the bus's unless given; `fd=False`
        makes a classic controller, which destroys FD frames as real ones do. Queues are in frames.
        `script` is the node's behaviour: see NodeScript.
        """
        self._lab.check_open()
        if name in self.nodes:
            raise BadValue(f"{self.name}: there is a node {name!r} already")
        nominal = timing or self.timing
        if bit_rate is not None:
            nominal = BitTiming.for_bit_rate(bit_rate, clock_hz=self.timing.clock_hz)
        data = (data_timing or self.data_timing) if fd else None
        iso = self.iso_fd if iso_fd is None else iso_fd
        if controller not in ("fd", "sja1000"):
            raise BadValue(f"controller {controller!r}: 'fd' or 'sja1000'")
        chip = controller == "sja1000"
        settings = LineSettings(
            nominal, None if chip else data, iso, listen_only, 0.0 if chip else oscillator_ppm
        )
        acceptance = None
        if filters is not None:
            acceptance = filters if isinstance(filters, Acceptance) else Acceptance.from_filters(filters)
        with self._lab.touch():
            if chip:
                line = sja1000_line(f"{self.name}/{name}", self._lab.timeline, ppm=oscillator_ppm)
            else:
                line = ideal_line(f"{self.name}/{name}", self._lab.timeline)
            node = LabNode(
                self._lab,
                self,
                name,
                line,
                settings,
                acceptance,
                self_reception,
                receives,
                receive_queue,
                transmit_queue,
            )
            plug(line, self.wire)
            node.begin()
        self.nodes[name] = node
        if script is not None:
            script.run_on(node)
        return node

    @property
    def load(self) -> float:
        """Busy bit times over elapsed bit times in the last second, 0..100 %."""
        return self.wire.account().percent(self._lab.now_ns)

    @property
    def mean_load(self) -> float:
        """The same since the lab began."""
        return 100.0 * self.wire.busy_ns() / max(1, self._lab.now_ns)

    @property
    def peak_load(self) -> float:
        """The busiest 100 ms so far, 0..100 %."""
        return self.wire.account().peak()

    @property
    def frames(self) -> int:
        """Frames that went through."""
        return self.wire.tally.frames

    @property
    def error_frames(self) -> int:
        return self.wire.tally.error_frames

    def trace_levels(self, path: str | Path) -> None:
        """Write the level on the bus to a VCD file (sigrok, PulseView, GTKWave) from now on."""
        with self._lab.touch():
            self.end_trace()
            file = Path(path).open("w", encoding="ascii")  # noqa: SIM115 - end_trace closes it
            self._trace = VcdTrace(self.wire, file, self.name), file

    def end_trace(self) -> None:
        """Finish the VCD file, if one is being written."""
        if self._trace is not None:
            (trace, file), self._trace = self._trace, None
            trace.close()
            file.close()

    def remember(self, limit: int) -> None:
        """Keep the last `limit` frames of the wire for `recent`."""
        self._tap = self.wire.tally.tap = RecentFrames(limit)

    def recent(self) -> list[tuple[str, Frame]]:
        """Sender and frame of the last frames, as far as `remember` asked for them."""
        return [] if self._tap is None else self._tap.frames()

    def stalled(self, after_ns: int) -> str | None:
        """Why this bus has got no frame through for `after_ns` although it is busy, or None."""
        for wire in (self.wire, *self.faults.islands()):
            if wire.busy():
                last_ns = max(wire.tally.last_success_ns, wire.busy_since_ns())
                if self._lab.now_ns - last_ns >= after_ns:
                    return self._complaint(after_ns)
        return None

    def _complaint(self, after_ns: int) -> str:
        waiting = [node for node in self.nodes.values() if node.pending]
        what = "; ".join(
            f"{node.name} ({node.state.name}, TEC {node.tec}) repeats its frame" for node in waiting
        )
        if not what:
            what = "the bus is shorted" if self.wire.bits.shorted else "a chip repeats its frame"
        return f"{self.name}: no frame got through for {after_ns / 1e9:g} s: {what}"

    def close(self) -> None:
        with self._lab.touch():
            self.end_trace()
            for node in self.nodes.values():
                node.close()


class LabFaults(Faults):
    """bus/can/faults.py, with nodes of the bench and with plugs that can be pulled."""

    def __init__(self, lab: Lab, bus: CanBus, seed: int) -> None:
        super().__init__(bus, seed)
        self._lab = lab
        self._home = bus
        self._islands: dict[LabNode, CanBus] = {}

    def flip(
        self,
        *,
        bit: int | str,
        frame_id: int | None = None,
        extended: bool | None = None,
        times: int | None = 1,
        seen_by: str | Node | LabNode = "all",
    ) -> Fault:
        """Invert one bit of matching frames for `seen_by`: "all", "receivers", "sender" or one node."""
        viewer = seen_by.line.controller if isinstance(seen_by, LabNode) else seen_by
        with self._lab.touch():
            return super().flip(bit=bit, frame_id=frame_id, extended=extended, times=times, seen_by=viewer)

    def islands(self) -> list[CanBus]:
        """The stubs of the nodes whose plug is pulled."""
        return list(self._islands.values())

    def disconnect(self, node: LabNode) -> None:
        """Pull the node's plug: it is alone on its own stub, at once, in the middle of a frame if need be."""
        if node not in self._islands:
            with self._lab.touch():
                unplug(node.line)
                island = self._islands[node] = CanBus(self._lab.timeline, f"{node.name} (disconnected)")
                plug(node.line, island)

    def reconnect(self, node: LabNode) -> None:
        """Put the plug back; the node waits for 11 recessive bits, as after a start."""
        if node in self._islands:
            with self._lab.touch():
                unplug(node.line)
                self._lab.timeline.remove(self._islands.pop(node))
                plug(node.line, self._home)
                node.line.driver.rejoin(self._lab.timeline.now_ns)

    def short(self) -> None:
        """Short the wires: the bus is dominant until `clear_short`."""
        with self._lab.touch():
            super().short()

    def clear_short(self) -> None:
        """Take the short away."""
        with self._lab.touch():
            super().clear_short()


class RecentFrames(Tap):
    """The last frames of a bus with their senders."""

    def __init__(self, limit: int) -> None:
        self._kept: deque[tuple[str, bytes, int]] = deque(maxlen=limit)

    def transmitted(self, node: Node, box: Mailbox, at_ns: int) -> None:
        self._kept.append((node.name, box.record(), at_ns))

    def frames(self) -> list[tuple[str, Frame]]:
        found = []
        for name, record, at_ns in self._kept:
            found.append((name, frame_of_record(at_ns.to_bytes(8, "little") + record[8:])))
        return found
