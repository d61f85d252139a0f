"""Base class of sources on shared lines: the recorder's thread empties them, `closing` holds their resources."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire.logs.entry import LogEntry, LogMark

if TYPE_CHECKING:
    from canwire.hub.handles.channel import HubChannel
    from canwire.hub.handles.ends import RingEnd
    from canwire.hub.handles.lin import Monitor


class HubSource:
    """`channels` contains the line's name in the log; `address` identifies it among the lines of its bus.

    `epoch_ns` converts times to the wall clock.
    """

    def __init__(self, listener: HubChannel | Monitor, name: str, epoch_ns: int, closing: ExitStack) -> None:
        self.channels = [name]
        self.address = name
        self.epoch_ns = epoch_ns
        self._listener = listener
        self._closing = closing

    @property
    def reading(self) -> RingEnd:
        """The queue that the recorder's thread empties."""
        return self._listener.reading

    def lost(self) -> list[int]:
        return [self._listener.status().lost]

    def start(self, drain: Callable[[], None]) -> bool:
        del drain
        return False

    def close(self) -> None:
        self._closing.close()

    def _entries(self, marks: list[LogMark]) -> list[LogEntry]:
        return [LogEntry(mark.timestamp_ns, self.channels[0], mark) for mark in marks]
