"""`canwire record`: record lines of the hub in log files, until Ctrl-C.

canwire record can0 drive.blf                          the suffix of the file is its format
canwire record can0 drive.log --rotate-size 100M       drive-0001.log, drive-0002.log, ...: 100 MB each
canwire record can0 drive.mf4 --rotate-time 1h         a new file every hour
canwire record can0 drive.pcapng --for 60              for a minute
canwire record can0 day/                               a trace: a folder of Parquet files, for `canwire query`
canwire record can0 - --format candump                 to standard output
canwire record lin0 drive.blf                          a LIN line; trc cannot hold LIN
canwire record can0 can1 lin0 drive.mf4                several lines, in the order of their time stamps
canwire record any drive.blf                           a line of every bus

A CONDITION is an identifier as in `canwire dump --filter`, an identifier with data (123#11..F0; a dot matches any
hex digit), error, state, bus-off, or a comparison of a signal (EngineSpeed>3000). Of several conditions, one must hold.
The log marks the gaps between its parts.

The log contains frames, error frames, changes of state, bit rates and numbers of lost frames, if its format can hold
them. All entries older than a second can be read even if this process is killed: formats that cannot be read before
their end (parquet, mf4) are accompanied by a journal until then, NAME.journal, which `canwire convert` reads. A trace
needs a new or empty folder; its growing file is a journal, too.
"""

from __future__ import annotations

import argparse
import glob
import itertools
import os
import re
import time
from contextlib import closing

import canwire
from canwire import BadValue, HubError, Recorder, RecordTriggers
from canwire.commands.can_line import add_rate_arguments
from canwire.commands.console import complain
from canwire.commands.databases.chosen import add_database_argument, database_of
from canwire.commands.logs.conditions import any_of
from canwire.commands.reconnecting import add_reconnect_argument, going_on, not_if
from canwire.commands.shell.ending import signals_call

_SIZES = {"": 1, "k": 1000, "M": 1000**2, "G": 1000**3}
_SPANS = {"": 1.0, "s": 1.0, "m": 60.0, "h": 3600.0, "d": 86_400.0}
_TURN_S = 0.1


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "lines",
        nargs="+",
        metavar="LINE",
        help="HW000001:0, usb-to-can-fd:1, the name of a bus: can0; several; any: a line of every bus",
    )
    add_rate_arguments(parser)
    parser.add_argument("file", metavar="FILE", help="the log; - is standard output")
    parser.add_argument("--format", metavar="FORMAT", help="format of FILE (default: by its suffix)")
    parser.add_argument(
        "--rotate-size", metavar="BYTES", help="begin a new file after this size: 500k, 100M, 2G"
    )
    parser.add_argument(
        "--rotate-time", metavar="TIME", help="begin a new file after this time: 90s, 10m, 1h, 1d"
    )
    _add_triggers(parser)
    parser.add_argument("--for", dest="span", metavar="TIME", help="end after this time: 90s, 10m, 1h")
    add_reconnect_argument(parser, usual=True)
    parser.add_argument(
        "--channel",
        metavar="NAME",
        help="name of the channel in the log, for one line (default: the name of its bus)",
    )


def _add_triggers(parser: argparse.ArgumentParser) -> None:
    for option, help in (
        ("start", "start recording at such an entry"),
        ("stop", "stop recording after such an entry"),
    ):
        parser.add_argument(f"--{option}-on", action="append", default=[], metavar="CONDITION", help=help)
    parser.add_argument("--before", metavar="TIME", help="also keep this time before a start: 10s, 2m")
    parser.add_argument("--after", metavar="TIME", help="also keep this time after a stop")
    parser.add_argument("--once", action="store_true", help="end after the first stop")
    add_database_argument(parser, "signals for conditions")


def run(arguments: argparse.Namespace) -> int:
    """Record until the time is over, or a signal; raises BadValue, NoSuchBoard, HubError, OSError for a full disk."""
    triggers = _triggers(arguments)
    restarts = arguments.span is not None or arguments.once or arguments.file == "-"
    not_if(arguments, restarts, "--for, --once and standard output")
    rotation = _rotation(arguments)
    seconds = None if arguments.span is None else _number("--for", arguments.span, _SPANS)
    with closing(canwire.Event(manual_reset=True)) as stop, signals_call(stop.set):
        return going_on(arguments, lambda given: _record(given, rotation, seconds, triggers, stop))


