"""Finds the socket that sent a frame that comes back: the channel only reports that the line sent it."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from canwire.socketcan.wire import IDENTITY, REMOTE, SELF_RECEPTION, keep_remote_data, numpy_module

if TYPE_CHECKING:
    import numpy

    Array = numpy.ndarray

NOBODY = -1
_MOST = 8192  # outstanding frames; the transmit queue is shorter


class Echoes:
    """Frames of one channel come back in the order in which they were sent; discarded frames do not come back."""

    def __init__(self) -> None:
        self._sent: deque[tuple[int, Array]] = deque()  # slot, records
        self._count = 0

    @property
    def outstanding(self) -> int:
        return self._count

    def sent(self, slot: int, records: Array, frames: Array | None = None) -> None:
        """`frames` (`sent_dtype`) are the program's bytes, including data in remote frames, which no bus carries."""
        if frames is not None:
            keep_remote_data(records, frames)
        self._sent.append((slot, records))
        self._count += len(records)
        while self._count > _MOST:
            self._count -= len(self._sent.popleft()[1])

    def owners(self, records: Array) -> Array:
        """The slot for each record; NOBODY for frames of other programs and nodes.

        Remote frames get the data that their program wrote, as a kernel loops them back.
        """
        numpy = numpy_module()
        found: Array = numpy.full(len(records), NOBODY, "i4")
        if not self._sent:
            return found
        (local,) = numpy.nonzero(records["info"] & SELF_RECEPTION)
        done = 0
        while done < len(local) and self._sent:
            done += self._match(records, local[done:], found)
        return found

    def _match(self, records: Array, places: Array, found: Array) -> int:
        """Take as many as agree with what was sent next, one at least; how many were looked at."""
        slot, sent = self._sent[0]
        count = min(len(sent), len(places))
        same = _same(sent[:count], records[places[:count]])
        agreeing = count if same.all() else int(same.argmin())
        if agreeing == 0 and not self._skip_to(records[places[0]]):
            return 1
        if agreeing:
            found[places[:agreeing]] = slot
            records["data"][places[:agreeing]] = sent["data"][:agreeing]
            self._drop(agreeing)
        return agreeing

    def _skip_to(self, record: Array) -> bool:
        """Drop the frames sent before this one, which were discarded; False if no socket here sent this one."""
        skipped = 0
        for _, sent in self._sent:
            same = _same(sent, record)
            if same.any():
                self._drop(skipped + int(same.argmax()))
                return True
            skipped += len(sent)
        return False

    def _drop(self, count: int) -> None:
        self._count -= count
        while count:
            slot, sent = self._sent[0]
            if len(sent) > count:
                self._sent[0] = slot, sent[count:]
                return
            count -= len(sent)
            self._sent.popleft()


def _same(sent: Array, echoes: Array) -> Array:
    found: Array = (
        (sent["id"] == echoes["id"])
        & (sent["info"] & IDENTITY == echoes["info"] & IDENTITY)
        & ((sent["data"] == echoes["data"]).all(axis=-1) | (sent["info"] & REMOTE != 0))
    )
    return found
