"""One log, read by us and by python-can: identifiers, data, flags, relative times, channels and directions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from canwire import BadLog, Frame, Log, open_log
from tests.others.told import Told

SUFFIXES = {
    *(".asc", ".blf", ".trc", ".mf4", ".log", ".csv", ".db", ".gz", ".zst", ".dump", ".candump", ".can"),
    *(".pcap", ".pcapng", ".txt"),
}
_NEAR_S = 2e-6
Row = tuple[tuple[Any, ...], float, Any, bool | None]
"""Identifier, flags and data; seconds; channel; whether it was received (None: not known)."""


def compare_log(path: Path) -> Told:
    """What we make of it, beside what python-can does."""
    theirs, why = python_can_reading(path)
    try:
        with open_log(path) as log:
            ours, others = our_reading(log)
            faults = [str(fault) for fault in log.faults[:1]] * log.fault_count
            form = log.format
    except BadLog as refusal:
        error = str(refusal).replace(f"{path}: ", "").replace(str(path), path.name)
        told = f"python-can reads {len(theirs)} frames" if theirs else why or "python-can finds no frame"
        return Told("refused", f"{error} | {told}")
    read = f"{form}: {len(ours)} frames, {others} other entries"
    if faults:
        read += f", {len(faults)} faults, the first {faults[0]}"
    if theirs is None:
        return Told("alone", f"{read} | {why}")
    difference = first_difference(ours, theirs)
    if not difference:
        return Told("same", read)
    if reason := explained(form, ours, theirs):
        return Told("explained", f"{reason} | {read}")
    return Told(
        "says so" if faults else "differs", f"{difference} | {read}; python-can: {len(theirs)} frames"
    )


def our_reading(log: Log) -> tuple[list[Row], int]:
    """The frames, and how many entries there were besides."""
    rows: list[Row] = []
    others = 0
    for entry in log:
        if isinstance(entry.content, Frame):
            rows.append(
                (key(entry.content), entry.timestamp_ns / 1e9, entry.channel, _received(entry.direction))
            )
        else:
            others += 1
    return rows, others


def _received(direction: str | None) -> bool | None:
    return None if direction is None else direction == "R"


def key(frame: Frame) -> tuple[Any, ...]:
    data = frame.dlc if frame.remote else frame.data
    return (frame.id, frame.extended, frame.remote, frame.fd, data)


def python_can_reading(path: Path) -> tuple[list[Row] | None, str]:
    """Its frames, None with the reason where it reads none of that file."""
    import can

    try:
        with can.LogReader(path) as reader:
            return [_row(one) for one in reader if not one.is_error_frame], ""
    except Exception as error:  # of many kinds
        return None, f"python-can: {type(error).__name__}: {error}"[:120]


def _row(one: Any) -> Row:
    data = one.dlc if one.is_remote_frame else bytes(one.data)
    what = (one.arbitration_id, one.is_extended_id, one.is_remote_frame, one.is_fd, data)
    return what, one.timestamp, one.channel, one.is_rx


def explained(form: str, ours: list[Row], theirs: list[Row]) -> str:
    """Why python-can's reading is another one, where that is known; "" where it is not."""
    if form == "asc" and not first_difference(ours[1:], theirs):
        return "python-can takes the first event for the head's last line, and drops it"
    if form == "asc" and not first_difference([_without_fd_remote(row) for row in theirs], ours):
        return "python-can makes remote frames of CAN FD, which has none"
    if form == "blf" and not theirs:
        return "python-can finds no objects outside of containers"
    return ""


def _without_fd_remote(row: Row) -> Row:
    id, extended, remote, fd, data = row[0]
    return ((id, extended, remote, fd and not remote, data), *row[1:])


def first_difference(ours: list[Row], theirs: list[Row]) -> str:
    """The first place where they differ, "" for none; each aspect in its turn."""
    channels: dict[Any, Any] = {}
    for number, (one, other) in enumerate(zip(ours, theirs, strict=False)):
        if one[0] != other[0]:
            return f"frame {number}: {one[0]}, not {other[0]}"
    if len(ours) != len(theirs):
        return f"{len(ours)} frames, not {len(theirs)}"
    for number, (one, other) in enumerate(zip(ours, theirs, strict=True)):
        passed, their = one[1] - ours[0][1], other[1] - theirs[0][1]
        if abs(passed - their) > _NEAR_S:
            return f"time of frame {number}: {passed:.6f}, not {their:.6f}"
        if channels.setdefault(other[2], one[2]) != one[2]:
            return f"channel of frame {number}: {one[2]}, not {channels[other[2]]}"
        if one[3] is not None and one[3] != other[3]:
            return f"direction of frame {number}"
    if len(set(channels.values())) != len(channels):
        return f"channels {channels}"
    return ""
