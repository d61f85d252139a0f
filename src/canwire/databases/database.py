"""A network's description: messages by name and by frame."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from canwire.databases.can_file import CanFile, Decoded, frame_of
from canwire.databases.decoded import DecodedMessage
from canwire.databases.description import MessageDescription, Number, Value
from canwire.databases.identifiers import addressed
from canwire.databases.lin_file import LinFile
from canwire.databases.matching import Matching, key_of, match_mask
from canwire.databases.near import near
from canwire.databases.values_in import complete
from canwire.errors import BadValue
from canwire.values.acceptance import Acceptance, id_pair
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame

if TYPE_CHECKING:
    import numpy

    from canwire.databases.columns import SignalColumns


class Database:
    """What `load_database` gives.

    `messages` are all messages by name, in the file's order; `nodes` the names of those who send and receive them.
    """

    def __init__(self, path: str, file: CanFile | LinFile) -> None:
        self.path = path
        self.nodes = file.nodes
        self.messages: dict[str, MessageDescription] = {message.name: message for message in file.messages}
        self._file = file
        self._listed = file.messages
        self._matching = Matching([] if isinstance(file, LinFile) else file.messages)

    def message(self, name: str) -> MessageDescription:
        """The message of that name; raises BadValue with names that are near."""
        if name not in self.messages:
            raise BadValue(f"{self.path}: no message {name!r}; {near(name, self.messages)}")
        return self.messages[name]

    def sent_by(self, node: str) -> list[MessageDescription]:
        """The messages that this node sends; raises BadValue with names that are near."""
        if node not in self.nodes:
            raise BadValue(f"{self.path}: no node {node!r}; {near(node, self.nodes)}")
        return [message for message in self.messages.values() if node in message.senders]

    def message_of(self, frame: Frame | LinFrame) -> MessageDescription | None:
        """Which message a frame is: J1939 messages by their PGN, others by identifier and format."""
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

        Signals that are left out have the file's start value, or `fill` where it gives none. `source` (0 to 255),
        `destination` and `priority` (0 to 7) go into J1939 identifiers. Raises BadSignals, which names every signal at
        fault with its range, and BadValue.
        """
        message = self.message(name)
        if not message.decodable:
            raise BadValue(f"{name}: it holds other messages; those cannot be encoded here")
        values = complete(message, signals, fill)
        if isinstance(self._file, LinFile):
            return self._file.pack(name, values)
        id = addressed(message, source, destination, priority)
        if message.length > (64 if message.fd else 8):
            raise BadValue(
                f"{name}: {message.length} bytes need several frames; send `pack(...)` by a transport protocol"
            )
        return frame_of(message, id, self._file.pack(name, values))

    def pack(self, name: str, signals: Mapping[str, Value], *, fill: Number | None = None) -> bytes:
        """The message's data alone, which may be longer than a frame's. Raises like `encode`."""
        packed = self._file.pack(name, complete(self.message(name), signals, fill))
        return packed.data if isinstance(packed, LinFrame) else packed

    def decode(self, frame: Frame | LinFrame) -> DecodedMessage | None:
        """The frame by name; None for a frame that the file does not know, and for a remote frame."""
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
            found = self._file.unpack(message.name, frame.data)
        told, problem = found
        numbers = {name: number for name, (number, _) in told.items()}
        return DecodedMessage(
            message, {name: text or number for name, (number, text) in told.items()}, numbers, frame, problem
        )

    def decode_arrays(self, records: numpy.ndarray) -> dict[str, SignalColumns]:
        """Many frames at once, records of `record_dtype()`: columns of signals by the message's name.

        Frames that the file does not know, remote frames and events are left out. Needs canwire[arrays].
        """
        from canwire.databases.columns import decode_columns

        listed = [] if isinstance(self._file, LinFile) else self._listed
        return decode_columns(records, listed, self._matching)

    def id_masks(self, *names: str) -> list[tuple[int, int, bool]]:
        """(identifier, mask, extended) for each of these messages, as filters have it: a mask bit of 1 must match.

        J1939 messages leave priority and source open. Raises BadValue.
        """
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

    def __repr__(self) -> str:
        return f"<database {self.path}: {len(self.messages)} messages, {len(self.nodes)} nodes>"
