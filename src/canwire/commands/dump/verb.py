"""`canwire dump`: what happens on a line, as candump prints it.

canwire dump can0                     the first line on that bus; it is started if nobody did
canwire dump HW000001:0 -e            error frames and state changes as well
canwire dump can0 -l -n 1000 > log    in the form of a log (candump -l), 1000 frames
canwire dump can0 -T 2                until nothing has been heard for two seconds
canwire dump can0 -t d                each line with the time since the one before
canwire dump can0 --filter 123:7FF    frame 123 only; 700:700 is 700 to 7FF, 123~7FF all but 123
canwire dump can0 --json -e           an object a line, for programs

Frames that the line itself sends are shown as well. At the end, after Ctrl-C too, a line on stderr says how many frames
were shown, and how many were lost because they were not read in time.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import (
    BadValue,
    BusEvent,
    ChannelMode,
    EventKind,
    Frame,
    HubError,
    InUse,
    LinePlace,
    LogLine,
    Siblings,
    WantedMode,
    format_candump_line,
    format_log_line,
    format_rates,
)
from canwire.commands.can_line import add_line_arguments, bring_up, wanted_by
from canwire.commands.console import complain
from canwire.commands.dump.as_json import format_json
from canwire.commands.dump.filters import Filter, accepts, parse_filters
from canwire.commands.dump.stamps import KINDS, Stamps
from canwire.commands.shared_hub import connected, find_line
from canwire.commands.shell.colour import RED, has_colours, painted
from canwire.commands.wall_clock import epoch_ns

if TYPE_CHECKING:
    from canwire import Hub, HubChannel

_QUEUE = 32_768  # frames: more than a second of the busiest classic bus
_BATCH = 256
_EVENTS = (EventKind.ERROR, EventKind.STATE)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    add_line_arguments(parser)
    parser.add_argument("-l", "--log", action="store_true", help="print log lines, as candump -l writes them")
    parser.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after this many lines")
    parser.add_argument("-T", "--timeout", type=float, metavar="SECONDS", help="end after this much silence")
    parser.add_argument(
        "-e", "--errors", action="store_true", help="show error frames and state changes as well"
    )
    parser.add_argument(
        "-t",
        "--stamps",
        choices=KINDS,
        help=f"{'; '.join(f'{kind}: {what}' for kind, what in KINDS.items())}",
    )
    parser.add_argument(
        "--filter",
        action="append",
        default=[],
        metavar="ID:MASK",
        help="show these frames only, ID~MASK all others; again, or with commas: any of them; 8 digits: extended",
    )
    parser.add_argument("--json", action="store_true", help="print JSON, one object a line")
    parser.add_argument("-i", "--bus-name", action="store_true", help="show the bus's name instead of LINE")


def run(arguments: argparse.Namespace) -> int:
    """Print lines until COUNT, silence or Ctrl-C; BadValue, NoSuchBoard, HubError for what cannot be."""
    if arguments.count is not None and arguments.count < 1:
        raise BadValue(f"-n {arguments.count}: 1 or more")
    if arguments.timeout is not None and not arguments.timeout >= 0:
        raise BadValue(f"-T {arguments.timeout}: seconds from 0 up")
    if arguments.json and (arguments.log or arguments.stamps):
        raise BadValue("--json: without -l and -t; its time_s is absolute")
    if arguments.log and arguments.stamps:
        raise BadValue("-t: without -l, whose lines have absolute times")
    filters = parse_filters(arguments.filter)
    with ExitStack() as closing:
        hub = connected(arguments, "dump", closing)
        place = find_line(hub, arguments.line)
        channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
        events = tuple(int(kind) for kind in _EVENTS) if arguments.errors else ()
        channel.set_up(ChannelMode(receive=_QUEUE, transmit=0, siblings=Siblings.EVERY, events=events))
        told = _begun(hub, place, wanted_by(arguments))
        channel.activate()
        complain(told)
        dump = Dump(arguments, hub, place, channel, filters)
        try:
            dump.run()
        finally:
            complain(dump.summary())
    return 0


class Dump:
    """Lines of one channel on stdout."""

    def __init__(
        self,
        arguments: argparse.Namespace,
        hub: Hub,
        place: LinePlace,
        channel: HubChannel,
        filters: Sequence[Filter],
    ) -> None:
        self._channel = channel
        self._left: int | None = arguments.count
        self._timeout: float | None = arguments.timeout
        self._name = place.info.bus if arguments.bus_name else arguments.line
        self._filters = filters
        absolute = arguments.log or arguments.json
        self._format = (
            format_log_line if arguments.log else format_json if arguments.json else format_candump_line
        )
        epoch = epoch_ns(hub) if absolute or arguments.stamps in ("a", "A") else 0
        self._stamps = Stamps(arguments.stamps, epoch) if arguments.stamps else None
        self._next = self._contents if arguments.errors else self._frames
        self._epoch_ns = epoch if absolute else 0
        self._coloured = has_colours() and not absolute
        self._shown = 0

    def run(self) -> None:
        """Until enough was shown, or nothing came in time."""
        while self._left != 0:
            contents = self._next(_BATCH if self._left is None else min(_BATCH, self._left))
            if not contents:
                return
            shown = [content for content in contents if accepts(self._filters, content)]
            for content in shown:
                sys.stdout.write(f"{self._line(content)}\n")
            sys.stdout.flush()
            self._shown += len(shown)
            if self._left is not None:
                self._left -= len(shown)

    def _line(self, content: Frame | BusEvent) -> str:
        line = self._format(LogLine(self._epoch_ns + content.timestamp_ns, self._name, content))
        if self._coloured and isinstance(content, BusEvent):
            line = painted(line, RED)
        return line if self._stamps is None else f" {self._stamps.text(content.timestamp_ns)}{line}"

    def summary(self) -> str:
        """The numbers; without the lost ones where the hub cannot be asked any more."""
        try:
            return f"{self._shown} shown, {self._channel.status().lost} lost"
        except HubError as error:
            return f"{self._shown} shown, lost unknown: {error}"

    def _frames(self, limit: int) -> list[Frame] | list[Frame | BusEvent]:
        return self._channel.receive_many(limit, self._timeout)

    def _contents(self, limit: int) -> list[Frame] | list[Frame | BusEvent]:
        """Frames and events in their order; waits for the first."""
        found: list[Frame | BusEvent] = []
        timeout = self._timeout
        while len(found) < limit and (one := self._channel.receive_any(timeout)) is not None:
            found.append(one)
            timeout = 0
        return found


def _begun(hub: Hub, place: LinePlace, wanted: WantedMode) -> str:
    """Have the line running; where somebody else is about to start it, wait for that. Returns what to say of it."""
    try:
        bring_up(hub, place, wanted)
    except InUse as error:
        return f"{place.address} on {place.info.bus} does not run yet ({error}); listening"
    return f"{place.address} on {place.info.bus}: {format_rates(place.status(hub).mode)}; listening"
