"""`canwire query`: SQL over a trace, a folder of Parquet files that may be bigger than memory, or over any other log.

canwire query trace/                                                   its tables and their columns
canwire query trace/ "select id, count(*) from frames group by id"
canwire query drive.blf "select * from errors order by time_ns" --csv
canwire query trace/ "select avg(value) from signals where signal = 'EngineSpeed'" --db engine.dbc
canwire query trace/ "select time, EngineSpeed from EngineData" --db engine.dbc -o speed.parquet

`canwire record can0 trace/` and `canwire convert drive.log trace/` make traces. The SQL is DuckDB's. Tables: frames,
errors, events, lin, marks (lost counts, gaps, bit rates, clock), entries for everything; with --db signals, messages,
and one for each message by its name. Signals are decoded while the query runs, and only those it asks for. Rows come by
identifier: `order by time_ns, row` is the order in which they were recorded. `time` is UTC, or seconds from the log's
zero where it has no date. An identifier in hex is a text: where id = '0x1A0'.

What cannot be read is left out and said, with its place; then the exit status is 1.
"""

from __future__ import annotations

import argparse
import os
import re

from canwire import BadValue, Trace, open_trace
from canwire.commands.databases.chosen import add_database_argument, databases_of
from canwire.commands.logs.faults import tell_faults
from canwire.commands.query.output import write_rows
from canwire.commands.shell.progress import Progress, watched

_UNITS = {"M": 20, "G": 30}
_TABLES = """select table_name as "table", string_agg(column_name, ', ' order by column_index) as columns
from duckdb_columns() where table_name <> 'database_signals' and not internal and schema_name = 'main'
group by table_name order by table_name"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument("trace", metavar="TRACE", help="a trace's folder, a Parquet file, or any other log")
    parser.add_argument("sql", metavar="SQL", nargs="?", help="a query; without one: tables and columns")
    add_database_argument(parser, "signals by name", several=True)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--csv", action="store_true", help="lines of comma-separated values")
    form.add_argument("--json", action="store_true", help="a JSON object for each row")
    form.add_argument("-o", dest="out", metavar="FILE", help="into FILE.csv, FILE.json or FILE.parquet")
    parser.add_argument("--quiet", action="store_true", help="show nothing of how far it is")
    parser.add_argument(
        "--memory", metavar="SIZE", default="512M", help="what DuckDB may take: 512M (default), 2G"
    )


def run(arguments: argparse.Namespace) -> int:
    """Ask; 1 for faults in the trace. BadLog for what is none, BadValue for SQL that means nothing, ExtraMissing."""
    memory_bytes = _size(arguments.memory)
    _refuse_itself(arguments.trace, arguments.out)
    databases = databases_of(arguments)
    pairs = None if databases is None else databases.pairs
    with open_trace(arguments.trace, database=pairs, memory_bytes=memory_bytes) as trace:
        import duckdb

        tell_faults(trace)
        query = _TABLES if arguments.sql is None else arguments.sql
        try:
            _answer(trace, query, arguments)
        except duckdb.Error as error:
            raise trace.mistake(error, query) from None
        return 1 if trace.fault_count else 0


def _answer(trace: Trace, query: str, arguments: argparse.Namespace) -> None:
    rows = trace.sql(query)
    if rows is None:
        return
    form = "csv" if arguments.csv else "json" if arguments.json else "table"
    quiet = arguments.quiet or form == "json"
    progress = Progress(100, "query", unit=" percent", lines=True, quiet=quiet)
    with watched(progress, lambda: max(0, round(trace.connection.query_progress()))):
        write_rows(rows, form, arguments.out)


def _refuse_itself(trace: str, out: str | None) -> None:
    """What is written must not be what is read, nor become a part of it."""
    if out is None or not os.path.exists(trace):
        return
    for place in (out, os.path.dirname(os.path.abspath(out))):
        if os.path.exists(place) and os.path.samefile(place, trace):
            raise BadValue(f"-o {out}: it is what is asked; give the answer a place of its own")


def _size(text: str) -> int:
    found = re.fullmatch(r"(\d+)([MG])", text)
    if found is None:
        raise BadValue(f"--memory {text}: a number and M or G: 512M, 2G")
    return int(found[1]) << _UNITS[found[2]]