def _rotation(arguments: argparse.Namespace) -> tuple[int | None, float | None]:
    """Return the size in bytes and the time in seconds after which a new file begins; None without the option."""
    size, span = arguments.rotate_size, arguments.rotate_time
    return (
        None if size is None else int(_number("--rotate-size", size, _SIZES)),
        None if span is None else _number("--rotate-time", span, _SPANS),
    )


def _record(
    arguments: argparse.Namespace,
    rotation: tuple[int | None, float | None],
    seconds: float | None,
    triggers: RecordTriggers | None,
    stop: canwire.Event,
) -> int:
    if stop.is_set():  # while the hub was away
        return 0
    _refuse_private(arguments)
    watch = getattr(arguments, "watch", None)
    recorder = canwire.record(
        arguments.lines,
        _another(arguments.file) if watch is not None and watch.known else arguments.file,
        format=arguments.format,
        channel=arguments.channel,
        rotate_bytes=rotation[0],
        rotate_s=rotation[1],
        hub=arguments.hub,
        bit_rate=arguments.bit_rate,
        data_bit_rate=arguments.data_bit_rate,
        triggers=triggers,
    )
    if watch is not None:
        watch.found()
    _until_the_end(arguments, recorder, seconds, stop)
    return 0


def _another(file: str) -> str:
    """The file after a reconnection: drive-again-2.blf, or the next free number.

    >>> _another("/no/such/drive.blf.gz")
    '/no/such/drive-again-2.blf.gz'
    """
    folder, name = os.path.split(file)
    stem, dot, suffix = name.partition(".")
    for number in itertools.count(2):
        path = os.path.join(folder, f"{stem}-again-{number}")
        if not glob.glob(glob.escape(path) + "[-.]*") and not os.path.exists(path):
            return path + dot + suffix
    raise AssertionError


def _until_the_end(
    arguments: argparse.Namespace, recorder: Recorder, seconds: float | None, stop: canwire.Event
) -> None:
    """Raises what the recorder does: HubLost, OSError for a full disk."""
    end_s = None
    if seconds is not None:
        recorder.end_after(seconds)
        end_s = time.monotonic() + seconds
    complain(f"recording {', '.join(arguments.lines)} to {recorder.files[0]}")
    try:
        while not stop.wait(_TURN_S) and not recorder.wait(0):
            if end_s is not None and time.monotonic() >= end_s:
                break
    finally:
        try:
            recorder.close()
        finally:
            _tell(recorder)


def _triggers(arguments: argparse.Namespace) -> RecordTriggers | None:
    database = database_of(arguments)
    start = any_of(arguments.start_on, "--start-on", database)
    stop = any_of(arguments.stop_on, "--stop-on", database)
    before, after = (
        0.0 if text is None else _number(f"--{name}", text, _SPANS)
        for name, text in (("before", arguments.before), ("after", arguments.after))
    )
    if start is None and stop is None and not (before or after or arguments.once):
        return None
    return RecordTriggers(start, stop, before, after, arguments.once)


def _refuse_private(arguments: argparse.Namespace) -> None:
    """Raise HubError for a hub of this process alone, where nothing could be recorded."""
    with canwire.connect(arguments.hub, name="canwire record") as hub:
        if not hub.address:
            raise HubError("no hub is running that `record` could share; `canwire serve` starts one")


def _tell(recorder: Recorder) -> None:
    files = recorder.files
    where = files[0] if len(files) == 1 else f"{len(files)} files, {files[0]} to {files[-1]}"
    parts = f"started {recorder.starts} times, " if recorder.starts > 1 else ""
    complain(f"{parts}{recorder.count} entries in {where}; {recorder.lost} lost")
    for what, count in recorder.left_out.items():
        complain(f"{count} {what} left out")


def _number(option: str, text: str, units: dict[str, int] | dict[str, float]) -> float:
    found = re.fullmatch(r"(\d+(?:\.\d+)?)([a-zA-Z]?)", text)
    if found is None or found[2] not in units or not float(found[1]):
        known = ", ".join(f"{10}{unit}" for unit in units if unit)
        raise BadValue(f"{option} {text}: a number above 0 and a unit: {known}")
    return float(found[1]) * units[found[2]]
