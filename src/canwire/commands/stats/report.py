"""The text output of `canwire stats`: head of the log, channels, a row for each identifier, load over time."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire import ChannelStatistics, IdentifierStatistics, Log, LogStatistics
    from canwire.commands.stats.expected import Expected

_ROWS = 20  # of a load over time
_BAR = 40  # columns for 100 %
_NAMED = 10  # messages that are missing
_HEADS = ("channel", "id", "count", "period", "least", "most", "jitter", "gaps", "dlc", "dir")
_RIGHT = {2, 3, 4, 5, 6, 7, 10, 11}  # columns of numbers


def report(logs: Sequence[Log], found: LogStatistics, expected: Expected | None) -> Iterator[str]:
    """Yields the lines of the report."""
    yield _head(logs, found)
    for channel in found.channels:
        yield f"{channel.name}: {_channel(channel)}"
    if found.identifiers:
        yield ""
        yield from _table([_row(one, expected) for one in found.identifiers], expected is not None)
    if found.unlisted:
        yield f"{found.unlisted} frames of further identifiers, or on no channel"
    if expected is not None and (missing := expected.missing(found.identifiers)):
        named = ", ".join(f"{one.name} ({_ms(one.cycle_s)} ms)" for one in missing[:_NAMED])
        more = f" and {len(missing) - _NAMED} more" if len(missing) > _NAMED else ""
        yield f"not in the log: {named}{more}"
    for channel in found.channels:
        if channel.loads:
            yield ""
            yield from _loads(channel)


def _head(logs: Sequence[Log], found: LogStatistics) -> str:
    paths = logs[0].path if len(logs) == 1 else f"{len(logs)} logs, {logs[0].path} to {logs[-1].path}"
    told = [f"{paths}: {logs[0].format}", f"{found.entries} entries", f"{found.span_s:.3f} s"]
    if found.dated:
        told.append(f"from {_date(found.first_ns)}")
    if found.clock:
        told.append(f"time of the {found.clock}")
    return ", ".join(told)


def _date(time_ns: int) -> str:
    try:
        return f"{datetime.fromtimestamp(time_ns // 1000 / 1e6, UTC):%Y-%m-%d %H:%M:%S.%f} UTC"
    except (OverflowError, ValueError, OSError):  # a damaged stamp
        return f"{time_ns} ns"


def _channel(one: ChannelStatistics) -> str:
    frames = one.frames + one.lin_frames
    told = [f"{frames} frames" if not one.lin_frames else f"{frames} frames, {one.lin_frames} of LIN"]
    told += [
        f"{count} {what}"
        for what, count in (("received", one.received), ("transmitted", one.transmitted), ("remote", one.remote),
                            ("FD", one.fd))
        if count
    ]  # fmt: skip
    errors = sum(one.errors.values())
    told.append(f"{errors} errors" + (f" ({_kinds(one)})" if errors else ""))
    told += [f"{count} {kind.lower().replace('_', ' ')} events" for kind, count in one.events.items()]
    told.append(f"{one.lost} lost")
    if one.overruns:
        told.append(f"{one.overruns} overruns")
    if one.gap_ns:
        told.append(f"nothing recorded for {one.gap_ns / 1e9:.3f} s")
    told.append(_rates(one))
    return ", ".join(told)


def _kinds(one: ChannelStatistics) -> str:
    kinds = ", ".join(f"{count} {kind.lower().replace('_', ' ')}" for kind, count in one.errors.items())
    return kinds + (f"; {one.errors_sending} while sending" if one.errors_sending else "")


def _rates(one: ChannelStatistics) -> str:
    if not one.bit_rate:
        return "load unknown: --bit-rate"
    rates = f"{one.bit_rate} bit/s" + (f", {one.data_bit_rate} after BRS" if one.data_bit_rate else "")
    if one.load is None:
        return f"load unknown: --data-bit-rate, or --bit-rate from the beginning ({rates})"
    return f"load {one.load:.1f} %, peak {one.peak or 0:.1f} % ({rates})"


def _row(one: IdentifierStatistics, expected: Expected | None) -> tuple[str, ...]:
    id = f"{one.id:08X}" if one.extended else f"{one.id:02X} LIN" if one.lin else f"{one.id:03X}"
    directions = "".join(letter for letter, count in (("R", one.received), ("T", one.transmitted)) if count)
    row = (
        one.channel,
        id,
        str(one.count),
        *map(_ms, (one.mean_s, one.least_s, one.most_s, one.jitter_s)),
        str(one.gaps),
        ",".join(map(str, one.dlcs)) + (" FD" if one.fd else "") + (" remote" if one.remote else ""),
        directions or "-",
    )
    if expected is None:
        return row
    message, deviation = expected.message(one), expected.deviation(one)
    return (
        *row,
        _ms(message.cycle_s) if message and message.cycle_s else "-",
        f"{deviation:+.1f} %" if deviation is not None else "-",
        message.name if message else "-",
    )


def _table(rows: Sequence[tuple[str, ...]], named: bool) -> Iterator[str]:
    heads = _HEADS + (("cycle", "off by", "message") if named else ())
    widths = [max(map(len, column)) for column in zip(heads, *rows, strict=True)]
    for row in (heads, *rows):
        cells = [
            cell.rjust(width) if at in _RIGHT else cell.ljust(width)
            for at, (cell, width) in enumerate(zip(row, widths, strict=True))
        ]
        yield "  ".join(cells).rstrip()


def _loads(one: ChannelStatistics) -> Iterator[str]:
    """Yield the lines of a channel's load; steps are merged so that the rows are few."""
    together = -(-len(one.loads) // _ROWS)
    yield f"load of {one.name}, in steps of {together * one.load_step_s:g} s"
    for at in range(0, len(one.loads), together):
        part = one.loads[at : at + together]
        load = sum(part) / len(part)
        bar = "#" * min(_BAR, round(load * _BAR / 100))
        yield f"{at * one.load_step_s:10.1f} s  {load:5.1f} %  {bar}".rstrip()


def _ms(seconds: float | None) -> str:
    return "-" if seconds is None else f"{seconds * 1000:.3f}"
