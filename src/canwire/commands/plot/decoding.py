"""Decodes frames of the chosen messages to samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire import EXTENDED, LinFrame

if TYPE_CHECKING:
    from canwire.commands.plot.choosing import Chosen
    from canwire.commands.plot.tracks import Tracks


class Decoding:
    """Puts signals of frames into tracks; times count from `zero_ns`.

    A frame is decoded by the first of its channel's databases that knows it.
    """

    def __init__(self, chosen: Chosen, tracks: Tracks) -> None:
        self._messages = chosen.messages
        self._databases = chosen.databases
        self._tracks = tracks

    def add(self, channel: str, records: Any, zero_ns: int) -> None:
        """Add CAN frames: records of `record_dtype()`."""
        databases = self._databases.of(channel)
        for database in databases[:-1]:
            known, records = _split(records, database.id_masks(*database.messages))
            self._add_known(database, channel, known, zero_ns)
        for database in databases[-1:]:
            self._add_known(database, channel, records, zero_ns)

    def _add_known(self, database: Any, channel: str, records: Any, zero_ns: int) -> None:
        there = [name for name in self._messages if name in database.messages]
        wanted, _ = _split(records, database.id_masks(*there))
        if not len(wanted):
            return
        for name, columns in database.decode_arrays(wanted).items():
            times_s = (columns.time_ns.astype("i8") - zero_ns) / 1e9
            for label in self._messages.get(name, ()):
                if label.signal in columns.signals:
                    present = columns.present[label.signal]
                    here = slice(None) if present is None else present
                    self._tracks.add(label, channel, times_s[here], columns.signals[label.signal][here])

    def add_lin(self, channel: str, frame: LinFrame, zero_ns: int) -> None:
        """Add one LIN frame."""
        import numpy

        message = self._databases.decode(frame, channel)
        if message is None:
            return
        for label in self._messages.get(message.name, ()):
            value = message.numbers.get(label.signal)
            if isinstance(value, int | float):
                time_s = (frame.timestamp_ns - zero_ns) / 1e9
                self._tracks.add(label, channel, numpy.array([time_s]), numpy.array([value]))


def _split(records: Any, masks: list[tuple[int, int, bool]]) -> tuple[Any, Any]:
    """Return the records whose identifiers match one of the masks, and the other records."""
    import numpy

    ids, extended = records["id"], records["info"] & EXTENDED != 0
    known = numpy.zeros(len(records), bool)
    for id, mask, long in masks:
        known |= ((ids ^ id) & mask == 0) & (extended == long)
    return records[known], records[~known]
