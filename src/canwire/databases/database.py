"""A network description: messages by name and by frame."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from canwire.databases.can_file import CanFile, Decoded, frame_of
from canwire.databases.decoded import DecodedMessage
from canwire.databases.description import MessageDescription, Number, Value
from canwire.databases.identifiers import addressed
from canwire.databases.lin_file import LinFile
from canwire.databases.matching import Matching, key_of, match_mask
from canwire.databases.near import near
from canwire.databases.values_in import chosen_signals, complete
from canwire.errors import BadValue
from canwire.values.acceptance import Acceptance, id_pair
from canwire.values.checks import instance, shown, whole
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame
from canwire.values.mistakes.names import answers_wrong_names

if TYPE_CHECKING:
    import numpy

    from canwire.databases.checking import MessageCheck
    from canwire.databases.columns import SignalColumns
    from canwire.databases.port import MessagePort
    from canwire.databases.simulation import OutgoingMessage, Simulation


@answers_wrong_names
class Database:
    """A network description, from `load_database`.

    `messages` are all messages by name, in the file's order; `nodes` are the names of their senders and receivers.
    """

    def __init__(self, path: str, file: CanFile | LinFile) -> None:
        self.path = path
        self.nodes = file.nodes
        self.messages: dict[str, MessageDescription] = {message.name: message for message in file.messages}
        self._file = file
        self._listed = file.messages
        self._matching = Matching([] if isinstance(file, LinFile) else file.messages)

    def message(self, name: str) -> MessageDescription:
        """The message of that name; raises BadValue with similar names."""
        if not isinstance(name, str):
            raise TypeError(
                f"message {shown(name)}: must be its name, not {type(name).__name__}{self._name_of(name)}"
            )
        if name not in self.messages:
            raise BadValue(f"{self.path}: no message {name!r}; {near(name, self.messages)}")
        return self.messages[name]

    def _name_of(self, id: object) -> str:
        """Return the end of an error message that gives the message name for this identifier; "" if none has it."""
        found = next((name for name, message in self.messages.items() if message.id == id), "")
        return f"; {id:#x} is {found!r}" if found else ""

    def sent_by(self, node: str) -> list[MessageDescription]:
        """The messages that this node sends; raises BadValue with similar names."""
        if node not in self.nodes:
            raise BadValue(f"{self.path}: no node {node!r}; {near(node, self.nodes)}")
        return [message for message in self.messages.values() if node in message.senders]

    def message_of(self, frame: Frame | LinFrame) -> MessageDescription | None:
        """Find the message of a frame: J1939 messages by their PGN, others by identifier and format."""
        if isinstance(frame, LinFrame):
            name = self._file.name_of(frame) if isinstance(self._file, LinFile) else None
            return None if name is None else self.messages[name]
        number = self._matching.find(key_of(frame.id, frame.extended))
        return None if number < 0 else self._listed[number]

    def encode(
        self,
        name: str,
        signals: Mapping[str, Value],
        *,
        fill: Number | None = None,
        source: int | None = None,
        destination: int | None = None,
        priority: int | None = None,
    ) -> Frame | LinFrame:
        """The message's frame with these signals, as physical values or texts.

        Signals that are left out get the file's start value, or `fill` if it gives none. `source` (0 to 255),
        `destination` and `priority` (0 to 7) go into J1939 identifiers. Raises BadSignals, which names every wrong
        signal with its range, and BadValue.
        """
        message = self.message(name)
        instance("signals", signals, Mapping)
        if not message.decodable:
            raise BadValue(f"{name}: it holds other messages; `encode_container` takes those")
        values = complete(message, signals, fill)
        id = addressed(message, source, destination, priority)
        if isinstance(self._file, LinFile):
            return self._file.pack(name, values)
        if message.length > (64 if message.fd else 8):
            raise BadValue(
                f"{name}: {message.length} bytes need several frames; send `pack(...)` by a transport protocol"
            )
        return frame_of(message, id, self._file.pack(name, values))

    def encode_container(
        self, name: str, messages: Mapping[str, Mapping[str, Value]], *, fill: Number | None = None
    ) -> Frame:
        """The frame of a container with these messages, by name, in this order; raises like `encode`."""
        container = self.message(name)
        held = {one.name: one for one in container.contained}
        if not held:
            raise BadValue(f"{name}: no container of other messages; `encode` takes its signals")
        for part in messages:
            if part not in held:
                raise BadValue(f"{name}: it holds no message {part!r}; {near(part, held)}")
        assert isinstance(self._file, CanFile)
        parts = [(part, complete(held[part], values, fill)) for part, values in messages.items()]
        return frame_of(container, container.id, self._file.pack_container(name, parts))

    def protect(self, frame: Frame, count: int) -> Frame:
        """The frame with the counter and the checksum that the file defines (E2E profiles 2 and 5) for its message, or
        for the messages in a container.

        `count` is the number of such messages sent before. Frames of other messages are returned unchanged. Raises
        BadDescription if the data have no room.
        """
        instance("frame", frame, Frame)
        number = whole("count", count, 0, 1 << 62)
        message = None if frame.remote else self.message_of(frame)
        guarded = message is not None and any(one.protection for one in (message, *message.contained))
        if message is None or not guarded or not isinstance(self._file, CanFile):
            return frame
        return Frame(
            frame.id,
            self._file.protect(message.name, frame.data, number),
            extended=frame.extended,
            fd=frame.fd,
            bit_rate_switch=frame.bit_rate_switch,
            error_state_indicator=frame.error_state_indicator,
            timestamp_ns=frame.timestamp_ns,
        )

    def protections_of(self, frame: Frame) -> list[tuple[str, str, tuple[int, int] | None]]:
        """Check the protected messages in a frame, of which a container can have several.

        Returns for each one its name, the fault of its checksum ("" for none), its counter (None if it is cut off), and
        the number of counter values. Messages without protection are left out."""
        instance("frame", frame, Frame)
        message = None if frame.remote else self.message_of(frame)
        if message is None or not isinstance(self._file, CanFile):
            return []
        return list(self._file.guards_in(message.name, frame.data))

    def protection_of(self, frame: Frame) -> tuple[str, tuple[int, int] | None]:
        """The fault of the frame's checksum ("" if it is right or missing), its counter, and the number of counter
        values (None without a counter). For a container: the faults of all messages in it."""
        guards = self.protections_of(frame)
        if len(guards) == 1 and self.message_of(frame) is self.messages.get(guards[0][0]):
            return guards[0][1:]
        return ", ".join(f"{name}: {fault}" for name, fault, _ in guards if fault), None

    def signals_in(self, name: str, signals: Mapping[str, Value]) -> list[str]:
        """The names of the signals that are in the message's frame with these multiplexer values. Raises BadValue."""
        return chosen_signals(self.message(name), signals)

    def complete(
        self, name: str, signals: Mapping[str, Value], *, fill: Number | None = None
    ) -> dict[str, Value]:
        """These values and, for all other signals in the frame, start values or `fill`. Raises like `encode`."""
        return complete(self.message(name), signals, fill)

    def pack(self, name: str, signals: Mapping[str, Value], *, fill: Number | None = None) -> bytes:
        """Only the data of the message, which may be longer than a frame. Raises like `encode`."""
        packed = self._file.pack(name, complete(self.message(name), signals, fill))
        return packed.data if isinstance(packed, LinFrame) else packed

    def decode(self, frame: Frame | LinFrame) -> DecodedMessage | None:
        """The decoded frame; None for a frame that the file does not know, and for a remote frame."""
        instance("frame", frame, Frame, LinFrame)
        message = self.message_of(frame)
        if message is None:
            return None
        found: tuple[Decoded, str]
        if isinstance(frame, LinFrame):
            assert isinstance(self._file, LinFile)
            found = self._file.unpack(frame)
        elif frame.remote:
            return None
        else:
            assert isinstance(self._file, CanFile)
            if not message.decodable:
                return self._container(message, frame, *self._file.unpack_container(message.name, frame.data))
            found = self._file.unpack(message.name, frame.data)
        return _decoded(message, frame, *found)

    def decode_arrays(self, records: numpy.ndarray) -> dict[str, SignalColumns]:
        """Decode many frames, records of `record_dtype()`: columns of signals by message name.

        Frames that the file does not know, remote frames and events are left out. Needs canwire[arrays].
        """
        from canwire.databases.columns import decode_columns

        listed = [] if isinstance(self._file, LinFile) else self._listed
        return decode_columns(records, listed, self._matching)

    def on(self, node: Any, *, fill: Number | None = None, source: int | None = None) -> MessagePort:
        """A port on this node of the lab (CAN or LIN) or channel on a shared line: sends and receives messages by name.

        `fill` is the value of signals that are not given and have no start value, `source` the address from which
        J1939 messages are sent. Raises TypeError for anything else.

        >>> db = load_database("examples/engine.dbc")
        >>> with Lab() as lab:
        ...     bus = lab.can_bus("can0", bit_rate=500_000)
        ...     engine, tester = db.on(bus.node("engine")), db.on(bus.node("tester"))
        ...     frame = engine.send_message("EngineData", EngineSpeed=1500)
        ...     print(tester.expect_message("EngineData", EngineSpeed=1500, within=0.5))
        EngineData(EngineSpeed: 1500 rpm, Temperature: 20 degC, Ready: no, Alive: 0, Check: 0)
        """
        from canwire.databases.port import MessagePort

        return MessagePort(node, self, fill=fill, source=source)

    def simulated(
        self,
        node: str,
        *,
        signals: Mapping[str, Value] | None = None,
        plugins: Iterable[Callable[[OutgoingMessage], None]] = (),
        fill: Number = 0,
    ) -> Simulation:
        """A node's messages at their cycle times, a Simulation: `bus.node("engine", db.simulated("Engine"))`.

        Raises BadValue for an unknown node or one without cyclic messages, BadSignals for values out of range.
        """
        from canwire.databases.simulation import Simulation

        return Simulation(self, node, signals=signals, plugins=plugins, fill=fill)

    def check(self, plugins: Iterable[Callable[[OutgoingMessage], None]] = ()) -> MessageCheck:
        """Check counters and checksums of messages, by the file's E2E profiles and plug-ins: a MessageCheck."""
        from canwire.databases.checking import MessageCheck

        return MessageCheck(self, plugins)

    def id_masks(self, *names: str) -> list[tuple[int, int, bool]]:
        """Return (identifier, mask, extended) for each of these messages, as for filters: a mask bit of 1 must match.

        The masks of J1939 messages ignore priority and source. Raises BadValue."""
        wanted = [self.message(name) for name in names]
        return [
            (message.id, match_mask(message) & (0x1FFF_FFFF if message.extended else 0x7FF), message.extended)
            for message in wanted
        ]

    def acceptance(self, *names: str) -> Acceptance:
        """A filter that lets these messages through, for `LabBus.node(filters=...)`. Raises BadValue."""
        return Acceptance(
            tuple(id_pair(id & mask, mask, extended=extended) for id, mask, extended in self.id_masks(*names))
        )

    def _container(
        self,
        message: MessageDescription,
        frame: Frame,
        parts: list[tuple[MessageDescription, Decoded, str]],
        problem: str,
    ) -> DecodedMessage:
        held = tuple(_decoded(one, frame, told, why) for one, told, why in parts)
        return DecodedMessage(message, {}, {}, frame, problem, held)

    def __repr__(self) -> str:
        return f"<database {self.path}: {len(self.messages)} messages, {len(self.nodes)} nodes>"


def _decoded(
    message: MessageDescription, frame: Frame | LinFrame, told: Decoded, problem: str
) -> DecodedMessage:
    numbers = {name: number for name, (number, _) in told.items()}
    signals = {name: text or number for name, (number, text) in told.items()}
    return DecodedMessage(message, signals, numbers, frame, problem)
