"""A LIN bus on the bench: one master, slaves, faults, load, and a trace of its level."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from canwire.boards.catalogue import ideal_lin_line, plug_lin, unplug_lin
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.faults import LinFaults
from canwire.bus.lin.node import LinNode, LinResponse
from canwire.bus.lin.wire import LinTap
from canwire.bus.vcd import VcdTrace
from canwire.drivers.lin_driver import LinSettings
from canwire.errors import BadValue
from canwire.lab.lin_node import LabLinNode, Responses
from canwire.lab.spans import nanoseconds
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.record import TIME_SIZE, lin_frame_of_record
from canwire.values.lin.schedule import LinSchedule, LinSlot
from canwire.values.lin.timing import checked_rate

if TYPE_CHECKING:
    from canwire.lab.bench import Lab

Slot = int | LinSlot | tuple[int, float]
Table = LinSchedule | Iterable[Slot]
_DEFAULT_QUEUE = 16_384


class LabLinBus:
    """One LIN bus; `faults` is what goes wrong on it."""

    def __init__(self, lab: Lab, name: str, bit_rate: int, sleep_after: float | None) -> None:
        self.name = name
        self.bit_rate = checked_rate(bit_rate)
        idle_ns = None if sleep_after is None else nanoseconds("sleep_after", sleep_after)
        if idle_ns == 0:
            raise BadValue("sleep_after 0: a positive number of seconds, or None for never")
        self.wire = LinBus(lab.timeline, name, idle_ns=idle_ns)
        self.faults = LabLinFaults(lab, self.wire)
        self.nodes: dict[str, LabLinNode] = {}
        self._lab = lab
        self._trace: tuple[VcdTrace, TextIO] | None = None
        self._tap: RecentLinFrames | None = None

    def master(
        self,
        name: str = "master",
        *,
        schedule: Table | Mapping[str, Table] | None = None,
        responses: Responses | None = None,
        enhanced: bool = True,
        rival: bool = False,
        self_reception: bool = False,
        oscillator_ppm: float = 0.0,
        break_bits: int = 13,
        delimiter_bits: int = 1,
        header_space_bits: int = 0,
        response_space_bits: int = 0,
        byte_space_bits: int = 0,
        receive_queue: int = _DEFAULT_QUEUE,
    ) -> LabLinNode:
        """The master, started. `schedule` runs from now on, the first one where there are several by name.

        A schedule is a list of slots: LinSlot, an identifier (an unconditional frame with the usual delay), or
        (identifier, seconds to the next slot). `responses` are the frames it publishes itself, their checksum
        `enhanced` or classic. A second master is refused unless it says that it is a `rival`.
        `self_reception` returns its own responses to it. Spaces are in bits. Raises BadValue, BadTiming.
        """
        others = [node.name for node in self.nodes.values() if node.settings.master]
        if others and not rival:
            raise BadValue(
                f"{self.name}: {others[0]!r} is its master already, and a LIN bus has one; rival=True adds another"
            )
        settings = LinSettings(
            master=True,
            bit_rate=self.bit_rate,
            oscillator_ppm=oscillator_ppm,
            break_bits=break_bits,
            delimiter_bits=delimiter_bits,
            header_space_bits=header_space_bits,
            response_space_bits=response_space_bits,
            byte_space_bits=byte_space_bits,
        )
        tables = {} if schedule is None else _tables(schedule)
        node = self._node(name, settings, responses, enhanced, self_reception, receive_queue)
        if tables:
            node.schedule.add(tables)
            node.schedule.start()
        return node

    def slave(
        self,
        name: str = "slave",
        *,
        responses: Responses | None = None,
        subscribes: Mapping[int, int] | None = None,
        events: Mapping[int, int] | None = None,
        response_error: tuple[int, int] | None = None,
        enhanced: bool = True,
        self_reception: bool = False,
        bit_rate: int | None = None,
        oscillator_ppm: float = 0.0,
        synchronises: bool = True,
        response_space_bits: int = 0,
        byte_space_bits: int = 0,
        start_up: float = 0.0,
        receive_queue: int = _DEFAULT_QUEUE,
    ) -> LabLinNode:
        """A slave, started: it answers with its `responses` by identifier and hears everything.

        `subscribes` gives lengths of frames whose absence is an error to it. `events` gives for event-triggered
        identifiers which of its frames stands behind. `response_error` is (identifier, bit) of its error bit.
        `bit_rate` 0 finds the rate on the bus; a slave that `synchronises` follows the master within 14 %, by an
        oscillator that is off by `oscillator_ppm`. `start_up` (0 to 0.1 s) is how long it is deaf once
        started or woken. Raises BadValue, BadTiming, BadFrame.
        """
        settings = LinSettings(
            master=False,
            bit_rate=self.bit_rate if bit_rate is None else bit_rate,
            oscillator_ppm=oscillator_ppm,
            synchronises=synchronises,
            response_space_bits=response_space_bits,
            byte_space_bits=byte_space_bits,
            start_up_ns=nanoseconds("start_up", start_up),
        )
        node = self._node(name, settings, responses, enhanced, self_reception, receive_queue)
        node.set_up(subscribes or {}, events or {}, response_error)
        return node

    @property
    def load(self) -> float:
        """Busy time over elapsed time in the last second, 0..100 %."""
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
        """Responses that went through."""
        return self.wire.wire.frames

    def trace_levels(self, path: str | Path) -> None:
        """Write the level on the wire to a VCD file (sigrok, PulseView, GTKWave) from now on."""
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
        self._tap = self.wire.wire.tap = RecentLinFrames(limit)

    def recent(self) -> list[tuple[str, LinFrame]]:
        """Who answered, and the frame, of the last frames, as far as `remember` asked for them."""
        return [] if self._tap is None else self._tap.frames()

    def close(self) -> None:
        with self._lab.touch():
            self.end_trace()
            for node in self.nodes.values():
                node.close()

    def _node(
        self,
        name: str,
        settings: LinSettings,
        responses: Responses | None,
        enhanced: bool,
        self_reception: bool,
        receive_queue: int,
    ) -> LabLinNode:
        self._lab.check_open()
        if name in self.nodes:
            raise BadValue(f"{self.name}: there is a node {name!r} already")
        with self._lab.touch():
            line = ideal_lin_line(f"{self.name}/{name}", self._lab.timeline)
            line.controller.name = name
            node = LabLinNode(self._lab, self, name, line, settings, enhanced, self_reception, receive_queue)
            for id, data in (responses or {}).items():
                node.respond(id, data)
            plug_lin(line, self.wire)
            line.start()
        self.nodes[name] = node
        return node


class LabLinFaults(LinFaults):
    """bus/lin/faults.py, with nodes of the bench and with plugs that can be pulled."""

    def __init__(self, lab: Lab, bus: LinBus) -> None:
        super().__init__(bus)
        self._lab = lab
        self._islands: dict[LabLinNode, LinBus] = {}

    def disconnect(self, node: LabLinNode) -> None:
        """Pull the node's plug: it is alone on its own stub, at once, in the middle of a frame if need be."""
        if node not in self._islands:
            with self._lab.touch():
                unplug_lin(node.line)
                island = self._islands[node] = LinBus(self._lab.timeline, f"{node.name} (disconnected)")
                plug_lin(node.line, island)

    def reconnect(self, node: LabLinNode) -> None:
        """Put the plug back."""
        if node in self._islands:
            with self._lab.touch():
                unplug_lin(node.line)
                self._lab.timeline.remove(self._islands.pop(node))
                plug_lin(node.line, self._bus)

    def short(self, to: str = "ground") -> None:
        """Short the wire to "ground" (dominant) or to the "supply" (recessive), until `clear_short`."""
        with self._lab.touch():
            super().short(to)

    def clear_short(self) -> None:
        """Take the short away."""
        with self._lab.touch():
            super().clear_short()


class RecentLinFrames(LinTap):
    """The last frames of a bus, with who answered."""

    def __init__(self, limit: int) -> None:
        self._kept: deque[tuple[str, bytes, int]] = deque(maxlen=limit)

    def transmitted(self, node: LinNode, response: LinResponse, at_ns: int) -> None:
        self._kept.append((node.name, response.tail, at_ns))

    def frames(self) -> list[tuple[str, LinFrame]]:
        return [
            (name, lin_frame_of_record(at_ns.to_bytes(TIME_SIZE, "little") + tail))
            for name, tail, at_ns in self._kept
        ]


def _tables(schedule: Table | Mapping[str, Table]) -> dict[str, LinSchedule]:
    if isinstance(schedule, Mapping):
        return {name: _table(table, name) for name, table in schedule.items()}
    table = _table(schedule, "")
    return {table.name: table}


def _table(table: Table, name: str) -> LinSchedule:
    if isinstance(table, LinSchedule):
        return table
    slots: list[int | LinSlot] = []
    for slot in table:
        if isinstance(slot, tuple):
            id, seconds = slot
            slot = LinSlot.frame(id, delay_ns=nanoseconds("slot", seconds))
        slots.append(slot)
    return LinSchedule.of(slots, name)
