"""`canwire convert`: a log in another format, and what that cannot hold.

canwire convert drive.log drive.blf                    the suffixes tell the formats
canwire convert drive.log day/                         a trace: a folder of Parquet files, for `canwire query`
canwire convert drive.blf - --to candump               onto standard output
canwire convert drive.log part.csv --filter 21A:7FF    these frames only
canwire convert drive.log two.asc --map vcan0=can1     a channel gets another name

The format of what is read is told by its first bytes. What cannot be read is left out and said, with its place; then
the exit status is 1. What the new format cannot hold is named, as in `trc: 3 LIN frames left out`; with --strict
that is status 1 as well.

Formats: {formats}.
"""

from __future__ import annotations

import argparse
import json

from canwire import convert_log, log_formats, open_log
from canwire.commands.console import complain
from canwire.commands.logs.choosing import add_filter_argument, add_map_argument, chosen_by, parsed_map
from canwire.commands.logs.faults import tell_faults

__doc__ = (__doc__ or "").format(
    formats=", ".join(row.name + ("" if row.writes else " (read only)") for row in log_formats())
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument("log", metavar="IN", help="a log of any format; - is standard input")
    parser.add_argument("out", metavar="OUT", help="the new file; - is standard output")
    parser.add_argument(
        "--from", dest="form", metavar="FORMAT", help="what IN is, if its first bytes do not tell"
    )
    parser.add_argument("--to", metavar="FORMAT", help="what OUT becomes, if its suffix does not tell")
    add_filter_argument(parser)
    add_map_argument(parser, "what a channel is called in OUT; again, or with commas: several")
    parser.add_argument("--strict", action="store_true", help="exit status 1 if anything was left out")
    parser.add_argument(
        "--json", action="store_true", help="print what was done as JSON, on stderr where OUT is -"
    )


def run(arguments: argparse.Namespace) -> int:
    """Convert; 1 for faults in the log. BadLog for a file that is none, BadValue, OSError."""
    only, names = chosen_by(arguments.filter), parsed_map(arguments.map)
    with open_log(arguments.log, format=arguments.form) as log:
        try:
            out = convert_log(log, arguments.out, format=arguments.to, channels=names, only=only)
        finally:
            tell_faults(log)
        facts = {"from": log.format, "to": out.format, "entries": out.count, "faults": log.fault_count}
        if arguments.json:
            text = json.dumps({**facts, "left_out": out.left_out})
            print(text) if arguments.out != "-" else complain(text)
        else:
            for what, count in out.left_out.items():
                complain(f"{out.format}: {count} {what} left out")
            if arguments.out != "-":
                print(f"{out.count} entries from {log.format} to {out.format}")
    return 1 if log.fault_count or (arguments.strict and out.left_out) else 0
