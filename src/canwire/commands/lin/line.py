"""How the verbs have a LIN line running.

Other than a CAN line it is its master's: only that one needs the control for longer than a start.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadValue, CanwireError, InUse, LinePlace, LinLineStatus, LinMode, find_lines
from canwire.commands.console import complain
from canwire.commands.shared_hub import add_hub_argument, add_line_argument, add_rate_argument, find_line

if TYPE_CHECKING:
    from canwire import Hub, LinControl

USUAL_BIT_RATE = 19_200


class Wish(NamedTuple):
    """How a line should be; `bit_rate` None: as it is, or the usual one."""

    master: bool
    bit_rate: int | None

    @property
    def mode(self) -> LinMode:
        """How these commands set a line up: errors reported."""
        return LinMode(self.master, USUAL_BIT_RATE if self.bit_rate is None else self.bit_rate, errors=True)


def add_lin_arguments(parser: argparse.ArgumentParser) -> None:
    """Add LINE, --bit-rate and --hub."""
    add_line_argument(parser, "HW000001:2, usb-to-can-fd:2, or the name of a bus: lin0")
    add_rate_argument(parser, "--bit-rate", "for a line that nobody started", USUAL_BIT_RATE)
    add_hub_argument(parser)


def find_lin_line(hub: Hub, name: str, *, to_send: bool = False) -> LinePlace:
    """The LIN line of that name; raises NoSuchBoard, or BadValue for a CAN line."""
    return find_line(hub, name, to_send=to_send, bus_type="LIN")


def lin_status_of(hub: Hub, place: LinePlace) -> LinLineStatus:
    return hub.lin_status(place.board.id, place.line).status


def mode_text(status: LinLineStatus) -> str:
    """`slave, 19200 bit/s`"""
    if status.mode is None:
        return "not initialised"
    rate = f"{status.bit_rate} bit/s" if status.bit_rate else "no bit rate yet"
    return f"{'master' if status.mode.master else 'slave'}, {rate}"


def begin_listening(hub: Hub, place: LinePlace, wish: Wish) -> str:
    """Start the line unless another program is about to start it; returns a message about it.

    The caller has a monitor on it, so it keeps running after its control is released; other programs may take that.
    Raises BadValue if it runs with another bit rate than the one asked for.
    """
    status = lin_status_of(hub, place)
    if not status.running:
        try:
            with hub.open_lin_control(place.board.id, place.line) as control:
                if not _suits(status, wish):
                    control.initialise(wish.mode)
                control.start()
        except InUse as error:
            if not lin_status_of(hub, place).running:
                return f"{place.address} on {_bus(place)} does not run yet ({error}); listening"
    status = lin_status_of(hub, place)
    _check_agreement(place, status, wish)
    point_out_rates(hub, place)
    return f"{place.address} on {_bus(place)}: {mode_text(status)}; listening"


def become_master(hub: Hub, place: LinePlace, bit_rate: int | None, closing: ExitStack) -> LinControl:
    """The line's control, held until `closing`, and the line running as master.

    Raises InUse while another program has the control, BadValue if it runs with another bit rate.
    """
    try:
        control = closing.enter_context(hub.open_lin_control(place.board.id, place.line))
    except InUse as error:
        raise InUse(f"only one at a time can be the master of a line: {error}") from None
    status = lin_status_of(hub, place)
    if status.running:
        _check_agreement(place, status, Wish(True, bit_rate))
    wish = Wish(True, bit_rate or status.bit_rate or None)
    if status.mode is None or not (status.mode.master and status.mode.errors and _suits(status, wish)):
        control.initialise(wish.mode)
    control.start()
    point_out_rates(hub, place)
    return control


def point_out_rates(hub: Hub, place: LinePlace) -> None:
    """Print on stderr which lines of one bus run at different bit rates, if any do, and which programs hold them."""
    found = [
        (one, hub.lin_status(one.board.id, one.line))
        for one in find_lines(hub, place.info.bus or place.address)
    ]
    running = [(one, use) for one, use in found if use.status.running and use.status.bit_rate]
    if len({use.status.bit_rate for _, use in running}) > 1:
        told = "; ".join(
            f"{one.address} at {use.status.bit_rate} bit/s, control {use.control_holder or 'free'}"
            for one, use in running
        )
        complain(f"! {place.info.bus}: different bit rates on one bus: {told}")


def end_schedule(control: LinControl) -> None:
    """Stop the schedule; errors of the line or of the hub are ignored."""
    with suppress(CanwireError):
        control.stop_schedule()


def _suits(status: LinLineStatus, wish: Wish) -> bool:
    return status.mode is not None and wish.bit_rate in (None, status.mode.bit_rate)


def _check_agreement(place: LinePlace, status: LinLineStatus, wish: Wish) -> None:
    if wish.bit_rate and wish.bit_rate != status.bit_rate and status.bit_rate:
        raise BadValue(f"{place.address} runs as {mode_text(status)}; leave --bit-rate out")


def _bus(place: LinePlace) -> str:
    return place.info.bus or "no bus"
