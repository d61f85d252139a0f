"""LIN description files (LDF): frames, signals and schedules of a network, for labs and for monitors.

    network = canwire.ldf.load("door.ldf")
    bus = lab.lin_bus("lin0", bit_rate=network.bit_rate)
    master = bus.master(network.master, schedule=network.schedules, **network.master_options())
    slave = bus.slave("window", **network.slave_options("window"))
    network.decode(master.expect(0x11, within=0.1))     # {"WindowPosition": 50.0, ...}

Needs canwire[lin] (ldfparser, which only this folder uses). A description that cannot be parsed raises
BadDescription.

Source: LIN 2.2A 9 (configuration language); ldfparser 0.26.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from canwire.errors import BadDescription, BadFrame, BadValue
from canwire.ldf.attributes import attributes_of
from canwire.ldf.configuration import command
from canwire.ldf.parsing import parse_ldf
from canwire.ldf.signals import LinSignal as LinSignal
from canwire.ldf.signals import Value as Value
from canwire.ldf.signals import shown, signal_of
from canwire.values.lin.configuration import LinNodeAttributes
from canwire.values.lin.frame import LinFrame, protected_id
from canwire.values.lin.schedule import LinSchedule, LinSlot

_NS = 1_000_000_000


@dataclass(frozen=True, slots=True)
class FrameDescription:
    """An unconditional frame: identifier, number of data bytes, publisher, checksum model and signals."""

    name: str
    id: int
    length: int
    publisher: str
    enhanced: bool
    signals: tuple[str, ...]


def load(path: str | Path, *, encoding: str = "utf-8") -> LinDescription:
    """The network that this file describes; raises BadDescription with the name of the file, ExtraMissing."""
    parse = parse_ldf()
    try:
        parsed = parse(str(path), encoding=encoding, pad_with_zero=False)
        return LinDescription(parsed, str(path))
    except OSError as error:
        raise BadDescription(f"{path}: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise BadDescription(f"{path}: byte {error.start} is no {encoding}; give its encoding") from None
    except Exception as error:  # somebody else's parser: anything may come
        raise BadDescription(f"{path}: {_first_line(error)}") from error


class LinDescription:
    """One network. Names are those of the file; `master` and `slaves` are names of nodes.

    `frames` are the unconditional frames by name, `schedules` the usable tables by name, in the order of the file.
    `unusable` maps the other tables to the reasons why they cannot be run.
    """

    def __init__(self, parsed: Any, path: str) -> None:
        self._parsed = parsed
        self.path = path
        self.protocol = str(parsed.get_protocol_version())
        self.bit_rate = round(parsed.get_baudrate())
        self.master: str = parsed.get_master().name
        self.slaves = tuple(slave.name for slave in parsed.get_slaves())
        self.frames = {frame.name: self._describe(frame) for frame in parsed.get_unconditional_frames()}
        self._by_id = {frame.id: frame for frame in self.frames.values()}
        self._events = {
            event.frame_id: tuple(member.frame_id for member in event.frames)
            for event in parsed.get_event_triggered_frames()
        }
        self.schedules: dict[str, LinSchedule] = {}
        self.unusable: dict[str, str] = {}
        for table in parsed.get_schedule_tables():
            try:
                self.schedules[table.name] = LinSchedule(table.name, tuple(map(self._slot, table.schedule)))
            except BadDescription as error:
                self.unusable[table.name] = str(error)

    def name_of(self, id: int) -> str | None:
        """The name of the unconditional or event-triggered frame with this identifier."""
        if id in self._by_id:
            return self._by_id[id].name
        events = {event.frame_id: event.name for event in self._parsed.get_event_triggered_frames()}
        return events.get(id)

    # for nodes of the bench

    def responses(self, node: str) -> dict[int, LinFrame]:
        """The frames that this node publishes, by identifier, with initial signal values. Raises BadValue."""
        self._check_node(node)
        mine = [frame for frame in self.frames.values() if frame.publisher == node]
        return {frame.id: self.encode(frame.name, {}) for frame in mine}

    def lengths(self, node: str) -> dict[int, int]:
        """The lengths of the frames with signals that this node subscribes to, by identifier. Raises BadValue."""
        self._check_node(node)
        wanted = {signal.name for signal in self._node(node).subscribes_to}
        return {frame.id: frame.length for frame in self.frames.values() if wanted & {*frame.signals}}

    def events(self, node: str) -> dict[int, int]:
        """The frames of this node by their event-triggered identifiers. Raises BadValue."""
        self._check_node(node)
        return {
            event: member
            for event, members in self._events.items()
            for member in members
            if self._by_id[member].publisher == node
        }

    def response_error(self, node: str) -> tuple[int, int] | None:
        """(identifier, bit) of this slave's response-error signal, if it has one. Raises BadValue."""
        self._check_node(node)
        signal = getattr(self._node(node), "response_error", None)
        for frame in self._parsed.get_unconditional_frames():
            for offset, carried in frame.signal_map:
                if carried is signal and self._by_id[frame.frame_id].publisher == node:
                    return frame.frame_id, offset
        return None

    def checksums(self, node: str) -> dict[int, bool]:
        """The checksum models (True: enhanced) of the frames that this node subscribes to, by identifier.

        Includes event-triggered frames. Raises BadValue.
        """
        heard = {id: self._by_id[id].enhanced for id in self.lengths(node)}
        events = {
            event: self._by_id[members[0]].enhanced
            for event, members in self._events.items()
            if any(member in heard for member in members)
        }
        return heard | events

    def attributes(self, node: str) -> LinNodeAttributes | None:
        """The attributes of this slave for node configuration; None in LIN 1.3, which has none. Raises BadValue.

        The slave begins with its initial NAD, as after power-up.
        """
        self._check_node(node)
        return None if node == self.master else attributes_of(self._node(node))

    def slave_options(self, node: str) -> dict[str, Any]:
        """The arguments of `LabLinBus.slave` for this node. Raises BadValue."""
        return {
            "responses": self.responses(node),
            "subscribes": self.lengths(node),
            "events": self.events(node),
            "response_error": self.response_error(node),
            "checksums": self.checksums(node),
            "attributes": self.attributes(node),
        }

    def master_options(self) -> dict[str, Any]:
        """The arguments of `LabLinBus.master` for the master."""
        return {"responses": self.responses(self.master), "checksums": self.checksums(self.master)}

    # signals

    def encode(self, frame: str, values: Mapping[str, Value]) -> LinFrame:
        """The frame with these signals, the others at their initial values.

        A value is physical, the text of a logical value, or the raw number if the file gives no encoding.
        Raises BadValue with the frame or signal that does not fit.
        """
        if frame not in self.frames:
            raise BadValue(f"{self.path}: no frame {frame!r}; there are {', '.join(self.frames)}")
        told = self.frames[frame]
        unknown = [name for name in values if name not in told.signals]
        if unknown:
            raise BadValue(f"{frame} has no signal {unknown[0]!r}; it has {', '.join(told.signals)}")
        try:
            data = bytes(self._parsed.get_unconditional_frame(frame).encode(dict(values)))
        except Exception as error:  # somebody else's code: anything may come
            raise BadValue(f"{frame}: {dict(values)}: {_first_line(error)}") from None
        if any(told.id in members for members in self._events.values()):
            data = bytes([protected_id(told.id)]) + data[1:]
        return LinFrame(told.id, data, enhanced=told.enhanced)

    def decode(self, frame: LinFrame) -> dict[str, Value]:
        """The signals of a received frame; the first byte of an event-triggered frame identifies the answering frame.

        Values are physical, the text of a logical value, or the raw number if the file gives no encoding that
        fits. Raises BadFrame for a frame that the file does not define, or of another length.
        """
        raw = self.decode_raw(frame)
        described = self._parsed.get_unconditional_frame(self.described(frame).name)
        return {signal.name: shown(signal, raw[signal.name]) for _, signal in described.signal_map}

    def decode_raw(self, frame: LinFrame) -> dict[str, Any]:
        """The signals of a received frame as raw numbers (lists of bytes for arrays). Raises BadFrame."""
        told = self.described(frame)
        if len(frame.data) != told.length:
            raise BadFrame(f"{told.name}: {told.length} bytes, not {len(frame.data)}")
        raw: dict[str, Any] = self._parsed.get_unconditional_frame(told.name).decode_raw(
            bytearray(frame.data)
        )
        return raw

    def described(self, frame: LinFrame) -> FrameDescription:
        """The description of a received frame: its first byte selects it if the frame is event-triggered. Raises
        BadFrame.
        """
        id = frame.id
        if id in self._events and frame.data:
            id = frame.data[0] & 0x3F
        told = self._by_id.get(id)
        if told is None:
            raise BadFrame(f"{self.path}: no frame with identifier {id:#04x}")
        return told

    def signals_of(self, frame: str) -> list[LinSignal]:
        """The signals of an unconditional frame, in its order."""
        described = self._parsed.get_unconditional_frame(frame)
        return [signal_of(signal, offset) for offset, signal in described.signal_map]

    # inside

    def _describe(self, frame: Any) -> FrameDescription:
        publisher = frame.publisher
        protocol = getattr(publisher, "lin_protocol", None) or self.protocol
        signals = tuple(signal.name for _, signal in frame.signal_map)
        enhanced = not str(protocol).startswith("1.")
        return FrameDescription(frame.name, frame.frame_id, frame.length, publisher.name, enhanced, signals)

    def _check_node(self, name: str) -> None:
        if name != self.master and name not in self.slaves:
            there = ", ".join((self.master, *self.slaves))
            raise BadValue(f"{self.path}: no node {name!r}; there are {there}")

    def _node(self, name: str) -> Any:
        return self._parsed.get_master() if name == self.master else self._parsed.get_slave(name)

    def _slot(self, entry: Any) -> LinSlot:
        """Convert a schedule's entry to a slot; ldfparser has a class for each kind, and the delay in seconds."""
        delay_ns = round(entry.delay * _NS)
        kind = type(entry).__name__
        if kind == "MasterRequestEntry":
            return LinSlot.request(delay_ns=delay_ns)
        if kind == "SlaveResponseEntry":
            return LinSlot.response(delay_ns=delay_ns)
        if kind != "LinFrameEntry":
            return LinSlot.request(command(kind, entry), delay_ns=delay_ns)
        return self._frame_slot(entry.frame, delay_ns)

    def _frame_slot(self, frame: Any, delay_ns: int) -> LinSlot:
        if not hasattr(frame, "frame_id"):
            return LinSlot.sporadic([member.frame_id for member in frame.frames], delay_ns=delay_ns)
        members = self._events.get(frame.frame_id)
        if members is None:
            return LinSlot.frame(frame.frame_id, delay_ns=delay_ns, length=frame.length)
        length = self._by_id[members[0]].length
        table = frame.collision_resolving_schedule_table
        resolving = [
            LinSlot.frame(each.frame.frame_id, delay_ns=round(each.delay * _NS), length=length)
            for each in (table.schedule if table is not None else ())
            if getattr(getattr(each, "frame", None), "frame_id", None) in members
        ]
        return LinSlot.event(frame.frame_id, members, delay_ns=delay_ns, length=length, resolving=resolving)


def _first_line(error: Exception) -> str:
    text = str(error).strip().splitlines()
    return text[0] if text else type(error).__name__
