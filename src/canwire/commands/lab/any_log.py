"""A log of any format, read twice as a candump log is: once to learn what it asks of a bus, once to play it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from canwire import BadLog, BadValue, Frame, open_log
from canwire.commands.lab.candump_log import CandumpLog, Complaints, Survey

_CENTURY_NS = 100 * 365 * 86_400 * 1_000_000_000  # well inside the timeline's 63 bits
_TEXT = ("candump",)


class AnyLog:
    """A log that `open_log` reads; the numbers are those of its entries. A context manager."""

    def __init__(self, path: str, wanted: Callable[[Frame], bool] | None = None) -> None:
        self._log = open_log(path)
        self._wanted = wanted

    def survey(self, complaints: Complaints) -> Survey:
        """Read all of it and show its faults. Raises BadLog for no log at all, BadValue for stamps centuries apart."""
        found = Survey()
        latest_ns = 0
        for number, entry in enumerate(self._log, 1):
            found.lines = number
            latest_ns = max(latest_ns, entry.timestamp_ns)
            frame = entry.frame
            if frame is None:
                found.error_frames += 1
            elif self._wanted is None or self._wanted(frame):
                found.note(number, frame, entry.channel)
        found.broken_lines = self._log.fault_count
        for fault in self._log.faults:
            complaints.add_at(fault.where, fault.what)
        complaints.show(found)
        if latest_ns - found.first_ns > _CENTURY_NS:
            raise BadValue(f"{self._log.path}: time stamps more than a century apart")
        return found

    def frames(self) -> Iterator[tuple[int, Frame, str]]:
        """Number, frame and channel, from the beginning."""
        for number, entry in enumerate(self._log, 1):
            frame = entry.frame
            if frame is not None and (self._wanted is None or self._wanted(frame)):
                yield number, frame, entry.channel

    def __enter__(self) -> AnyLog:
        return self

    def __exit__(self, *_: object) -> None:
        self._log.close()


def log_to_play(path: str, wanted: Callable[[Frame], bool] | None = None) -> CandumpLog | AnyLog:
    """The log at this path. Standard input and unknown formats are read as candump logs; faults are reported."""
    if path != "-":
        try:
            with open_log(path) as log:
                if log.format not in _TEXT:
                    return AnyLog(path, wanted)
        except BadLog:
            pass  # candump's reader names the line that is wrong
    return CandumpLog(path, wanted)
