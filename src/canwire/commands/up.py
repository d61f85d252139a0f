"""`canwire up`: set a line up and start it; it keeps running after this command, until `canwire stop`.

canwire up can0                               the first line on can0 that no program uses
canwire up HW000001:0 --bit-rate 250000       this one, at 250 kbit/s

A line that was set up and stopped keeps its settings, unless other rates are given. If its adapter keeps the line off
its bus, the reason is shown and the exit status is 1; the line is started all the same, and joins the bus once it can.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from dataclasses import replace

import canwire
from canwire import BadValue, LineMode, LineStatus, every_line, format_rates, format_setter
from canwire.commands.can_line import add_line_arguments, line_mode, point_out_rates, wanted_by
from canwire.commands.console import complain
from canwire.commands.shared_hub import connected, find_line


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    add_line_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Start the lines and print their rates. Raises BadValue for a running line, InUse for one that others control."""
    with ExitStack() as closing:
        hub = connected(arguments, "up", closing)
        lines = every_line(hub)
        place = find_line(hub, arguments.line, to_send=True, among=lines)

        wanted = wanted_by(arguments)

        def mode_for(status: LineStatus) -> LineMode:
            if status.mode is not None and status.initialised and wanted.rates_agree(status.mode):
                return replace(status.mode, persistent=True)
            return replace(line_mode(place.info.capabilities, wanted), persistent=True)

        def check(status: LineStatus) -> None:
            kept = f", but {status.obstacle}" if status.obstacle else ""
            raise BadValue(
                f"{place.address} runs already at {format_rates(status.mode)}, {format_setter(status)}{kept}; "
                f"`canwire stop {place.address}` ends that"
            )

        control = canwire.bring_up(hub, place, mode_for, check)
        if control is not None:
            control.close()
        point_out_rates(hub, place.info.bus, lines)
        status = place.status(hub)
        print(f"{place.address} on {place.info.bus or 'no bus'}: {format_rates(status.mode)}")
        if status.obstacle:
            complain(f"{place.address}: {status.obstacle}; it joins its bus when that is fixed")
            return 1
    return 0
