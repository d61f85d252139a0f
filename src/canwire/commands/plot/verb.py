"""`canwire plot`: draw signals of a log, or of a line of the hub.

canwire plot drive.log --db engine.dbc EngineData.EngineSpeed -o speed.png
canwire plot drive.log --db engine.dbc EngineData -o engine.svg         all signals of a message
canwire plot drive.log --db engine.dbc EngineSpeed Temperature -o engine.html    a page to zoom, in a browser
canwire plot drive.log --db can0=engine.dbc --db can1=engine.dbc EngineSpeed -o both.png   a database for each channel
canwire plot drive.log --db engine.dbc EngineSpeed --begin 1 --end 2.5 -o part.png
canwire plot can0 --db engine.dbc EngineSpeed --seconds 2 -o now.svg    a line, for 2 s from now

If LOG is not a file, it is the name of a line. The suffix of OUT is its format: png or svg (both need canwire[plot]),
or html, a self-contained page that needs no network. Signals with the same unit share a panel. Times are seconds from
the first entry of the log, or from now. A signal with very many samples is reduced: the smallest and the largest sample
of each small group are kept.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from canwire import BadValue, WantedMode
from canwire.commands.console import complain
from canwire.commands.databases.chosen import add_database_argument, databases_of
from canwire.commands.plot.choosing import Chosen, choose_signals
from canwire.commands.plot.tracks import Tracks
from canwire.commands.shared_hub import add_hub_argument, add_rate_argument

if TYPE_CHECKING:
    from collections.abc import Callable

SUFFIXES = ("png", "svg", "html")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument(
        "source", metavar="LOG", help="a log of any format (- is standard input), or a line: can0"
    )
    parser.add_argument(
        "signals", nargs="+", metavar="SIGNAL", help="Message.Signal, Signal, or Message for all its signals"
    )
    add_database_argument(parser, "signals by name", several=True, required=True)
    parser.add_argument(
        "-o", "--out", metavar="OUT", required=True, help=f"the file to write: {', '.join(SUFFIXES)}"
    )
    parser.add_argument("--channel", metavar="NAME", help="only this channel of a log")
    parser.add_argument(
        "--begin", type=float, metavar="SECONDS", help="begin here in a log, in seconds from its first entry"
    )
    parser.add_argument(
        "--end", type=float, metavar="SECONDS", help="end here in a log, in seconds from its first entry"
    )
    parser.add_argument("--seconds", type=float, metavar="SECONDS", help="time to watch a line (10)")
    parser.add_argument(
        "--from", dest="form", metavar="FORMAT", help="format of LOG (default: by its first bytes)"
    )
    add_rate_argument(parser, "--bit-rate", "if the line is not running yet", WantedMode.USUAL_BIT_RATE)
    add_rate_argument(
        parser, "--data-bit-rate", "the same for the data phase of CAN FD", WantedMode.USUAL_DATA_BIT_RATE
    )
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Draw; return 1 if the log has faults. Raises BadValue for unknown names and if there is nothing to draw."""
    write = _writer(arguments.out)
    databases = databases_of(arguments)
    assert databases is not None  # argparse asks for it
    chosen = choose_signals(databases, arguments.signals)
    is_log = arguments.source == "-" or os.path.exists(arguments.source)
    _check(arguments, is_log)
    tracks = Tracks(chosen.labels)
    if not is_log:
        _of_line(arguments, chosen, tracks, write)
        return 0
    from canwire.commands.plot.from_log import read_tracks

    faults = read_tracks(arguments, chosen, tracks)
    _draw(arguments, tracks, write)
    return 1 if faults else 0


def _of_line(arguments: argparse.Namespace, chosen: Chosen, tracks: Tracks, write: Write) -> None:
    """Draw what a line receives. Ctrl-C ends the reception; what was received until then is drawn."""
    from canwire.commands.plot.from_line import listen_for_tracks

    try:
        listen_for_tracks(arguments, chosen, tracks)
    except KeyboardInterrupt:
        if tracks.filled:
            _draw(arguments, tracks, write)
        raise
    _draw(arguments, tracks, write)


def _draw(arguments: argparse.Namespace, tracks: Tracks, write: Write) -> None:
    if not tracks.filled:
        raise BadValue(f"nothing to plot: {arguments.source} has none of {', '.join(arguments.signals)}")
    for label in tracks.empty:
        complain(f"{label}: not in {arguments.source}")
    if tracks.no_numbers:
        complain(f"{tracks.no_numbers} samples left out: infinite, or no numbers")
    write(
        arguments.out,
        tracks,
        f"{Path(arguments.source).name}, {', '.join(Path(one).name for one in arguments.db)}",
    )
    complain(f"{tracks.samples} samples of {len(tracks.filled)} signals in {arguments.out}")


if TYPE_CHECKING:
    Write = Callable[[str, Tracks, str], None]


def _writer(out: str) -> Write:
    """Return the function that draws this kind of file; raises BadValue, ExtraMissing before anything is read."""
    suffix = Path(out).suffix.lower().lstrip(".")
    if suffix not in SUFFIXES:
        raise BadValue(f"-o {out}: {' or '.join(f'.{one}' for one in SUFFIXES)} tells what it becomes")
    if suffix == "html":
        from canwire.commands.plot.page import write_page

        return write_page
    from canwire.commands.plot.picture import write_picture

    return write_picture


def _check(arguments: argparse.Namespace, is_log: bool) -> None:
    for name in ("seconds",) if is_log else ("begin", "end", "channel"):
        if getattr(arguments, name) is not None:
            kind = "a line, and this is a log" if is_log else "a log, and there is no such file"
            raise BadValue(f"--{name}: of {kind} ({arguments.source})")
    if arguments.seconds is not None and not 0 < arguments.seconds < 1e9:
        raise BadValue(f"--seconds {arguments.seconds:g}: more than 0")
    begin, end = arguments.begin, arguments.end
    if begin is not None and end is not None and not begin < end:
        raise BadValue(f"--begin {begin:g} --end {end:g}: the end is after the beginning")
