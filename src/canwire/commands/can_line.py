"""How the verbs have a CAN line running; lin/line.py does a LIN line."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

import canwire
from canwire import (
    BadValue,
    Capabilities,
    ChannelMode,
    LineMode,
    LinePlace,
    LineStatus,
    WantedMode,
    every_line,
    format_rates,
    format_setter,
)
from canwire.commands.console import complain
from canwire.commands.shared_hub import add_hub_argument, add_line_argument, add_rate_argument, find_line

if TYPE_CHECKING:
    from canwire import Hub, HubChannel


def add_line_arguments(parser: argparse.ArgumentParser) -> None:
    """Add LINE, --bit-rate, --data-bit-rate and --hub."""
    add_line_argument(parser, "HW000001:0, usb-to-can-fd:1, or the name of a bus: can0")
    add_rate_arguments(parser)


def add_rate_arguments(parser: argparse.ArgumentParser) -> None:
    """Add --bit-rate, --data-bit-rate and --hub."""
    add_rate_argument(parser, "--bit-rate", "for a line that nobody started", WantedMode.USUAL_BIT_RATE)
    add_rate_argument(parser, "--data-bit-rate", "likewise, CAN FD", WantedMode.USUAL_DATA_BIT_RATE)
    add_hub_argument(parser)


def add_timeout_argument(parser: argparse._ActionsContainer, when: str = "") -> None:
    """--timeout, as what sends frames has it; `when` it counts, if not all the time."""
    parser.add_argument(
        "--timeout",
        type=float,
        default=1.0,
        metavar="SECONDS",
        help=f"{when}give up after this long without progress (1)",
    )


def wanted_by(arguments: argparse.Namespace) -> WantedMode:
    """What --bit-rate and --data-bit-rate ask for."""
    return WantedMode(arguments.bit_rate, arguments.data_bit_rate)


def open_sender(
    hub: Hub, name: str, wanted: WantedMode, queue: int, closing: ExitStack
) -> tuple[LinePlace, HubChannel]:
    """The line of that name, running, and a channel that only sends, with room for `queue` frames.

    Raises NoSuchBoard, BadValue, InUse, HubError.
    """
    lines = every_line(hub)
    place = find_line(hub, name, to_send=True, among=lines)
    channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
    channel.set_up(ChannelMode(receive=1, transmit=queue, frames=False))
    bring_up(hub, place, wanted, among=lines)
    channel.activate()
    return place, channel


def bring_up(
    hub: Hub, place: LinePlace, wanted: WantedMode, *, among: Sequence[LinePlace] | None = None
) -> None:
    """Start the line, on which this program has a channel, unless it runs; then release its control.

    A line that was set up with these rates is started unchanged. Other rates on its bus are reported, for lines
    `among` those that `every_line` has found. Raises BadValue if it runs with other rates than those requested, InUse
    if another program has its control and does not start it.
    """

    def mode_for(status: LineStatus) -> LineMode | None:
        if status.initialised and wanted.rates_agree(status.mode):
            return None
        return line_mode(place.info.capabilities, wanted)

    def check(status: LineStatus) -> None:
        if not wanted.rates_agree(status.mode):
            asked = wanted.nominal or (
                status.mode.timing.bit_rate if status.mode and status.mode.timing else 0
            )
            data = f", {wanted.data} after BRS" if wanted.data else ""
            raise BadValue(
                f"{place.address} runs at {format_rates(status.mode)}, {format_setter(status)}, not at {asked} bit/s"
                f"{data}; leave --bit-rate and --data-bit-rate out"
            )

    control = canwire.bring_up(hub, place, mode_for, check)
    if control is not None:
        control.close()
    point_out_rates(hub, place.info.bus, among)


def point_out_rates(hub: Hub, bus: str, among: Sequence[LinePlace] | None = None) -> None:
    """Print on stderr which controllers of this bus run at different rates, if any do, and which programs set them.

    `among` are the lines that `every_line` has found already.
    """
    for conflict in canwire.conflicts_on(hub, bus, among=among):
        complain(f"! {conflict}")


def line_mode(capabilities: Capabilities, wanted: WantedMode) -> LineMode:
    """How the verbs set a line up: with all that it supports, and with error reports. Raises BadTiming, BadValue."""
    if capabilities.data is None and wanted.data is not None:
        raise BadValue(f"--data-bit-rate {wanted.data}: this line knows classic CAN only; leave it out")
    return wanted.mode(capabilities)
