"""`canwire convert`: write a log in another format, and report what that format cannot hold.

canwire convert drive.log drive.blf                    the suffix of a file is its format
canwire convert drive.log day/                         a trace: a folder of Parquet files, for `canwire query`
canwire convert drive.blf - --to candump               to standard output
canwire convert drive.log part.csv --filter 21A:7FF    these frames only
canwire convert drive.log two.asc --map vcan0=can1     rename a channel
canwire convert drive.log drive.blf both.mf4 --merge   merge logs, in order of time
canwire convert drive.log drive.blf two.mf4 --merge --map 2:can0=can2    rename a channel of the second log only

The format of IN is detected from its first bytes. Faults in IN are left out and reported with their places; the exit
status is then 1. Entries that the new format cannot hold are reported, as in `trc: 3 LIN frames left out`; with
--strict the exit status is then 1, too.

With --merge, channels with the same name in several logs become one channel; --map keeps them apart. The dates of the
logs put them on one clock; if no log has a date, all begin at 0.

Formats: {formats}.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BadValue, convert_log, log_formats, merge_logs, open_log
from canwire.commands.console import complain
from canwire.commands.logs.choosing import add_filter_argument, add_map_argument, chosen_by, parsed_maps
from canwire.commands.logs.faults import tell_faults
from canwire.commands.shell.progress import Progress

if TYPE_CHECKING:
    from canwire import Log, LogBatch, LogWriter

__doc__ = (__doc__ or "").format(
    formats=", ".join(row.name + ("" if row.writes else " (read only)") for row in log_formats())
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "logs", nargs="+", metavar="IN", help="a log of any format; - is standard input; with --merge several"
    )
    parser.add_argument("out", metavar="OUT", help="the new file; - is standard output")
    parser.add_argument(
        "--from", dest="form", metavar="FORMAT", help="format of IN (default: by its first bytes)"
    )
    parser.add_argument("--to", metavar="FORMAT", help="format of OUT (default: by its suffix)")
    add_filter_argument(parser)
    add_map_argument(parser, "rename a channel in OUT; may be given several times, or with commas")
    parser.add_argument("--merge", action="store_true", help="write several logs into one")
    parser.add_argument("--quiet", action="store_true", help="do not show the progress")
    parser.add_argument("--strict", action="store_true", help="exit status 1 if anything was left out")
    parser.add_argument("--json", action="store_true", help="print the result as JSON, on stderr if OUT is -")


def run(arguments: argparse.Namespace) -> int:
    """Convert; 1 if the log has faults. Raises BadLog for a file that is no log, BadValue, OSError."""
    if len(arguments.logs) > 1 and not arguments.merge:
        raise BadValue(f"{len(arguments.logs)} logs into {arguments.out}: --merge writes them into one")
    chosen, names = chosen_by(arguments.filter), parsed_maps(arguments.map, len(arguments.logs))
    with ExitStack() as closing:
        quiet = arguments.quiet or arguments.json
        only = _counted(
            chosen,
            closing.enter_context(Progress(None, "convert", unit=" entries read", lines=True, quiet=quiet)),
        )
        logs = [closing.enter_context(open_log(path, format=arguments.form)) for path in arguments.logs]
        try:
            if arguments.merge:
                out = merge_logs(logs, arguments.out, format=arguments.to, channels=names, only=only)
            else:
                out = convert_log(logs[0], arguments.out, format=arguments.to, channels=names[0], only=only)
        finally:
            for log in logs:
                tell_faults(log)
        _tell(arguments, logs, out)
    faults = sum(log.fault_count for log in logs)
    return 1 if faults or (arguments.strict and out.left_out) else 0


def _counted(
    chosen: Callable[[LogBatch], LogBatch] | None, progress: Progress
) -> Callable[[LogBatch], LogBatch]:
    """What is chosen of each batch, showing how many entries were read."""
    count = 0

    def only(batch: LogBatch) -> LogBatch:
        nonlocal count
        count += len(batch.records)
        progress.show(count)
        return batch if chosen is None else chosen(batch)

    return only


def _tell(arguments: argparse.Namespace, logs: Sequence[Log], out: LogWriter) -> None:
    """What was done, in words or as JSON."""
    formats = ", ".join(dict.fromkeys(log.format for log in logs))
    if arguments.json:
        faults = sum(log.fault_count for log in logs)
        facts = {"from": formats, "to": out.format, "entries": out.count, "faults": faults}
        text = json.dumps({**facts, "left_out": out.left_out})
        print(text) if arguments.out != "-" else complain(text)
        return
    for what, count in out.left_out.items():
        complain(f"{out.format}: {count} {what} left out")
    if arguments.out != "-":
        print(f"{out.count} entries from {formats} to {out.format}")
