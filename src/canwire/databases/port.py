"""A node or a channel that sends and receives messages by name."""

from __future__ import annotations

from collections import Counter
from collections.abc import AsyncIterator, Iterator, Mapping
from typing import Any

from canwire.databases.codec import Codec
from canwire.databases.decoded import DecodedMessage
from canwire.databases.description import Number, Value
from canwire.databases.endpoints import AnyFrame, endpoint_of
from canwire.databases.near import near
from canwire.databases.values_in import fault_of
from canwire.errors import BadSignals, NotReceived
from canwire.values.checks import nanoseconds
from canwire.values.frame import Frame

_NS = 1_000_000_000
_SHOWN = 5  # of what came instead


class MessagePort:
    """Sends and receives messages of one database on `node`, from `Database.on(node)`.

    `fill` is the value of signals that are not given and have no start value in the file; `source` is the address
    from which J1939 messages are sent. `unknown` counts received frames that the file does not know.
    """

    def __init__(
        self, node: Any, database: Codec, *, fill: Number | None = None, source: int | None = None
    ) -> None:
        self.node = node
        self.database = database
        self.unknown = 0
        self._end = endpoint_of(node)
        self._fill = fill
        self._source = source
        self._sent: Counter[str] = Counter()

    def send_message(
        self, name: str, signals: Mapping[str, Value] | None = None, /, **values: Value
    ) -> AnyFrame:
        """Queue a message with these signals, physical values or texts; returns its frame.

        Signals may be given as a mapping, by keyword, or both; others have the file's start values. On LIN the
        message is the response to its header from now on. Counters and checksums of E2E profiles are set. Raises
        BadSignals, BadValue, and what the node's `send` raises.
        """
        given = {**(signals or {}), **values}
        source = self._source if self.database.message(name).j1939 else None
        frame = self.database.encode(name, given, fill=self._fill, source=source)
        if isinstance(frame, Frame):
            frame = self.database.protect(frame, self._sent[name])
        self._end.send(frame)
        self._sent[name] += 1
        return frame

    def receive_message(self, timeout: float = 0.0) -> DecodedMessage | None:
        """The oldest message received, waiting at most `timeout` seconds of the bus's time; None for none.

        Frames that the file does not know are dropped, and counted in `unknown`.
        """
        deadline_ns = self._end.now_ns() + nanoseconds("timeout", timeout) if timeout else 0
        while True:
            frame = self._end.receive(0)
            if frame is None and timeout:
                frame = self._end.receive(max(0, deadline_ns - self._end.now_ns()) / _NS)
            if frame is None:
                return None
            found = self._decoded(frame)
            if found is not None:
                return found

    def decoded(self, timeout: float = 0.0) -> DecodedMessages:
        """`for message in port.decoded()` waits at most `timeout` seconds for each message, and ends without one.

        `async for message in port.decoded()` continues until the node or channel is closed.
        """
        return DecodedMessages(self, timeout)

    async def receive_async(self) -> DecodedMessage | None:
        """The oldest message, waiting for one; None once the node or channel is closed."""
        while (frame := await self._end.receive_async()) is not None:
            found = self._decoded(frame)
            if found is not None:
                return found
        return None

    def expect_message(
        self, name: str, signals: Mapping[str, Value] | None = None, /, *, within: float, **values: Value
    ) -> DecodedMessage:
        """Wait at most `within` seconds of the bus's time for this message with these values.

        Values are compared as texts or as numbers; others may have any value. Earlier messages are dropped. Raises
        NotReceived, which lists the messages received instead, BadSignals for unknown signals and texts.
        """
        wanted = {**(signals or {}), **values}
        self._check_wanted(name, wanted)
        start_ns = self._end.now_ns()
        deadline_ns = start_ns + nanoseconds("within", within)
        seen: Counter[str] = Counter()
        alike: list[DecodedMessage] = []
        unknown = self.unknown
        while (message := self.receive_message(max(0, deadline_ns - self._end.now_ns()) / _NS)) is not None:
            if message.name != name:
                seen[message.name] += 1
            elif message.timestamp_ns <= deadline_ns and message.agrees(wanted):
                return message
            else:
                alike.append(message)
            if message.timestamp_ns > deadline_ns:
                break
        asked = " and ".join(f"{signal}={value}" for signal, value in wanted.items())
        what = f"{name} with {asked}" if wanted else name
        instead = _instead(alike, seen, self.unknown - unknown)
        raise NotReceived(f"{self._end.name}: no {what} within {within:g} s; {instead}")

    def _check_wanted(self, name: str, wanted: Mapping[str, Value]) -> None:
        there = self.database.message(name).signals
        faults = {one: f"no such signal; {near(one, there)}" for one in wanted if one not in there}
        faults |= {
            one: fault
            for one, value in wanted.items()
            if one in there and (fault := fault_of(there[one], value))
        }
        if faults:
            raise BadSignals(name, faults)

    def _decoded(self, frame: AnyFrame) -> DecodedMessage | None:
        found = self.database.decode(frame)
        if found is None:
            self.unknown += 1
        return found

    def __repr__(self) -> str:
        return f"<{self._end.name} by {self.database.path}>"


class DecodedMessages:
    """The messages received at a port, in order."""

    def __init__(self, port: MessagePort, timeout: float) -> None:
        self._port = port
        self._timeout = timeout

    def __iter__(self) -> Iterator[DecodedMessage]:
        while (message := self._port.receive_message(self._timeout)) is not None:
            yield message

    async def __aiter__(self) -> AsyncIterator[DecodedMessage]:
        while (message := await self._port.receive_async()) is not None:
            yield message

    def __repr__(self) -> str:
        return f"<messages of {self._port!r}>"


def _instead(alike: list[DecodedMessage], seen: Counter[str], unknown: int) -> str:
    parts = [str(message) for message in alike[-_SHOWN:]]
    if len(alike) > _SHOWN:
        parts.insert(0, f"{len(alike)} of them, the last:")
    if seen:
        parts.append("others: " + ", ".join(f"{name} x{count}" for name, count in seen.most_common(_SHOWN)))
    if unknown:
        parts.append(f"{unknown} frames that the file does not know")
    return "seen: " + ", ".join(parts) if parts else "nothing came"
