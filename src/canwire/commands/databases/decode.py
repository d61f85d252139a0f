"""`canwire decode`: decode a log with a database: signals with names and units.

canwire decode drive.log --db car.dbc                  a line for each frame that the file knows
canwire decode drive.log --db can0=car.dbc --db can1=engine.dbc    a database for each channel
canwire decode drive.log --db car.dbc --all            also print frames that no file knows
canwire decode drive.log --db car.dbc --filter 100-1FF  these frames only
canwire decode drive.log --db car.dbc --form columns   a row for each signal, columns separated by tabs
canwire decode drive.log --db car.dbc --form json      a JSON object on each line, for programs
canwire decode drive.log --db engine.dbc --check --plugin alive:alive    only frames whose counter or checksum is wrong
canwire decode drive.log --db car.dbc -o signals.parquet    a Parquet table with a row for each value

The log may be of any format, which its first bytes show; - is standard input. The exit status is 1 if some of the log
could not be read or if --check found a wrong message. The columns of -o are time_s, time_ns, channel, message, signal,
value, text, unit. `canwire query` selects signals with SQL.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterable
from typing import TYPE_CHECKING

from canwire import BadValue, Frame, open_log
from canwire.commands.console import complain
from canwire.commands.databases.chosen import Databases, add_database_argument, databases_of
from canwire.commands.databases.plugins import find_plugin
from canwire.commands.databases.table import SignalTable
from canwire.commands.databases.words import add_plugin_argument
from canwire.commands.dump.filters import parse_capture
from canwire.commands.logs.faults import tell_faults

if TYPE_CHECKING:
    from canwire import DecodedMessage, LogEntry, MessageCheck

Decoded = tuple["LogEntry", Frame, "DecodedMessage | None"]
FORMS = ("text", "columns", "json")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("log", metavar="LOG", help="a log of any format; - is standard input")
    add_database_argument(parser, "names and signals", several=True, required=True)
    parser.add_argument(
        "--from", dest="source", metavar="FORMAT", help="format of LOG (default: by its first bytes)"
    )
    parser.add_argument(
        "--filter",
        action="append",
        default=[],
        metavar="IDS",
        help="only these frames, as in `canwire dump --filter`",
    )
    parser.add_argument("--form", choices=FORMS, default="text", help="form of the output (text)")
    parser.add_argument(
        "-o", "--out", metavar="FILE.parquet", help="write a Parquet table and print no messages"
    )
    parser.add_argument(
        "--check",
        action="store_true",
        help="show only frames with a wrong counter or checksum, and why: by E2E profiles of the file and --plugin",
    )
    add_plugin_argument(parser, "with --check: the function with which the sender finishes each message")
    parser.add_argument("--all", action="store_true", help="also print frames that no file knows")


def run(arguments: argparse.Namespace) -> int:
    """Print the log; 1 if it has faults. Raises BadLog, BadDescription, BadValue, OSError."""
    databases = databases_of(arguments)
    if arguments.plugin and not arguments.check:
        raise BadValue(f"--plugin {arguments.plugin[0]}: it belongs to --check")
    assert databases is not None  # argparse asks for one
    capture = parse_capture(arguments.filter, [], False)
    with open_log(arguments.log, format=arguments.source) as log:
        try:
            decoded = (
                (entry, entry.content, databases.decode(entry.content, entry.channel))
                for entry in log
                if isinstance(entry.content, Frame) and capture.accepts(entry.content)
            )
            if arguments.check:
                return _check(arguments, databases, decoded) or int(log.fault_count > 0)
            if arguments.out is not None:
                _write(arguments.out, decoded)
            else:
                _print(arguments, decoded)
        finally:
            tell_faults(log)
        return 1 if log.fault_count else 0


def _write(path: str, decoded: Iterable[Decoded]) -> None:
    with SignalTable(path) as table:
        for entry, _, message in decoded:
            if message is not None:
                table.put(entry.timestamp_ns, entry.channel, message)
    print(f"{table.count} values to {path}")


def _check(arguments: argparse.Namespace, databases: Databases, decoded: Iterable[Decoded]) -> int:
    """1 where a counter or checksum is wrong; each is shown with the reason."""
    plugins = [find_plugin(text) for text in arguments.plugin]
    checks: dict[tuple[str, str], MessageCheck] = {}
    count = 0
    for entry, frame, message in decoded:
        if message is None:
            continue
        count += 1
        database = databases.knowing(frame, entry.channel)
        key = (entry.channel, database.path)
        check = checks.get(key) or checks.setdefault(key, database.check(plugins))
        if why := check.fault_of(frame):
            print(f"{text_of(entry, frame, message)}: {why}")
    faults = sum(check.faults for check in checks.values())
    complain(f"{count} messages, {faults} with a wrong counter or checksum")
    return 1 if faults else 0


def _print(arguments: argparse.Namespace, decoded: Iterable[Decoded]) -> None:
    written = {"text": text_of, "columns": rows_of, "json": json_of}[arguments.form]
    if arguments.form == "columns":
        print("time_s", "channel", "message", "signal", "value", "unit", "text", sep="\t")
    for entry, frame, message in decoded:
        if (message is not None or arguments.all) and (text := written(entry, frame, message)):
            print(text)


def text_of(entry: LogEntry, frame: Frame, message: DecodedMessage | None) -> str:
    """`(1.000000) can0 100 EngineData(EngineSpeed: 1500 rpm)`."""
    told = frame.data.hex(" ").upper() if message is None else str(message)
    return f"({_seconds(entry)}) {entry.channel} {_id(frame)} {told}"


def rows_of(entry: LogEntry, frame: Frame, message: DecodedMessage | None) -> str:
    """A row for each signal; nothing for a frame without."""
    if message is None:
        return ""
    rows = []
    for name, number in message.numbers.items():
        value = message.signals[name]
        text = value if isinstance(value, str) else ""
        unit = message.description.signals[name].unit
        rows.append("\t".join((_seconds(entry), entry.channel, message.name, name, str(number), unit, text)))
    return "\n".join(rows)


def json_of(entry: LogEntry, frame: Frame, message: DecodedMessage | None) -> str:
    """One object: time_s, channel, id, data, and with a name message, signals (texts) and numbers."""
    told: dict[str, object] = {
        "time_s": float(_seconds(entry)),
        "channel": entry.channel,
        "id": _id(frame),
        "data": frame.data.hex(),
    }
    if message is not None:
        told |= {"message": message.name, "signals": dict(message.signals), "numbers": dict(message.numbers)}
        if message.problem:
            told["problem"] = message.problem
    return json.dumps(told)


def _seconds(entry: LogEntry) -> str:
    seconds, rest = divmod(entry.timestamp_ns, 10**9)
    return f"{seconds}.{rest // 1000:06d}"


def _id(frame: Frame) -> str:
    return f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}"
