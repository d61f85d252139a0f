"""Several lines of a hub listened to together, as records in the order of their times."""

from __future__ import annotations

import argparse
import struct
from collections.abc import Sequence
from contextlib import ExitStack
from itertools import groupby
from operator import itemgetter
from typing import TYPE_CHECKING, NamedTuple

from canwire import (
    ChannelMode,
    HubError,
    InUse,
    LinePlace,
    NoSuchBoard,
    Siblings,
    WantedMode,
    every_line,
    format_rates,
)
from canwire.commands.can_line import add_rate_arguments, bring_up
from canwire.commands.console import complain
from canwire.commands.live.same_lines import same_line

if TYPE_CHECKING:
    from canwire import Event, Hub, HubChannel, LineStatus
    from canwire.commands.reconnecting import Watch

ANY = "any"
QUEUE = 32_768  # frames: more than a second of the busiest classic bus
RECORD = struct.Struct("<QII64s")
Record = tuple[int, int, int, bytes]  # time_ns, id, info, 64 bytes of data, as docs of record_dtype have them


class Source(NamedTuple):
    """A line that is listened to, under the name that people see."""

    name: str
    place: LinePlace
    channel: HubChannel
    errors_before: int


class Counted(NamedTuple):
    """What one line has had since listening began: records that were not taken in time, errors on its bus."""

    name: str
    lost: int
    errors: int


def add_listening_arguments(parser: argparse.ArgumentParser) -> None:
    """Add LINE ..., --bit-rate, --data-bit-rate and --hub."""
    parser.add_argument(
        "lines",
        nargs="+",
        metavar="LINE",
        help="HW000001:0, usb-to-can-fd:1, the name of a bus: can0; several; any: a line of every bus",
    )
    add_rate_arguments(parser)


def places_of(hub: Hub, names: Sequence[str], watch: Watch | None = None) -> list[tuple[str, LinePlace]]:
    """The CAN lines meant, each once; "any" is one line of every bus, and each that is on none. Raises NoSuchBoard.

    With a `watch`, a hub that is back has the same lines again (same_lines.py).
    """
    found: dict[str, tuple[str, LinePlace]] = {}
    for name in names:
        every = _one_of_each_bus(hub) if name == ANY else [(name, same_line(hub, name, watch))]
        for shown, place in every:
            found.setdefault(place.address, (shown, place))
    if not found:
        raise NoSuchBoard("any: the hub has no CAN line; `canwire plug` puts a board in")
    return list(found.values())


def _one_of_each_bus(hub: Hub) -> list[tuple[str, LinePlace]]:
    buses: dict[str, LinePlace] = {}
    for place in every_line(hub, "CAN"):
        buses.setdefault(place.info.bus or place.address, place)
    return list(buses.items())


