"""The tables of a query, based on the columns of logs/tables/columns.py.

Rows have the order of the files, by identifier: `order by time_ns, row` is the order in which they were recorded.
"""

from __future__ import annotations

from canwire.logs.queries.sources import QuerySource

_FLAGS = "extended, remote, fd, brs, esi"
_NUMBER = "coalesce(cast(detail->>'{name}' as {kind}), {usual}) as {name}"
_EVENTS = ", ".join(
    [
        "detail->>'kind' as kind",
        "coalesce(detail->>'error', 'NONE') as error",
        "detail->>'state' as state",
        _NUMBER.format(name="bit", kind="integer", usual=-1),
        _NUMBER.format(name="transmitting", kind="boolean", usual="false"),
        _NUMBER.format(name="tec", kind="integer", usual=0),
        _NUMBER.format(name="rec", kind="integer", usual=0),
    ]
)
_MARKS = ", ".join(
    [
        "detail->>'kind' as kind",
        *(
            _NUMBER.format(name=name, kind="bigint", usual=0)
            for name in ("count", "bit_rate", "data_bit_rate")
        ),
        "coalesce(detail->>'text', '') as text",
    ]
)
_LIN = "direction, id, dlc as length, data, " + _NUMBER.format(
    name="header_only", kind="boolean", usual="false"
)
_HEAD = "select time_ns, time, channel, "
VIEWS = {
    "frames": f"{_HEAD} direction, id, {_FLAGS}, dlc, data, row from entries where type = 'CAN_FRAME'",
    "events": f"{_HEAD} type[:3] as bus, {_EVENTS}, row from entries where type in ('CAN_EVENT', 'LIN_EVENT')",
    "errors": "select * exclude (kind) from events where kind = 'ERROR'",
    "lin": f"{_HEAD} {_LIN}, row from entries where type = 'LIN_FRAME'",
    "marks": f"{_HEAD} {_MARKS}, row from entries where type = 'MARK'",
}
"""By name, beside `entries`, which has everything."""


def entries(source: QuerySource) -> str:
    """Return the query for all rows, with `time`: a TIMESTAMP_NS (UTC) for a dated log, else seconds from its zero."""
    time = "make_timestamp_ns(time_ns)" if source.dated else "time_ns / 1e9"
    row = "row" if source.sorted_ else "0::uinteger as row"
    files = ", ".join(quoted(file) for file in source.files)
    return (
        f"select time_ns, {time} as time, channel, direction, type, id, {_FLAGS}, dlc, data, "
        f"nullif(detail, '') as detail, {row} "
        f"from read_parquet([{files}])"
    )


def quoted(text: str) -> str:
    """Quote a text for SQL."""
    return "'" + text.replace("'", "''") + "'"


def named(name: str) -> str:
    """Quote a name for SQL."""
    return '"' + name.replace('"', '""') + '"'
