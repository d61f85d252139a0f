"""`canwire dump`: show the frames on a line, as candump prints them.

canwire dump can0                     the first line on that bus; it is started if it does not run
canwire dump can0 HW000002:1          several lines; any: one of every bus
canwire dump HW000001:0 -e            errors and changes of state as well, with a line in words
canwire dump can0 -l -n 1000 > log    in the form of a log (candump -l), 1000 frames
canwire dump can0 -T 2                end after two seconds without frames; --seconds 2: after two seconds
canwire dump can0 -t d                each line with the time since the one before; -t h: the bus's own clock
canwire dump can0 -a -x               data as characters, too; RX or TX, B for the fast rate, E for error passive
canwire dump can0 -s 2 --seconds 1    no lines, only the numbers at the end; -s 1: a sign that turns; -S: swapped bytes
canwire dump can0 --filter 123        frame 123 only; 100-1FF, 700:700 by mask, ~123 all others
canwire dump can0 --kind fd,extended  CAN FD frames with 29-bit identifiers only; error: errors only
canwire dump can0 --db car.dbc        with names and signals, by a database; --message NAME: of this one
canwire dump can0 --json -e           an object a line, for programs
canwire dump can0 --pcapng now.pcapng    packets, for Wireshark; live: --pcapng - | wireshark -k -i -

Frames that the line itself sends are shown as well. At the end, also after Ctrl-C, stderr shows how many frames were
shown, how many were lost because they were not read in time, and how many errors were seen: the total of all lines,
and then the numbers of each line.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import HubError, epoch_ns
from canwire.commands.can_line import wanted_by
from canwire.commands.databases.chosen import Databases, add_database_argument, databases_of
from canwire.commands.dump.checks import check
from canwire.commands.dump.filters import KINDS as FILTER_KINDS
from canwire.commands.dump.filters import Capture, Masked, parse_capture
from canwire.commands.dump.output import Lines, Output
from canwire.commands.dump.printing import JSON, LOG, SCREEN, Extras, Printer
from canwire.commands.dump.stamps import ABSOLUTE, KINDS, Stamps
from canwire.commands.live.listening import (
    QUEUE,
    RECORD,
    Listening,
    Source,
    add_listening_arguments,
    complain_each,
    places_of,
    summary_of,
)
from canwire.commands.reconnecting import add_reconnect_argument, going_on
from canwire.commands.shared_hub import connected
from canwire.commands.shell.colour import has_colours

if TYPE_CHECKING:
    from canwire import Hub

_BATCH = 1024


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_listening_arguments(parser)
    parser.add_argument("-l", "--log", action="store_true", help="print log lines, as candump -l writes them")
    parser.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after this many lines")
    parser.add_argument("-T", "--timeout", type=float, metavar="SECONDS", help="end after this much silence")
    parser.add_argument("--seconds", type=float, metavar="SECONDS", help="end after this long")
    parser.add_argument(
        "-e", "--errors", action="store_true", help="show errors and changes of state as well"
    )
    parser.add_argument(
        "-t",
        "--stamps",
        choices=KINDS,
        help=f"{'; '.join(f'{kind}: {what}' for kind, what in KINDS.items())}",
    )
    add_reconnect_argument(parser, usual=True)
    _add_capture(parser)
    _add_extras(parser)
    add_database_argument(parser, "names and signals", several=True)
    parser.add_argument(
        "--message",
        action="append",
        default=[],
        metavar="NAME",
        help="with --db: show this message only; repeat it for several",
    )
    parser.add_argument("--json", action="store_true", help="print JSON, one object a line")
    parser.add_argument(
        "--pcapng", metavar="FILE", help="packets for Wireshark instead of lines; - is stdout"
    )
    parser.add_argument("-i", "--bus-name", action="store_true", help="show the bus's name instead of LINE")


def _add_capture(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--filter",
        action="append",
        default=[],
        metavar="IDS",
        help="show these frames only: 123, 100-1FF, 123:7FF, or all others: ~123, 123~7FF; again, or with commas: "
        "any of them, with j all of them; 8 digits: extended",
    )
    parser.add_argument(
        "--kind",
        action="append",
        default=[],
        metavar="KIND",
        help=f"show these kinds only: {', '.join(FILTER_KINDS)}; again, or with commas",
    )


def _add_extras(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-a", "--ascii", action="store_true", help="show data as characters, too")
    parser.add_argument("-x", "--extra", action="store_true", help="show RX or TX, BRS and ESI")
    parser.add_argument("-S", "--swap", action="store_true", help="show the last byte of data first")
    parser.add_argument(
        "-s", "--silent", type=int, choices=(0, 1, 2), default=0, help="1: a sign that turns, 2: no lines"
    )
    parser.add_argument("-r", "--room", type=int, metavar="BYTES", help="for frames that wait, 80 bytes each")
    parser.add_argument(
        "-D", dest="stays", action="store_true", help="continue when a line stops; canwire always does"
    )
    parser.add_argument(
        "-8", "--raw-dlc", action="store_true", help="show length codes above 8 of classic frames"
    )
    parser.add_argument(
        "-c",
        "--colour",
        action="count",
        default=0,
        help="colours, on a pipe too: of names; -c -c: of lines; -c -c -c: of times, too",
    )


def run(arguments: argparse.Namespace) -> int:
    """Print lines until COUNT, silence or Ctrl-C; BadValue, NoSuchBoard, HubError for what cannot be."""
    check(arguments)
    return going_on(arguments, _dump)


def _dump(arguments: argparse.Namespace) -> int:
    capture = parse_capture(arguments.filter, arguments.kind, arguments.errors)
    databases = databases_of(arguments)
    with ExitStack() as closing:
        hub = connected(arguments, "dump", closing)
        places = places_of(hub, arguments.lines, getattr(arguments, "watch", None))
        if arguments.bus_name:
            places = [(place.info.bus or name, place) for name, place in places]
        if arguments.message and databases is not None:
            capture = capture._replace(
                named=_named(databases, arguments.message, [name for name, _ in places])
            )
        events = tuple(int(kind) for kind in capture.events)
        queue = QUEUE if arguments.room is None else arguments.room // RECORD.size
        listening = closing.enter_context(
            Listening(hub, places, wanted_by(arguments), events=events, queue=queue)
        )
        complain_each(listening.told)
        dump = Dump(arguments, hub, listening, capture, databases)
        try:
            try:
                dump.run()
            finally:
                dump.end()
        finally:
            complain_each(dump.summary())
    return 0


def _named(
    databases: Databases, messages: Sequence[str], channels: Sequence[str]
) -> dict[str, tuple[Masked, ...]]:
    """What --message means on each channel: two of its databases may have messages of one name."""
    return {
        channel: tuple(Masked(*found, inverted=False) for found in databases.ids_of(messages, channel))
        for channel in channels
    }


class Dump:
    """Lines of what is listened to on stdout."""

    def __init__(
        self,
        arguments: argparse.Namespace,
        hub: Hub,
        listening: Listening,
        capture: Capture,
        databases: Databases | None = None,
    ) -> None:
        self._hub = hub
        self._listening = listening
        self._left: int | None = arguments.count
        self._timeout_s: float | None = arguments.timeout
        self._end_s = None if arguments.seconds is None else self._now_s() + arguments.seconds
        self._output = _output(arguments, hub, listening.sources, capture, databases)

    def run(self) -> None:
        """Print records until their number or the time is reached, or nothing came in time."""
        while self._left != 0:
            found = self._listening.take(
                _BATCH if self._left is None else min(_BATCH, self._left), self._patience_s()
            )
            for source, records in found:
                count = self._output.put(source.name, records, self._left)
                if self._left is not None:
                    self._left -= count
            self._output.flush()
            if not found or (self._end_s is not None and self._now_s() >= self._end_s):
                return

    def end(self) -> None:
        """Finish what was written; raises OSError."""
        self._output.end(self._lost)

    def summary(self) -> list[str]:
        """The numbers; without the lost ones where the hub cannot be asked any more."""
        return summary_of(self._listening, self._output.shown)

    def _lost(self) -> dict[str, int]:
        """Return the number of lost records of each line; an empty dict if the hub does not answer."""
        try:
            return {one.name: self._listening.counted(one).lost for one in self._listening.sources}
        except HubError:
            return {}

    def _patience_s(self) -> float | None:
        """How long to wait for the next record."""
        if self._end_s is None:
            return self._timeout_s
        left_s = max(0.0, self._end_s - self._now_s())
        return left_s if self._timeout_s is None else min(left_s, self._timeout_s)

    def _now_s(self) -> float:
        return self._hub.now_ns() / 1e9 if self._hub.virtual else time.monotonic()


def _output(
    arguments: argparse.Namespace,
    hub: Hub,
    sources: list[Source],
    capture: Capture,
    databases: Databases | None,
) -> Output:
    if arguments.pcapng:
        from canwire.commands.dump.packets import Packets

        return Packets(arguments.pcapng, capture, [source.name for source in sources], epoch_ns(hub))
    return Lines(_printer(arguments, hub, sources, capture, databases), arguments.silent)


def _printer(
    arguments: argparse.Namespace,
    hub: Hub,
    sources: list[Source],
    capture: Capture,
    databases: Databases | None,
) -> Printer:
    style = LOG if arguments.log else JSON if arguments.json else SCREEN
    absolute = style != SCREEN
    epoch = epoch_ns(hub) if absolute or arguments.stamps in ABSOLUTE else 0
    return Printer(
        style,
        capture,
        stamps=Stamps(arguments.stamps, epoch) if arguments.stamps else None,
        epoch_ns=epoch if absolute else 0,
        decode=None if databases is None else databases.decode,
        coloured=not absolute and has_colours(),
        several=len(sources) > 1,
        extras=Extras(arguments.ascii, arguments.extra, arguments.raw_dlc, arguments.swap, arguments.colour),
    )
