"""Entries for the tests of logs: made by hypothesis, and some of every kind."""

from __future__ import annotations

import shutil
from pathlib import Path

from hypothesis import strategies as st

from canwire import (
    BusEvent,
    ErrorKind,
    ErrorState,
    EventKind,
    Frame,
    LinErrorKind,
    LinEvent,
    LinEventKind,
    LinFrame,
    LogEntry,
    LogMark,
    MarkKind,
)

START_NS = 1_700_000_000_123_000_000
LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    """Any frame there is."""
    extended = draw(st.booleans())
    id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    kind = draw(st.sampled_from(("data", "remote", "fd")))
    if kind == "remote":
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 15)))
    if kind == "fd":
        data = draw(st.sampled_from(LENGTHS).flatmap(lambda size: st.binary(min_size=size, max_size=size)))
        flags = {name: draw(st.booleans()) for name in ("bit_rate_switch", "error_state_indicator")}
        return Frame(id, data, extended=extended, fd=True, **flags)
    data = draw(st.binary(max_size=8))
    dlc = draw(st.none() | st.integers(8, 15)) if len(data) == 8 else None
    return Frame(id, data, extended=extended, dlc=dlc)


events = st.builds(
    BusEvent, st.just(EventKind.STATE), state=st.sampled_from(ErrorState), tec=st.integers(0, 256)
) | st.builds(
    BusEvent,
    st.just(EventKind.ERROR),
    error=st.sampled_from(ErrorKind),
    state=st.sampled_from(ErrorState),
    bit=st.integers(-1, 700),
    transmitting=st.booleans(),
    tec=st.integers(0, 256),
    rec=st.integers(0, 255),
)


@st.composite
def lin_frames(draw: st.DrawFn) -> LinFrame:
    id = draw(st.integers(0, 0x3B))
    if draw(st.booleans()):
        return LinFrame(id, header_only=True, length=draw(st.integers(0, 8)), enhanced=draw(st.booleans()))
    return LinFrame(id, draw(st.binary(min_size=1, max_size=8)), enhanced=draw(st.booleans()))


lin_events = st.builds(
    LinEvent, st.just(LinEventKind.ERROR), error=st.sampled_from(LinErrorKind), id=st.integers(-1, 0x3F)
) | st.builds(LinEvent, st.sampled_from((LinEventKind.SLEEP, LinEventKind.WAKEUP)))
marks = st.builds(
    LogMark,
    st.sampled_from(MarkKind),
    count=st.integers(0, 1 << 63),
    bit_rate=st.integers(0, 1 << 31),
    text=st.text(st.characters(codec="utf-8", exclude_characters="\0"), max_size=10),
)
ANY = frames() | events | lin_frames() | lin_events | marks


@st.composite
def entries(
    draw: st.DrawFn, contents: st.SearchStrategy[object] = ANY, step_ns: int = 1, most: int = 30
) -> list[LogEntry]:
    """A log with times that rise by multiples of `step_ns`."""
    found, time_ns = [], START_NS
    for content in draw(st.lists(contents, min_size=1, max_size=most)):
        time_ns += draw(st.integers(1, 3_000_000_000 // step_ns)) * step_ns
        lin = isinstance(content, LinFrame | LinEvent)
        channel = "lin0" if lin else draw(st.sampled_from(("can0", "can1")))
        directed = isinstance(content, Frame | LinFrame)
        direction = draw(st.sampled_from("RT")) if directed else None
        if isinstance(content, LinFrame) and content.header_only:
            direction = None
        found.append(LogEntry(time_ns, channel, stamped(content, time_ns), direction))
    return found


def stamped(content: object, time_ns: int) -> object:
    """The same content at a time."""
    if isinstance(content, Frame):
        return Frame(
            content.id,
            content.data,
            extended=content.extended,
            remote=content.remote,
            fd=content.fd,
            bit_rate_switch=content.bit_rate_switch,
            error_state_indicator=content.error_state_indicator,
            dlc=content.dlc,
            timestamp_ns=time_ns,
        )
    if isinstance(content, LinFrame):
        return LinFrame(
            content.id,
            content.data,
            enhanced=content.enhanced,
            header_only=content.header_only,
            length=content.length if content.header_only else None,
            timestamp_ns=time_ns,
        )
    from dataclasses import replace

    return replace(content, timestamp_ns=time_ns)  # type: ignore[type-var]


def fresh(path: Path) -> Path:
    """The path, without the folder of a trace that an example before wrote there: a trace overwrites nothing."""
    shutil.rmtree(path, ignore_errors=path.is_file() or not path.exists())
    return path


def same(found: list[LogEntry], wanted: list[LogEntry]) -> bool:
    """Equal, with the times that take no part in a frame's comparison."""
    times = [entry.content.timestamp_ns for entry in found]
    return found == wanted and times == [entry.timestamp_ns for entry in wanted]


def some(count: int = 200, step_ns: int = 1_000_000) -> list[LogEntry]:
    """Frames of every kind, in both directions, on two channels."""
    found = []
    for number in range(count):
        time_ns = START_NS + number * step_ns
        kinds: tuple[dict[str, object], ...] = (
            {"data": bytes((number & 0xFF, 2, 3))},
            {"data": bytes(8), "extended": True},
            {"remote": True, "dlc": 4},
            {"data": bytes(range(12)), "fd": True, "bit_rate_switch": True},
        )
        frame = Frame(0x100 + number % 50, timestamp_ns=time_ns, **kinds[number % 4])  # type: ignore[arg-type]
        found.append(LogEntry(time_ns, f"can{number % 2}", frame, "RT"[number // 3 % 2]))
    return found
