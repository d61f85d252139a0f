"""Several lines as one source for one log, in order of time stamps."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Protocol

from canwire.errors import BadValue
from canwire.hub.handles.event import Event
from canwire.logs.batch import in_time, log_dtype
from canwire.logs.entry import LogEntry
from canwire.logs.recording.recorder import RecordingSource
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

    from canwire.hub.handles.ends import RingEnd


class QueuedSource(RecordingSource, Protocol):
    """A source on a shared line."""

    @property
    def reading(self) -> RingEnd:
        """The queue to wait for."""


class SeveralSources:
    """Sources of a lab, which are complete up to the present time at any moment."""

    def __init__(self, sources: Sequence[RecordingSource]) -> None:
        self._sources = list(sources)
        self.channels = _distinct(sources)
        self.address = ", ".join(source.address for source in sources)

    def take(self, timeout_s: float) -> numpy.ndarray:
        """The entries of all sources by time stamp; never waits."""
        del timeout_s
        return self._taken()

    def lost(self) -> list[int]:
        return [lost for source in self._sources for lost in source.lost()]

    def marks(self) -> list[LogEntry]:
        found = [
            mark._replace(channel=channel)
            for source, channel in zip(self._sources, self.channels, strict=True)
            for mark in source.marks()
        ]
        return sorted(found, key=lambda mark: mark.timestamp_ns)

    def start(self, drain: Callable[[], None]) -> bool:
        return all(source.start(drain) for source in self._sources)

    def close(self) -> None:
        for source in self._sources:
            source.close()

    def _taken(self) -> numpy.ndarray:
        pieces = [load_numpy().zeros(0, log_dtype())]
        for number, source in enumerate(self._sources):
            piece = source.take(0.0)
            piece["channel"] = number
            pieces.append(piece)
        return in_time(load_numpy().concatenate(pieces))


class SeveralShared(SeveralSources):
    """Lines of a hub, whose queues are read one after the other.

    An entry that comes after its queue was read may be older than entries of the next queue: those wait for the next
    round. The hub fills queues in order of time, so a round that begins after a stamp was seen finds all older ones.
    Entries of one instant are in the order of the lines, whichever was seen first.
    """

    def __init__(self, sources: Sequence[QueuedSource]) -> None:
        super().__init__(sources)
        self._held = load_numpy().zeros(0, log_dtype())
        self._event = Event()
        self._ends = [source.reading for source in sources]
        for end in self._ends:
            end.assign(self._event)

    def take(self, timeout_s: float) -> numpy.ndarray:
        """Return the entries that no older entry can follow, waiting for the first; without a timeout, return all
        entries."""
        seen_ns = int(self._held["time_ns"].max(initial=0))
        found = self._taken()
        if not len(found) and not len(self._held):
            for end in self._ends:
                end.lease.check()
            if timeout_s and self._event.wait(timeout_s):
                found = self._taken()
        found = load_numpy().concatenate([self._held, found])
        found = found[load_numpy().lexsort((found["channel"], found["time_ns"]))]
        ready = found["time_ns"] <= seen_ns if timeout_s else found["time_ns"] >= 0
        self._held = found[~ready]
        return found[ready]

    def close(self) -> None:
        for end in self._ends:
            end.assign(None)
        super().close()
        self._event.close()


def _distinct(sources: Sequence[RecordingSource]) -> list[str]:
    """Return the sources' names; lines with the same name, because they are on one bus, get their addresses instead."""
    counts = Counter(source.channels[0] for source in sources)
    found = [one.channels[0] if counts[one.channels[0]] == 1 else one.address for one in sources]
    if len(set(found)) < len(found):
        raise BadValue(f"{', '.join(found)}: the same line twice; each once")
    return found
