"""The CAN bus of a lab, and its nodes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from types import NoneType
from typing import Never, Protocol

from canwire.boards.can.neighbours import neighbours
from canwire.boards.catalogue import ideal_line, plug, sja1000_line, unplug
from canwire.bus.can.bus import CanBus
from canwire.bus.can.node import Mailbox, Node
from canwire.bus.can.tally import Tap
from canwire.bus.medium import one_way_delay_ps
from canwire.drivers.can_fd import LARGEST_OFFSET_PPM
from canwire.drivers.driver import LineSettings
from canwire.errors import BadTiming, BadValue
from canwire.lab.bus import BenchBus
from canwire.lab.can.faults import LabFaults
from canwire.lab.can.node import CanBenchNode
from canwire.lab.recent import MOST_KEPT, Recent
from canwire.lab.time import LabTime
from canwire.values.acceptance import Acceptance
from canwire.values.arguments import unknown_argument
from canwire.values.checks import instance, shown, whole
from canwire.values.controller_options import USUAL, ControllerOptions
from canwire.values.frame import Frame, frame_of_record
from canwire.values.mistakes.names import answers_wrong_names
from canwire.values.timing.agreement import timing_findings
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.check import NodeTiming, TimingCheck
from canwire.values.timing.limits import check_data_rate

Filters = Iterable[Sequence[int]] | Acceptance


class LabNode(CanBenchNode["LabBus"]):
    """One controller with one channel. Made by `LabBus.node`."""

    def close(self) -> None:
        """Leave the bus permanently, and free the name of the node; a second call does nothing."""
        super().close()
        self.bus.forget(self)


class Behaviour(Protocol):
    """The behaviour of a node; NodeScript in script.py is a base class for it."""

    def run_on(self, node: LabNode) -> None:
        """Start on this node."""


def _check_free(script: object) -> None:
    """Raise BadValue for a script that another node of an open lab uses: it would send from the second node only."""
    node = getattr(script, "node", None)
    if isinstance(node, LabNode) and not node.time.closed and node.bus.nodes.get(node.name) is node:
        kind = type(script).__name__
        raise BadValue(
            f"script {kind}: node {node.line.name} has this object; give each node a separate one, {kind}()"
        )


@answers_wrong_names
class LabBus(BenchBus[LabNode, Frame, CanBus]):
    """One CAN bus; `faults` sets faults on it."""

    def __init__(
        self,
        time: LabTime,
        name: str,
        timing: BitTiming,
        data_timing: BitTiming | None,
        iso_fd: bool,
        length_m: float,
        node_delay_ns: float,
        seed: int,
    ) -> None:
        super().__init__(time, name, CanBus(time.timeline, name))
        self.wire.delay_ps = one_way_delay_ps(timing, length_m, node_delay_ns)
        self.timing = timing
        self.data_timing = data_timing
        self.iso_fd = iso_fd
        self.faults = LabFaults(time, self.wire, seed)

    def node(
        self,
        name: str,
        script: Behaviour | None = None,
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
        options: ControllerOptions = USUAL,
        **unknown: Never,
    ) -> LabNode:
        """A new node, started; on an idle bus it takes part immediately.

        `controller` "sja1000" gives the node that chip at 16 MHz, with a driver that programs its registers, instead
        of the ideal controller. The chip supports classic CAN only, and joins the bus after 11 recessive bits.

        `filters` are (code, mask) pairs for 11-bit frames, (code, mask, True) for 29-bit ones; a mask bit of 1
        must match; without filters the node receives all frames. With `self_reception` it also receives the frames
        that it sends. With `receives=False` it acknowledges frames but stores none. The default timing is that of the
        bus. `fd=False` makes a classic controller, which destroys FD frames like a real one. Queue sizes are in frames.
        `options` are further options of FD controllers, and the delay of the transceiver: see ControllerOptions.
        `script` is the behaviour of the node: see NodeScript.
        """
        if unknown:
            raise unknown_argument("node()", unknown, LabBus.node)
        self._check_new(name)
        for part, wanted in (("timing", timing), ("data_timing", data_timing)):
            instance(part, wanted, BitTiming, NoneType)
        instance("options", options, ControllerOptions)
        instance("oscillator_ppm", oscillator_ppm, int, float)
        if (script is not None and not callable(getattr(script, "run_on", None))) or isinstance(script, type):
            raise TypeError(
                f"script {shown(script)}: must be an object such as MyScript(), of a class made from NodeScript"
            )
        _check_free(script)
        nominal = timing or self.timing
        if bit_rate is not None:
            nominal = BitTiming.for_bit_rate(bit_rate, clock_hz=self.timing.clock_hz)
        data = (data_timing or self.data_timing) if fd else None
        if data is not None:
            check_data_rate(nominal.bit_rate, data.bit_rate)
        iso = self.iso_fd if iso_fd is None else iso_fd
        if controller not in ("fd", "sja1000"):
            raise BadValue(f"controller {controller!r}: 'fd' or 'sja1000'")
        chip = controller == "sja1000"
        if not -LARGEST_OFFSET_PPM <= oscillator_ppm <= LARGEST_OFFSET_PPM:
            raise BadTiming(
                f"oscillator_ppm {oscillator_ppm}: from -{LARGEST_OFFSET_PPM} to {LARGEST_OFFSET_PPM}"
            )
        ppm = 0.0 if chip else oscillator_ppm
        settings = LineSettings(nominal, None if chip else data, iso, listen_only, ppm, options=options)
        acceptance = None
        if filters is not None:
            acceptance = filters if isinstance(filters, Acceptance) else Acceptance.from_filters(filters)
        with self.time.touch():
            if chip:
                line = sja1000_line(f"{self.name}/{name}", self.time.timeline, ppm=oscillator_ppm)
            else:
                line = ideal_line(f"{self.name}/{name}", self.time.timeline)
            node = LabNode(
                self.time,
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
            node.begin(self.wire.resting())
        self.nodes[name] = node
        if script is not None:
            script.run_on(node)
        return node

    def __repr__(self) -> str:
        data = "" if self.data_timing is None else f", {self.data_timing.bit_rate} after BRS"
        nodes = ", ".join(self.nodes) or "no node"
        counts = f"{self.frames} frames, {self.error_frames} error frames"
        return f"<CAN bus {self.name}, {self.timing.bit_rate} bit/s{data}: {nodes}; {counts}>"

    @property
    def frames(self) -> int:
        """Number of frames transmitted successfully."""
        return self.wire.tally.frames

    @property
    def error_frames(self) -> int:
        return self.wire.tally.error_frames

    @property
    def warnings(self) -> list[TimingCheck]:
        """Settings of the present nodes that could not work on a real bus; str() of each is a sentence with its remedy.

        They include chips that were attached by hand, and the lines of boards on the bus.
        """
        nodes = []
        for node in self.nodes.values():
            settings = node.settings
            nodes.append(
                NodeTiming(
                    node.name,
                    settings.timing,
                    settings.data_timing,
                    settings.oscillator_ppm,
                    options=settings.options,
                )
            )
        nodes += neighbours(self.wire.nodes, {node.line.controller for node in self.nodes.values()})
        return timing_findings(nodes, self.wire.delay_ps)

    def remember(self, limit: int) -> None:
        """Keep the last `limit` frames of the wire for `recent`."""
        tap = RecentFrames(whole("limit", limit, 0, MOST_KEPT))
        self._keep_in(tap)
        self.wire.tally.tap = tap

    def stalled(self, after_ns: int) -> str | None:
        """Why this busy bus has transmitted no frame for `after_ns`, or None."""
        for wire in (self.wire, *self.faults.islands()):
            if wire.busy():
                last_ns = max(wire.tally.last_success_ns, wire.busy_since_ns())
                if self.time.now_ns - last_ns >= after_ns:
                    return self._complaint(after_ns)
        return None

    def _unplug(self, node: LabNode) -> None:
        unplug(node.line)

    def _complaint(self, after_ns: int) -> str:
        waiting = [node for node in self.nodes.values() if node.pending]
        what = "; ".join(
            f"{node.name} ({node.state.name}, TEC {node.tec}) repeats its frame" for node in waiting
        )
        if not what:
            what = "the bus is shorted" if self.wire.bits.shorted else "a chip repeats its frame"
        doubts = "".join(f"; {warning}" for warning in self.warnings)
        return f"{self.name}: no frame got through for {after_ns / 1e9:g} s: {what}{doubts}"


class RecentFrames(Recent[Frame], Tap):
    """The last frames of a CAN bus, as records."""

    def transmitted(self, node: Node, box: Mailbox, at_ns: int) -> None:
        self.keep(node.name, box.record(), at_ns)

    def frame(self, data: bytes, at_ns: int) -> Frame:
        return frame_of_record(at_ns.to_bytes(8, "little") + data[8:])