class Listening:
    """Channels on these lines, which are started unless they run; `told` has a message on the state of each."""

    def __init__(
        self,
        hub: Hub,
        places: Sequence[tuple[str, LinePlace]],
        wanted: WantedMode,
        *,
        events: tuple[int, ...] = (),
        queue: int = QUEUE,
    ) -> None:
        self._hub = hub
        self._closing = ExitStack()
        self.told: list[str] = []
        with ExitStack() as on_failure:
            on_failure.callback(self._closing.close)
            self.sources = [self._opened(name, place, wanted, events, queue) for name, place in places]
            on_failure.pop_all()
        self._event = self._one_event() if len(self.sources) > 1 else None

    def take(self, limit: int, timeout_s: float | None) -> list[tuple[Source, list[Record]]]:
        """Up to `limit` records of each line, oldest first; waits `timeout_s` for the first (None: no limit).

        Returns runs of records, each of one line. Records of several lines that are found together are put in order.
        Raises Unplugged, HubLost.
        """
        found = self._taken(limit)
        if not found:
            self.check()
            if timeout_s != 0:
                found = self._awaited(limit, timeout_s)
        return found if len(found) < 2 else _in_order(found)

    def check(self) -> None:
        """Raises Unplugged, HubLost if nothing can come from a line any more."""
        for source in self.sources:
            source.channel.check()

    def counted(self, source: Source) -> Counted:
        """The counters of one line so far; raises HubError if the hub does not answer."""
        lost = source.channel.status().lost
        now = source.place.status(self._hub).errors
        errors = now - source.errors_before if now >= source.errors_before else now
        return Counted(source.name, lost, errors)

    def close(self) -> None:
        """Give the channels back; a second time does nothing."""
        self._closing.close()

    def __enter__(self) -> Listening:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _opened(
        self, name: str, place: LinePlace, wanted: WantedMode, events: tuple[int, ...], queue: int
    ) -> Source:
        channel = self._closing.enter_context(self._hub.open_channel(place.board.id, place.line))
        channel.set_up(ChannelMode(receive=queue, transmit=0, siblings=Siblings.EVERY, events=events))
        told, status = _begun(self._hub, place, wanted, channel)
        self.told.append(told)
        return Source(name, place, channel, status.errors)

    def _one_event(self) -> Event:
        from canwire import Event

        event = Event()
        self._closing.callback(event.close)
        for source in self.sources:
            source.channel.reading.assign(event)
            self._closing.callback(source.channel.reading.assign, None)
        return event

    def _taken(self, limit: int) -> list[tuple[Source, list[Record]]]:
        found = []
        for source in self.sources:
            end = source.channel.reading
            records = [record for block in end.ring.acquire(limit) for record in RECORD.iter_unpack(block)]
            if records:
                end.ring.release(len(records))
                end.touched()
                found.append((source, records))
        return found

    def _awaited(self, limit: int, timeout_s: float | None) -> list[tuple[Source, list[Record]]]:
        if self._event is None:
            self.sources[0].channel.reading.wait(timeout_s)
            return self._taken(limit)
        end_s = None if timeout_s is None else self._event.clock_s() + timeout_s
        left_s = timeout_s
        while self._event.wait(left_s):
            if found := self._taken(limit):
                return found
            self.check()
            left_s = None if end_s is None else max(0.0, end_s - self._event.clock_s())
        return []


def _in_order(found: list[tuple[Source, list[Record]]]) -> list[tuple[Source, list[Record]]]:
    every = [(record[0], at, record) for at, (_, records) in enumerate(found) for record in records]
    every.sort(key=itemgetter(0, 1))
    return [(found[at][0], [record for _, _, record in run]) for at, run in groupby(every, key=itemgetter(1))]


def _begun(hub: Hub, place: LinePlace, wanted: WantedMode, channel: HubChannel) -> tuple[str, LineStatus]:
    """Have the line running; where somebody else is about to start it, wait for that.

    Returns what to say of it, and how it was when the channel began to hear.
    """
    why = "it was stopped meanwhile"
    try:
        bring_up(hub, place, wanted)
    except InUse as error:
        why = str(error)
    status = channel.activate()
    if status.running:
        return f"{place.address} on {place.info.bus}: {format_rates(status.mode)}; listening", status
    return f"{place.address} on {place.info.bus} does not run yet ({why}); listening", status


def summary_of(listening: Listening, shown: dict[str, int]) -> list[str]:
    """The numbers at the end, of all lines together and then of each; `shown` by name."""
    told, lost, errors = [], 0, 0
    for source in listening.sources:
        one = shown.get(source.name, 0)
        try:
            counted = listening.counted(source)
        except HubError as error:
            return [f"{sum(shown.values())} shown, lost unknown: {error}"]
        lost, errors = lost + counted.lost, errors + counted.errors
        told.append(f"{source.name}: {_numbers(one, counted.lost, counted.errors)}")
    total = _numbers(sum(shown.values()), lost, errors)
    return [total, *told] if len(told) > 1 else [total]


def complain_each(lines: Sequence[str]) -> None:
    """Print each line on stderr."""
    for line in lines:
        complain(line)


def _numbers(shown: int, lost: int, errors: int) -> str:
    return f"{shown} shown, {lost} lost" + (f", {errors} error{'s' * (errors != 1)} seen" if errors else "")
