"""`canwire query`: run SQL on a trace (a folder of Parquet files, which may be larger than memory) or on any other log.

canwire query trace/                                                   list its tables and columns
canwire query trace/ "select id, count(*) from frames group by id"
canwire query drive.blf "select * from errors order by time_ns" --csv
canwire query trace/ "select avg(value) from signals where signal = 'EngineSpeed'" --db engine.dbc
canwire query trace/ "select time, EngineSpeed from EngineData" --db engine.dbc -o speed.parquet

`canwire record can0 trace/` and `canwire convert drive.log trace/` make traces. The SQL dialect is DuckDB's. Tables:
frames, errors, events, lin, marks (lost counts, gaps, bit rates, clock), and entries, which contains all of them; with
--db also signals, messages, and a table for each message, with its name. Only the signals in a query are decoded, while
it runs. Rows are ordered by identifier: use `order by time_ns, row` for the recorded order. `time` is UTC, or
seconds from the start of a log without a date. Write an identifier in hex as a text: where id = '0x1A0'.

Faults in the trace are left out and reported with their places; the exit status is then 1.
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
    """Add the verb's arguments."""
    parser.add_argument("trace", metavar="TRACE", help="a trace's folder, a Parquet file, or any other log")
    parser.add_argument(
        "sql", metavar="SQL", nargs="?", help="a query; without it, tables and columns are listed"
    )
    add_database_argument(parser, "the names of signals", several=True)
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--csv", action="store_true", help="print comma-separated values")
    form.add_argument("--json", action="store_true", help="print a JSON object for each row")
    form.add_argument("-o", dest="out", metavar="FILE", help="write FILE.csv, FILE.json or FILE.parquet")
    parser.add_argument("--quiet", action="store_true", help="do not show the progress")
    parser.add_argument(
        "--memory", metavar="SIZE", default="512M", help="memory limit of DuckDB: 512M (default), 2G"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the query; 1 if the trace has faults. Raises BadLog for no log, BadValue for invalid SQL, ExtraMissing."""
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
    """Raise BadValue if the output is the trace that is read, or would become a part of it."""
    if out is None or not os.path.exists(trace):
        return
    for place in (out, os.path.dirname(os.path.abspath(out))):
        if os.path.exists(place) and os.path.samefile(place, trace):
            raise BadValue(f"-o {out}: it is what is read; write the result elsewhere")


def _size(text: str) -> int:
    found = re.fullmatch(r"(\d+)([MG])", text)
    if found is None:
        raise BadValue(f"--memory {text}: a number and M or G: 512M, 2G")
    return int(found[1]) << _UNITS[found[2]]
