"""Frames of the chosen messages as samples."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from canwire import EXTENDED, LinFrame

if TYPE_CHECKING:
    from canwire.commands.plot.choosing import Chosen
    from canwire.commands.plot.tracks import Tracks


class Decoding:
    """Puts signals of frames into tracks; times count from `zero_ns`."""

    def __init__(self, chosen: Chosen, tracks: Tracks) -> None:
        self._messages = chosen.messages
        self._database = chosen.database
        self._masks = chosen.database.id_masks(*self._messages)
        self._tracks = tracks

    def add(self, channel: str, records: Any, zero_ns: int) -> None:
        """Records of `record_dtype()`: frames of CAN."""
        import numpy

        ids, extended = records["id"], records["info"] & EXTENDED != 0
        wanted = numpy.zeros(len(records), bool)
        for id, mask, long in self._masks:
            wanted |= ((ids ^ id) & mask == 0) & (extended == long)
        if not wanted.any():
            return
        for name, columns in self._database.decode_arrays(records[wanted]).items():
            times_s = (columns.time_ns.astype("i8") - zero_ns) / 1e9
            for label in self._messages.get(name, ()):
                if label.signal in columns.signals:
                    present = columns.present[label.signal]
                    here = slice(None) if present is None else present
                    self._tracks.add(label, channel, times_s[here], columns.signals[label.signal][here])

    def add_lin(self, channel: str, frame: LinFrame, zero_ns: int) -> None:
        """One frame of LIN."""
        import numpy

        message = self._database.decode(frame)
        if message is None:
            return
        for label in self._messages.get(message.name, ()):
            value = message.numbers.get(label.signal)
            if isinstance(value, int | float):
                time_s = (frame.timestamp_ns - zero_ns) / 1e9
                self._tracks.add(label, channel, numpy.array([time_s]), numpy.array([value]))
