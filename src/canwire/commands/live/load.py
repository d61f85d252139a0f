"""`canwire load`: how busy the buses of the hub are, every second until Ctrl-C.

canwire load                      every CAN bus
canwire load can0 HW000003:0      these two
canwire load can0 --seconds 60    for a minute
canwire load --json -n 1          one object a bus, once

On a terminal a bar for each bus, with a mark where its peak was; else lines. Load is that of the last second. At the
end, after Ctrl-C too, stderr has means, peaks, frames and errors. The load of a real adapter's line is not known
and is shown as 0: its frames and errors are counted. Nothing is started or changed.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BadValue, LinePlace, NoSuchBoard, every_line, find_lines, lines_now
from canwire.commands.console import complain
from canwire.commands.live.bars import format_bar, format_reading, format_total
from canwire.commands.live.meter import Meter, Reading
from canwire.commands.reconnecting import add_reconnect_argument, going_on, not_if
from canwire.commands.shared_hub import add_hub_argument, connected
from canwire.commands.shell.colour import has_colours

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub

    Show = Callable[[list[Reading]], None]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "buses", nargs="*", metavar="BUS", help="can0, or a line: HW000001:0 (default: every bus)"
    )
    parser.add_argument(
        "--interval", type=float, default=1.0, metavar="SECONDS", help="between two looks (1)"
    )
    parser.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after so many looks")
    parser.add_argument("--seconds", type=float, metavar="SECONDS", help="end after this long")
    parser.add_argument("--json", action="store_true", help="print JSON, an object for each bus and look")
    add_reconnect_argument(parser, usual=True)
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Show loads until COUNT, the time, or Ctrl-C; BadValue, NoSuchBoard, HubError for what cannot be."""
    if arguments.count is not None and arguments.count < 1:
        raise BadValue(f"-n {arguments.count}: 1 or more")
    if not arguments.interval >= 0.05:
        raise BadValue(f"--interval {arguments.interval}: 0.05 seconds or more")
    if arguments.seconds is not None and not arguments.seconds >= 0:
        raise BadValue(f"--seconds {arguments.seconds}: 0 or more")
    not_if(arguments, arguments.count is not None or arguments.seconds is not None, "-n and --seconds")
    return going_on(arguments, _watch)


def _watch(arguments: argparse.Namespace) -> int:
    with ExitStack() as closing:
        hub = connected(arguments, "load", closing)
        places = _places(hub, arguments.buses)
        show = _json if arguments.json else Bars() if has_colours() else _lines
        watch = Watch(hub, places)
        try:
            watch.run(show, arguments.interval, arguments.count, arguments.seconds)
        finally:
            for reading in watch.last:
                complain(format_total(reading))
    return 0


def _places(hub: Hub, buses: list[str]) -> list[LinePlace]:
    found = (
        [place for bus in buses for place in find_lines(hub, bus, "CAN")] if buses else every_line(hub, "CAN")
    )
    if not found:
        raise NoSuchBoard("the hub has no CAN line; `canwire plug` puts a board in")
    return list({place.address: place for place in found}.values())


class Watch:
    """Looks at lines again and again; `last` is what was seen at last."""

    def __init__(self, hub: Hub, places: list[LinePlace]) -> None:
        self._hub = hub
        self._places = places
        self._meter = Meter()
        self.last: list[Reading] = []

    def run(self, show: Show, interval_s: float, count: int | None, seconds: float | None) -> None:
        """A look now, to count from, and one after each interval, which is shown. Raises HubLost."""
        end_s = None if seconds is None else self._now_s() + seconds
        due_s = self._now_s()
        self.last = self._meter.look(lines_now(self._hub, self._places))
        shown = 0
        while count is None or shown < count:
            due_s += interval_s
            if end_s is not None and due_s > end_s + interval_s / 2:
                return
            self._wait(due_s - self._now_s())
            self.last = self._meter.look(lines_now(self._hub, self._places))
            show(self.last)
            shown += 1

    def _wait(self, seconds: float) -> None:
        if self._hub.virtual:
            self._hub.run_for(max(0.0, seconds))
        else:
            time.sleep(max(0.0, seconds))

    def _now_s(self) -> float:
        return self._hub.now_ns() / 1e9 if self._hub.virtual else time.monotonic()


class Bars:
    """Each look in place of the one before, on a terminal."""

    def __init__(self) -> None:
        self._lines = 0

    def __call__(self, readings: list[Reading]) -> None:
        columns, _ = shutil.get_terminal_size()
        width = max(len(reading.bus) for reading in readings) if readings else 0
        up = f"\x1b[{self._lines}A" if self._lines else ""
        bars = [format_bar(reading, width, columns, coloured=True) for reading in readings]
        sys.stdout.write(up + "".join(f"\x1b[2K{bar}\n" for bar in bars))
        sys.stdout.flush()
        self._lines = len(bars)


def _lines(readings: list[Reading]) -> None:
    width = max((len(reading.bus) for reading in readings), default=0)
    for reading in readings:
        print(format_reading(reading, width), flush=True)


def _json(readings: list[Reading]) -> None:
    for reading in readings:
        found = {
            name: round(value, 2) if isinstance(value, float) else value
            for name, value in reading._asdict().items()
        }
        print(json.dumps(found), flush=True)
