"""Checks the counters and checksums of received messages, by the file and by plug-ins.

A plug-in finishes messages before they are sent. The same plug-in checks a received message: finished with the next
count, the message must give the received frame.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from canwire.databases.codec import Codec
from canwire.databases.decoded import DecodedMessage
from canwire.databases.simulation import OutgoingMessage
from canwire.errors import BadSignals, BadValue
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame

_COUNTS = 256  # no counter that a plug-in makes has more values

Plugin = Callable[[OutgoingMessage], None]


class MessageCheck:
    """Checks received messages, one stream of each message. `faults` counts the wrong ones.

    `plugins` are those with which the sender finishes its messages; the file's E2E profiles need none.
    """

    def __init__(self, codec: Codec, plugins: Iterable[Plugin] = ()) -> None:
        self.faults = 0
        self._codec = codec
        self._plugins = tuple(plugins)
        self._profiles: dict[str, int] = {}
        self._counts: dict[str, int] = {}

    def fault_of(self, frame: Frame | LinFrame) -> str:
        """Why this frame is wrong, "" if it is right; frames that the file does not know count as right."""
        found = self._codec.decode(frame) if isinstance(frame, Frame) else None
        if found is None or not isinstance(frame, Frame) or (found.problem and not found.contained):
            return ""
        why = self._by_profile(found, frame) or self._by_plugins(found, frame)
        self.faults += bool(why)
        return why

    def __repr__(self) -> str:
        return f"<check of {self._codec.path}: {self.faults} faults>"

    def _by_profile(self, message: DecodedMessage, frame: Frame) -> str:
        faults = []
        for name, fault, told in self._codec.protections_of(frame):
            inside = name != message.name
            if why := fault or self._by_counter(f"{message.name}/{name}" if inside else name, told):
                faults.append(f"{name}: {why}" if inside else why)
        return ", ".join(faults)

    def _by_counter(self, stream: str, told: tuple[int, int] | None) -> str:
        if told is None:
            return ""
        counter, values = told
        before = self._profiles.get(stream)
        self._profiles[stream] = counter
        if before is None or counter == (before + 1) % values:
            return ""
        return _jumped(counter, (before + 1) % values, before)

    def _by_plugins(self, message: DecodedMessage, frame: Frame) -> str:
        before = self._counts.get(message.name)
        first = 0 if before is None else before + 1
        for count in range(first, first + _COUNTS):
            try:
                made, changes = self._finished(message, count)
            except (BadSignals, BadValue):
                return ""  # values that nobody could send again: a range is not the plug-in's affair
            if not changes:
                return ""
            if made == frame.data:
                self._counts[message.name] = count
                if before is None or count == first:
                    return ""
                return _jumped(count % _COUNTS, first % _COUNTS, before % _COUNTS)
        return "wrong checksum"

    def _finished(self, message: DecodedMessage, count: int) -> tuple[bytes, bool]:
        """Return the data as the plug-ins would finish them, and whether any plug-in changes this message."""
        outgoing = OutgoingMessage(self._codec, message.name, count, dict(message.signals), 0)
        seen = _Watched(outgoing.signals)
        outgoing.signals = seen
        for plugin in self._plugins:
            plugin(outgoing)
        return outgoing.encoded(), seen.changed


class _Watched(dict):  # type: ignore[type-arg]
    """A mapping of signals that records whether a plug-in has set one."""

    changed = False

    def __setitem__(self, name: str, value: object) -> None:
        self.changed = True
        super().__setitem__(name, value)


def _jumped(counter: int, wanted: int, before: int) -> str:
    if counter == before:
        return f"counter {counter} again"
    return f"counter {counter}, not {wanted}"
