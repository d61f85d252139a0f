"""Options of `canwire dump` that do not go together."""

from __future__ import annotations

import argparse

from canwire import BadValue
from canwire.commands.live.listening import RECORD
from canwire.commands.reconnecting import not_if

MOST_ROOM = 80 << 20  # bytes


def check(arguments: argparse.Namespace) -> None:
    """Raises BadValue for options that do not go together."""
    if arguments.count is not None and arguments.count < 1:
        raise BadValue(f"-n {arguments.count}: 1 or more")
    for option, value in (("-T", arguments.timeout), ("--seconds", arguments.seconds)):
        if value is not None and not value >= 0:
            raise BadValue(f"{option} {value}: seconds from 0 up")
    if arguments.json and (arguments.log or arguments.stamps):
        raise BadValue("--json: without -l and -t; its time_s is absolute")
    if arguments.log and arguments.stamps:
        raise BadValue("-t: without -l, whose lines have absolute times")
    if arguments.room is not None and not RECORD.size <= arguments.room <= MOST_ROOM:
        raise BadValue(f"-r {arguments.room}: {RECORD.size} to {MOST_ROOM} bytes")
    from_start = arguments.count is not None or arguments.seconds is not None or bool(arguments.pcapng)
    not_if(arguments, from_start, "-n, --seconds and --pcapng")
    for option in ("ascii", "extra", "raw_dlc", "swap", "colour", "silent"):
        if getattr(arguments, option) and (arguments.log or arguments.json or arguments.pcapng):
            raise BadValue(
                f"--{option.replace('_', '-')}: for lines on a screen; without --log, --json and --pcapng"
            )
    if arguments.message and not arguments.db:
        raise BadValue("--message: names a message of --db FILE")
    if arguments.log and arguments.db:
        raise BadValue("--db: without -l, whose lines have no room for names")
    if arguments.pcapng:
        for option in ("log", "stamps", "json"):
            if getattr(arguments, option):
                raise BadValue(f"--pcapng: without --{option}; packets are no lines")
        if arguments.db and not arguments.message:
            raise BadValue("--pcapng: without --db, unless --message names what to capture")
