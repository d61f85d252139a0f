"""`canwire dump`: what happens on a line, as candump prints it.

canwire dump can0                     the first line on that bus; it is started if nobody did
canwire dump HW000001:0 -e            error frames and state changes as well
canwire dump can0 -l -n 1000 > log    in the form of a log (candump -l), 1000 frames
canwire dump can0 -T 2                until nothing has been heard for two seconds

Frames that the line itself sends are shown as well. At the end, after Ctrl-C too, a line on stderr says how many frames
were shown, and how many were lost because they were not read in time.
"""

from __future__ import annotations

import argparse
import sys
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
    parser.add_argument("-i", "--bus-name", action="store_true", help="show the bus's name instead of LINE")


def run(arguments: argparse.Namespace) -> int:
    """Print lines until COUNT, silence or Ctrl-C; BadValue, NoSuchBoard, HubError for what cannot be."""
    if arguments.count is not None and arguments.count < 1:
        raise BadValue(f"-n {arguments.count}: 1 or more")
    if arguments.timeout is not None and not arguments.timeout >= 0:
        raise BadValue(f"-T {arguments.timeout}: seconds from 0 up")
    with ExitStack() as closing:
        hub = connected(arguments, "dump", closing)
        place = find_line(hub, arguments.line)
        channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
        events = tuple(int(kind) for kind in _EVENTS) if arguments.errors else ()
        channel.set_up(ChannelMode(receive=_QUEUE, transmit=0, siblings=Siblings.EVERY, events=events))
        told = _begun(hub, place, wanted_by(arguments))
        channel.activate()
        complain(told)
        dump = Dump(arguments, hub, place, channel)
        try:
            dump.run()
        finally:
            complain(dump.summary())
    return 0


class Dump:
    """Lines of one channel on stdout."""

    def __init__(
        self, arguments: argparse.Namespace, hub: Hub, place: LinePlace, channel: HubChannel
    ) -> None:
        self._channel = channel
        self._left: int | None = arguments.count
        self._timeout: float | None = arguments.timeout
        self._name = place.info.bus if arguments.bus_name else arguments.line
        self._format = format_log_line if arguments.log else format_candump_line
        self._next = self._contents if arguments.errors else self._frames
        self._epoch_ns = epoch_ns(hub) if arguments.log else 0
        self._coloured = has_colours() and not arguments.log
        self._shown = 0

    def run(self) -> None:
        """Until enough was shown, or nothing came in time."""
        while self._left != 0:
            contents = self._next(_BATCH if self._left is None else min(_BATCH, self._left))
            if not contents:
                return
            for content in contents:
                stamp_ns = self._epoch_ns + content.timestamp_ns
                line = self._format(LogLine(stamp_ns, self._name, content))
                if self._coloured and isinstance(content, BusEvent):
                    line = painted(line, RED)
                sys.stdout.write(f"{line}\n")
            sys.stdout.flush()
            self._shown += len(contents)
            if self._left is not None:
                self._left -= len(contents)

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
