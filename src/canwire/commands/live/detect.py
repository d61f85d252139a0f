"""`canwire detect`: find the bit rate of a bus by listening; nothing is sent and no frame is disturbed.

canwire detect can0                      through a line on can0 that no program uses
canwire detect HW000001:0 --timeout 5    five seconds for each rate, where frames are rare
canwire detect can0 --rate 83333         this rate as well; again: more of them
canwire detect can0 --json               an object, for programs

Rates are tried one after the other: a whole frame shows that a rate is right, an error that it is wrong. A line that is
set up is put back as it was, and runs again if it ran. Exit status 1 if no rate fits, or nothing was received.
"""

from __future__ import annotations

import argparse
import json
import math
import time
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire import BadTiming, BadValue, Capabilities, InUse, LinePlace, LineStatus, NothingHeard, Unsupported
from canwire.commands.console import complain
from canwire.commands.live.scan import Candidate, Scan
from canwire.commands.shared_hub import add_hub_argument, add_line_argument, connected, find_line
from canwire.commands.shell.progress import Progress, watched

if TYPE_CHECKING:
    from canwire import Control, Hub

RATES = (500_000, 250_000, 1_000_000, 125_000, 100_000, 800_000, 50_000, 20_000, 10_000, 5_000)
_DATA_RATES = (2_000_000, 1_000_000, 4_000_000, 5_000_000, 8_000_000)
_LONGEST_S = 3600.0
_PATIENCE_S = 3.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_line_argument(parser, "HW000001:0, usb-to-can-fd:1, or the name of a bus: can0")
    parser.add_argument(
        "--timeout", type=float, default=1.0, metavar="SECONDS", help="how long to listen at each rate (1)"
    )
    parser.add_argument(
        "--rate",
        type=int,
        action="append",
        default=[],
        metavar="BIT/S",
        help="one more to try, before the usual ones",
    )
    parser.add_argument("--json", action="store_true", help="print a JSON object")
    parser.add_argument("--quiet", action="store_true", help="say nothing while it listens")
    add_hub_argument(parser)


def run(arguments: argparse.Namespace) -> int:
    """Find and print the bit rate; returns 1 if none fits. Raises InUse for a line that others use, HubError."""
    if not 0 < arguments.timeout <= _LONGEST_S:
        raise BadValue(f"--timeout {arguments.timeout}: more than 0 seconds, {_LONGEST_S:.0f} at most")
    with ExitStack() as closing:
        hub = connected(arguments, "detect", closing)
        place = find_line(hub, arguments.line, to_send=True)
        try:
            quiet = arguments.quiet or arguments.json
            found = detected(hub, place, arguments.rate, arguments.timeout, quiet=quiet)
        except NothingHeard as error:
            complain(f"{place.address} on {place.info.bus or 'its bus'}: {error}")
            return 1
    _show(arguments, place, found)
    return 0


def _show(arguments: argparse.Namespace, place: LinePlace, found: Candidate) -> None:
    nominal, data = found.nominal.bit_rate, None if found.data is None else found.data.bit_rate
    if arguments.json:
        facts = {"line": place.address, "bus": place.info.bus, "bit_rate": nominal, "data_bit_rate": data}
        print(json.dumps(facts))
        return
    print(
        f"{place.address} on {place.info.bus or 'its bus'}: {nominal} bit/s"
        + (f", {data} after BRS" if data else "")
    )


def detected(
    hub: Hub, place: LinePlace, more: list[int], timeout_s: float, *, quiet: bool = True
) -> Candidate:
    """The rate, listening through this line, which afterwards is as it was. Says how far it is unless `quiet`.

    Raises NothingHeard, BadTiming where the line can make none of the rates, InUse while others use the line.
    """
    before = place.status(hub)
    if before.running and before.channels:
        raise InUse(
            f"{place.address} runs, and {before.channels} channels use it; name a line that nobody uses, or end those"
        )
    candidates = candidates_of(place.info.capabilities, [*more, *RATES])
    progress = _progress(place, len(candidates), timeout_s, quiet)
    with hub.open_control(place.board.id, place.line) as control:
        if before.running:
            control.stop()
        try:
            began_s = time.monotonic()
            with watched(progress, lambda: round(time.monotonic() - began_s)):
                return _searched(hub, place, control, candidates, timeout_s)
        finally:
            _restore(control, before)


def _progress(place: LinePlace, tries: int, timeout_s: float, quiet: bool) -> Progress:
    """Of the time that it takes at most, which is said at the beginning."""
    longest_s = tries * timeout_s
    if not quiet and longest_s >= _PATIENCE_S:
        where = f"{place.address} on {place.info.bus or 'its bus'}"
        complain(f"{where}: listening at up to {tries} settings, {longest_s:g} s at most; Ctrl-C ends it")
    return Progress(math.ceil(longest_s), "detect", unit=" s", lines=True, quiet=quiet)


def candidates_of(capabilities: Capabilities, rates: list[int]) -> list[Candidate]:
    """What such a line can be set to; on a CAN FD line with the usual data rate, and then with the others.

    Frames without the bit-rate switch are understood whatever the data rate is.
    """
    found: dict[int, list[Candidate]] = {}
    for rate in dict.fromkeys(rates):
        for order, data_rate in enumerate(_DATA_RATES if capabilities.data is not None else (None,)):
            try:
                nominal = capabilities.timing(rate)
                data = None if data_rate is None else capabilities.data_timing(max(rate, data_rate))
            except BadTiming:
                continue
            found.setdefault(order, []).append(Candidate(nominal, data, told=order > 0))
    every = [candidate for order in sorted(found) for candidate in found[order]]
    if not every:
        raise BadTiming(f"none of the rates {', '.join(map(str, rates))} can be made by this line")
    return every


def _searched(
    hub: Hub, place: LinePlace, control: Control, candidates: list[Candidate], timeout_s: float
) -> Candidate:
    """By a listener of the hub's own where the bus is simulated, else by the adapter itself."""
    try:
        at = control.detect([(one.nominal, one.data) for one in candidates], max(1, round(timeout_s * 1000)))
    except Unsupported:
        return Scan(hub, place, control).search(candidates, timeout_s)
    return candidates[at] if candidates[at].told else candidates[at]._replace(data=None)


def _restore(control: Control, before: LineStatus) -> None:
    if not before.initialised or before.mode is None:
        control.reset()
        return
    if before.mode.timing is not None:
        control.initialise(before.mode)
        if before.running:
            control.start()
