"""Samples of signals by time, in limited memory: too many samples are reduced to their extremes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from canwire.commands.plot.choosing import Label

MOST = 1 << 18
_THINNED = 8  # samples of which two are kept


class Track(NamedTuple):
    """A signal on a channel: times in seconds, values."""

    label: Label
    name: str
    times_s: Any
    values: Any


class Tracks:
    """The samples of these signals. `samples` counts the finite ones, `no_numbers` the others (infinite or NaN)."""

    def __init__(self, labels: Sequence[Label]) -> None:
        self.samples = 0
        self.no_numbers = 0
        self._labels = labels
        self._parts: dict[tuple[str, Label], list[tuple[Any, Any]]] = {}

    def add(self, label: Label, channel: str, times_s: Any, values: Any) -> None:
        """Add samples in the order of the log, as numpy arrays."""
        import numpy

        values = values.astype(numpy.float64)
        numbers = numpy.isfinite(values)
        if not numbers.all():
            self.no_numbers += int((~numbers).sum())
            times_s, values = times_s[numbers], values[numbers]
        if not len(values):
            return
        self.samples += len(values)
        parts = self._parts.setdefault((channel, label), [])
        parts.append((times_s, values))
        if sum(len(part) for part, _ in parts) > MOST:
            parts[:] = [extremes(*joined(parts), _THINNED)]

    @property
    def empty(self) -> list[Label]:
        """Signals without a sample."""
        met = {label for _, label in self._parts}
        return [label for label in self._labels if label not in met]

    @property
    def filled(self) -> list[Track]:
        """Tracks with samples, by signal, then by channel; names contain the channel if several have samples."""
        several = len({channel for channel, _ in self._parts}) > 1
        return [
            Track(label, f"{channel} {label}" if several else str(label), *joined(parts))
            for wanted in self._labels
            for (channel, label), parts in self._parts.items()
            if label == wanted
        ]

    def panels(self, most: int) -> list[list[Track]]:
        """Tracks by unit; each with value texts alone. A track has at most about twice `most` samples."""
        found: dict[object, list[Track]] = {}
        for track in self.filled:
            together = max(1, len(track.values) // most)
            thinned = (
                extremes(track.times_s, track.values, 2 * together)
                if together > 1
                else (track.times_s, track.values)
            )
            key = track.label if track.label.choices else track.label.unit
            found.setdefault(key, []).append(Track(track.label, track.name, *thinned))
        return list(found.values())


def joined(parts: Sequence[tuple[Any, Any]]) -> tuple[Any, Any]:
    """Return all times in one array and all values in another."""
    import numpy

    return numpy.concatenate([times for times, _ in parts]), numpy.concatenate([some for _, some in parts])


def extremes(times: Any, values: Any, together: int) -> tuple[Any, Any]:
    """Return the smallest and the largest of every `together` samples, in order of time, and the last sample."""
    import numpy

    whole = len(values) // together * together
    groups = values[:whole].reshape(-1, together)
    begins = numpy.arange(len(groups)) * together
    places = numpy.concatenate([begins + groups.argmin(1), begins + groups.argmax(1)])
    places = numpy.unique(numpy.concatenate([places, numpy.arange(whole, len(values)), [len(values) - 1]]))
    return times[places], values[places]
