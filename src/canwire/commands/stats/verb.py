"""`canwire stats`: show statistics of a log: identifiers with their periods, errors, losses, load over time.

canwire stats drive.log                            a log of any format; several logs: one after the other
canwire stats drive.log --bit-rate 500000          with the load, if the log contains no bit rates
canwire stats drive.log --bit-rate can0=500000     of this channel only; may be given several times
canwire stats drive.log --db car.dbc               with names, and the cycle times of the database
canwire stats drive.log --db can0=car.dbc --db can1=car.dbc    a database for each channel
canwire stats day-0001.log day-0002.log --together    the files of a rotated recording as one log
canwire stats drive.log --json                     a JSON object, for programs

Periods are in milliseconds: mean, shortest, longest, and jitter (the standard deviation). A gap is a period longer than
three times the typical one (the median of the first 32 periods of an identifier). The load counts all bits of a frame,
with its stuff bits and the three bits of intermission, but no error frames. Faults in the log are left out and reported
with their places; the exit status is then 1.
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
    """Add the verb's arguments."""
    parser.add_argument("logs", nargs="+", metavar="LOG", help="a log of any format; - is standard input")
    for name, what in (
        ("bit-rate", "bit rate of the buses, if a log does not contain it"),
        ("data-bit-rate", "the same for the data phase of CAN FD"),
    ):
        parser.add_argument(f"--{name}", action="append", default=[], metavar="[CHANNEL=]BIT/S", help=what)
    add_database_argument(parser, "names and cycle times", several=True)
    parser.add_argument("--together", action="store_true", help="read all logs as one continuous log")
    parser.add_argument(
        "--from", dest="form", metavar="FORMAT", help="format of LOG (default: by its first bytes)"
    )
    parser.add_argument("--json", action="store_true", help="print JSON, an object for each log")


def run(arguments: argparse.Namespace) -> int:
    """Print the statistics; 1 if a log has faults. Raises BadLog, BadValue, BadDescription, OSError."""
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
    """Return the bit rates by channel, "" for all; raises BadValue."""
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
