"""`canwire gen`: send generated frames on a line, by pattern or from a database.

canwire gen can0                                    five random frames a second until Ctrl-C, with or without a receiver
canwire gen can0 --id 100-1FF --rate 1000 -n 5000   these identifiers one after the other, 1000 frames/s
canwire gen can0 --load 40 --seconds 10             40 percent of the bus, for ten seconds
canwire gen can0 --id 123 --data 11xx --gap 0       as fast as the bus can carry; x is a random digit
canwire gen can0 --fd --brs --length random         CAN FD frames of every length
canwire gen can0 --db car.dbc                       the messages of a database at their cycle times
canwire gen can0 --seed 7 -n 100                    the same frames every time

IDS: 123; 123,124 in turn; 100-1FF one after the other; random; random:100-1FF; eight digits: extended. DATA: bytes in
hex, random, or increment (a counter). At the end, also after Ctrl-C, stderr gives the numbers of frames sent, refused
by the line, and not acknowledged by any node. The exit status is 1 if frames were not delivered.
"""

from __future__ import annotations

import argparse
import json
import random
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from itertools import islice
from typing import TYPE_CHECKING

from canwire import BadValue, Frame
from canwire.commands.can_line import add_line_arguments, add_timeout_argument, open_sender, wanted_by
from canwire.commands.console import complain
from canwire.commands.databases.chosen import add_database_argument, database_of
from canwire.commands.gen.pace import Gap, by_load, every
from canwire.commands.gen.patterns import Kind, frames
from canwire.commands.gen.sending import Generator
from canwire.commands.shared_hub import connected

if TYPE_CHECKING:
    from canwire import Hub, LinePlace

_QUEUE = 256
_GAP_S = 0.2
_SEEDS = 1_000_000


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_line_arguments(parser)
    _add_frames(parser.add_argument_group("frames"))
    _add_times(parser.add_argument_group("times"))
    add_database_argument(parser, "send its messages at their cycle times")
    parser.add_argument(
        "--message",
        action="append",
        default=[],
        metavar="NAME",
        help="with --db: only this message; may be given several times",
    )
    parser.add_argument("--json", action="store_true", help="print the numbers as a JSON object on stdout")


def _add_frames(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--id", default="random", metavar="IDS", help="identifiers of the frames (default: random)"
    )
    group.add_argument(
        "--data", default="random", metavar="DATA", help="data of the frames (default: random)"
    )
    group.add_argument(
        "--length", default="8", metavar="BYTES", help="bytes of data: 8, 0-8 in turn, or random (default: 8)"
    )
    group.add_argument("--dlc", type=int, metavar="CODE", help="9..15: the raw length code of classic frames")
    for name, what in (
        ("extended", "send 29-bit identifiers"),
        ("remote", "send remote frames"),
        ("fd", "send CAN FD frames"),
        ("brs", "with the bit-rate switch; implies --fd"),
        ("esi", "with the error state indicator; implies --fd"),
    ):
        group.add_argument(f"--{name}", action="store_true", help=what)
    group.add_argument(
        "--seed", type=int, metavar="NUMBER", help="seed of the random values (default: another each time)"
    )


def _add_times(group: argparse._ArgumentGroup) -> None:
    pace = group.add_mutually_exclusive_group()
    pace.add_argument(
        "--gap", type=float, metavar="SECONDS", help=f"time from one frame to the next ({_GAP_S})"
    )
    pace.add_argument("--rate", type=float, metavar="FRAMES/S", help="frames in each second")
    pace.add_argument("--load", type=float, metavar="PERCENT", help="share of the bus time")
    group.add_argument("-n", "--count", type=int, metavar="COUNT", help="end after this many frames")
    group.add_argument("--seconds", type=float, metavar="SECONDS", help="end after this time")
    add_timeout_argument(group, "with -n, ")


def run(arguments: argparse.Namespace) -> int:
    """Send until COUNT, the time, or Ctrl-C; 1 if frames were not delivered. Raises BadValue, HubError."""
    _check(arguments)
    seed = random.randrange(_SEEDS) if arguments.seed is None else arguments.seed
    chance = random.Random(seed)
    source = None if arguments.db else _patterns(arguments, chance)
    with ExitStack() as closing:
        hub = connected(arguments, "gen", closing)
        place, channel = open_sender(hub, arguments.line, wanted_by(arguments), _QUEUE, closing)
        plan = _database(arguments, chance) if source is None else _paced(source, _gap(arguments, hub, place))
        complain(f"onto {place.address} on {place.info.bus}, --seed {seed}")
        generator = Generator(hub, place, channel, arguments.timeout)
        try:
            return generator.run(
                islice(plan, arguments.count), arguments.seconds, endless=arguments.count is None
            )
        finally:
            _report(arguments, generator)


def _report(arguments: argparse.Namespace, generator: Generator) -> None:
    if arguments.json:
        print(json.dumps(generator.counts()._asdict()), flush=True)
    else:
        complain(generator.summary())


def _check(arguments: argparse.Namespace) -> None:
    for name, least in (("count", 1), ("seconds", 0), ("gap", 0), ("timeout", 0)):
        value = getattr(arguments, name)
        if value is not None and not value >= least:
            raise BadValue(f"--{name} {value}: {least} or more")
    if arguments.rate is not None and not arguments.rate > 0:
        raise BadValue(
            f"--rate {arguments.rate:g}: more than 0 frames a second; --gap 0 is as fast as it goes"
        )
    if arguments.db and (arguments.load is not None or arguments.rate is not None):
        raise BadValue("--db: its messages have cycle times; leave --load and --rate out")
    if arguments.message and not arguments.db:
        raise BadValue("--message: names a message of --db FILE")


def _patterns(arguments: argparse.Namespace, chance: random.Random) -> Iterator[Frame]:
    kind = Kind(
        arguments.extended,
        arguments.remote,
        arguments.fd or arguments.brs or arguments.esi,
        arguments.brs,
        arguments.esi,
        arguments.dlc,
    )
    return frames(arguments.id, arguments.length, arguments.data, kind, chance)


def _gap(arguments: argparse.Namespace, hub: Hub, place: LinePlace) -> Gap:
    if arguments.load is not None:
        mode = place.status(hub).mode
        if mode is None:
            raise BadValue(f"--load {arguments.load:g}: {place.address} is not set up")
        return by_load(arguments.load, mode)
    if arguments.rate is not None:
        return every(1 / arguments.rate)
    return every(_GAP_S if arguments.gap is None else arguments.gap)


def _paced(source: Iterable[Frame], gap: Gap) -> Iterator[tuple[float, Frame]]:
    after_s = 0.0
    for frame in source:
        yield after_s, frame
        after_s = gap(frame)


def _database(arguments: argparse.Namespace, chance: random.Random) -> Iterator[tuple[float, Frame]]:
    from canwire.commands.gen.cyclic import CyclicMessages

    database = database_of(arguments)
    assert database is not None  # or this is not called
    messages = CyclicMessages(database, arguments.message, arguments.gap, chance)
    if messages.without:
        complain(
            f"{len(messages.without)} messages have no cycle time and are left out ({messages.without[0]}, ...); "
            "--gap gives them one"
        )
    if messages.too_long:
        complain(
            f"{len(messages.too_long)} messages need several frames and are left out ({messages.too_long[0]}, ...)"
        )
    return messages.plan()
