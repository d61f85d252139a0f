"""`canwire stats`: what is in a log: identifiers with their periods, errors, losses, load over time.

canwire stats drive.log                            of any format; several logs: one after the other
canwire stats drive.log --bit-rate 500000          with the load, where the log has no bit rates itself
canwire stats drive.log --bit-rate can0=500000     of this channel only; again, or with commas: several
canwire stats drive.log --db car.dbc               with names, and periods beside the database's cycle times
canwire stats drive.log --db can0=car.dbc --db can1=car.dbc    a database for each channel
canwire stats day-0001.log day-0002.log --together    the files of a rotated recording as one log
canwire stats drive.log --json                     an object, for programs

Periods are in milliseconds: mean, shortest, longest, and jitter, which is their standard deviation. A gap is a period
of more than three times the usual one (the median of an identifier's first 32). Load counts every bit of a frame, its
stuff bits and the three behind it included; error frames are not in it. What cannot be read is left out and said, with
its place; then the exit status is 1.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BadValue, Log, log_statistics, open_log
from canwire.commands.databases.chosen import Databases, add_database_argument, databases_of
from canwire.commands.logs.faults import tell_faults

if TYPE_CHECKING:
    from canwire import LogStatistics
    from canwire.commands.stats.expected import Expected


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument("logs", nargs="+", metavar="LOG", help="a log of any format; - is standard input")
    for name, what in (
        ("bit-rate", "of the buses, where a log does not tell"),
        ("data-bit-rate", "likewise, behind the bit-rate switch"),
    ):
        parser.add_argument(f"--{name}", action="append", default=[], metavar="[CHANNEL=]BIT/S", help=what)
    add_database_argument(parser, "names and cycle times", several=True)
    parser.add_argument("--together", action="store_true", help="all logs are one that goes on")
    parser.add_argument(
        "--from", dest="form", metavar="FORMAT", help="what LOG is, if its first bytes do not tell"
    )
    parser.add_argument("--json", action="store_true", help="print JSON, an object for each log")


def run(arguments: argparse.Namespace) -> int:
    """Print numbers; 1 for faults in a log. BadLog for a file that is none, BadValue, BadDescription, OSError."""
    rates = [_rates(name, getattr(arguments, name)) for name in ("bit_rate", "data_bit_rate")]
    expected = _expected(databases_of(arguments))
    faults = 0
    for names in [arguments.logs] if arguments.together else [[name] for name in arguments.logs]:
        with ExitStack() as closing:
            logs = [closing.enter_context(open_log(name, format=arguments.form)) for name in names]
            try:
                found = log_statistics(*logs, bit_rate=rates[0], data_bit_rate=rates[1])
            finally:
                for log in logs:
                    tell_faults(log)
            _show(arguments, logs, found, expected)
            faults += sum(log.fault_count for log in logs)
    return 1 if faults else 0


def _show(
    arguments: argparse.Namespace, logs: Sequence[Log], found: LogStatistics, expected: Expected | None
) -> None:
    if arguments.json:
        from canwire.commands.stats.facts import facts_of

        print(json.dumps(facts_of(logs, found, expected)), flush=True)
    else:
        from canwire.commands.stats.report import report

        for line in report(logs, found, expected):
            print(line)


def _expected(databases: Databases | None) -> Expected | None:
    if databases is None:
        return None
    from canwire.commands.stats.expected import Expected

    return Expected(databases)


def _rates(name: str, texts: Sequence[str]) -> dict[str, int]:
    """By channel, "" for all; raises BadValue."""
    found: dict[str, int] = {}
    for part in _parts(texts):
        channel, equals, number = part.rpartition("=")
        if not number.isdecimal() or not int(number) or bool(equals) != bool(channel):
            raise BadValue(f"--{name.replace('_', '-')} {part}: bits a second, 500000 or can0=500000")
        found[channel] = int(number)
    return found


def _parts(texts: Sequence[str]) -> Iterator[str]:
    for text in texts:
        yield from text.split(",")
