"""The LIN bus of a lab, and its nodes: one master, and slaves."""

from __future__ import annotations

from collections.abc import Mapping
from types import NoneType

from canwire.boards.catalogue import ideal_lin_line, plug_lin, unplug_lin
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.node import LinNode, LinResponse
from canwire.bus.lin.wire import LinTap
from canwire.drivers.lin_driver import LinSettings
from canwire.errors import BadValue
from canwire.lab.bus import BenchBus
from canwire.lab.lin.exchange import exchange
from canwire.lab.lin.faults import LabLinFaults
from canwire.lab.lin.node import LinBenchNode, Responses
from canwire.lab.lin.schedule import Table, tables_of
from canwire.lab.recent import MOST_KEPT, Recent
from canwire.lab.time import LabTime
from canwire.values.checks import instance, nanoseconds, whole
from canwire.values.lin.configuration import LinNodeAttributes
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.record import TIME_SIZE, lin_frame_of_record
from canwire.values.lin.timing import checked_rate
from canwire.values.mistakes.names import answers_wrong_names

_DEFAULT_QUEUE = 16_384


class LabLinNode(LinBenchNode["LabLinBus"]):
    """One LIN controller with one receive queue. Made by `LabLinBus.master` and `LabLinBus.slave`.

    `schedule` controls the schedules of a master: `start`, `stop`, `request`.
    """

    def request(self, nad: int, payload: bytes, *, within: float = 1.0) -> bytes:
        """Masters only: send a request (SID and data, 1 to 4095 bytes) to this NAD, and return the answer's payload.

        Returns b"" for a functional request (NAD 0x7E). Up to `within` seconds pass. Raises NotReceived, WrongState.
        """
        self._check_open()
        return exchange(self.time, self.line, nad, payload, within)

    def close(self) -> None:
        """Leave the bus permanently, and free the name of the node; a second call does nothing."""
        super().close()
        self.bus.forget(self)


@answers_wrong_names
class LabLinBus(BenchBus[LabLinNode, LinFrame, LinBus]):
    """One LIN bus; `faults` sets faults on it."""

    def __init__(self, time: LabTime, name: str, bit_rate: int, sleep_after: float | None) -> None:
        self.bit_rate = checked_rate(bit_rate)
        idle_ns = None if sleep_after is None else nanoseconds("sleep_after", sleep_after)
        if idle_ns == 0:
            raise BadValue("sleep_after 0: a positive number of seconds, or None for never")
        super().__init__(time, name, LinBus(time.timeline, name, idle_ns=idle_ns))
        self.faults = LabLinFaults(time, self.wire)

    def master(
        self,
        name: str = "master",
        *,
        schedule: Table | Mapping[str, Table] | None = None,
        responses: Responses | None = None,
        enhanced: bool = True,
        checksums: Mapping[int, bool] | None = None,
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
        """A new master, started. `schedule` runs from now on; of several schedules by name, the first one runs.

        A schedule is a list of slots: a LinSlot, an identifier (an unconditional frame with the default delay), or
        (identifier, seconds to the next slot). `responses` are the frames that the master publishes, with `enhanced`
        or classic checksum. It accepts received frames with either checksum, except those in `checksums` (True: only
        enhanced, False: only classic). A second master needs `rival=True`. With `self_reception` it also receives
        its own responses. Spaces are in bits. Raises BadValue, BadTiming.
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
        _check_mapping("responses", responses)
        _check_mapping("checksums", checksums)
        tables = {} if schedule is None else tables_of(schedule)
        node = self._node(name, settings, responses, enhanced, self_reception, receive_queue)
        node.set_up({}, {}, None, checksums or {})
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
        checksums: Mapping[int, bool] | None = None,
        attributes: LinNodeAttributes | None = None,
        self_reception: bool = False,
        bit_rate: int | None = None,
        oscillator_ppm: float = 0.0,
        synchronises: bool = True,
        response_space_bits: int = 0,
        byte_space_bits: int = 0,
        start_up: float = 0.0,
        receive_queue: int = _DEFAULT_QUEUE,
    ) -> LabLinNode:
        """A new slave, started: it answers with its `responses` by identifier, and receives all frames.

        `subscribes` maps identifiers to the lengths of expected frames. A missing expected frame is an error, as is a
        checksum other than the default (`enhanced` or classic) or the one in `checksums` (True: enhanced). `events`
        maps event-triggered identifiers to the slave's frames. `response_error` is (identifier, bit) of its
        error bit. With `attributes` it answers node configuration and identification, see `configuration`.
        `bit_rate` 0 detects the rate on the bus; a slave that `synchronises` follows the master within 14 %, with an
        oscillator that is off by `oscillator_ppm`. During `start_up` (seconds, 0 to 0.1) after start or wake-up, it
        receives nothing. Raises BadValue, BadTiming, BadFrame.
        """
        given = {"responses": responses, "subscribes": subscribes, "events": events, "checksums": checksums}
        for what, mapping in given.items():
            _check_mapping(what, mapping)
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
        node.set_up(subscribes or {}, events or {}, response_error, checksums or {})
        if attributes is not None:
            node.configure(attributes)
        return node

    def __repr__(self) -> str:
        nodes = ", ".join(self.nodes) or "no node"
        return f"<LIN bus {self.name}, {self.bit_rate} bit/s: {nodes}; {self.frames} frames>"

    @property
    def frames(self) -> int:
        """Number of responses transmitted successfully."""
        return self.wire.wire.frames

    def remember(self, limit: int) -> None:
        """Keep the last `limit` frames of the wire for `recent`."""
        tap = RecentLinFrames(whole("limit", limit, 0, MOST_KEPT))
        self._keep_in(tap)
        self.wire.wire.tap = tap

    def _unplug(self, node: LabLinNode) -> None:
        unplug_lin(node.line)

    def _node(
        self,
        name: str,
        settings: LinSettings,
        responses: Responses | None,
        enhanced: bool,
        self_reception: bool,
        receive_queue: int,
    ) -> LabLinNode:
        self._check_new(name)
        with self.time.touch():
            line = ideal_lin_line(f"{self.name}/{name}", self.time.timeline)
            line.controller.name = name
            node = LabLinNode(self.time, self, name, line, settings, enhanced, self_reception, receive_queue)
            for id, data in (responses or {}).items():
                node.respond(id, data)
            plug_lin(line, self.wire)
            line.start()
        self.nodes[name] = node
        return node


def _check_mapping(name: str, mapping: object) -> None:
    instance(name, mapping, Mapping, NoneType)


class RecentLinFrames(Recent[LinFrame], LinTap):
    """The last frames of a LIN bus, with the nodes that answered."""

    def transmitted(self, node: LinNode, response: LinResponse, at_ns: int) -> None:
        self.keep(node.name, bytes(response.record), at_ns)

    def frame(self, data: bytes, at_ns: int) -> LinFrame:
        return lin_frame_of_record(at_ns.to_bytes(TIME_SIZE, "little") + data[TIME_SIZE:])
