"""Lines of a shared hub by name, and how the commands bring a CAN line to life; lin_line.py does a LIN line.

HW000001:0        line 0 of the board with that hardware id
usb-to-can-fd:1   line 1 of the first board of that kind
can0, lin0        the first line on that bus; to send from, the first one there that nobody configures
"""

from __future__ import annotations

import argparse
import re
import signal
import sys
from contextlib import ExitStack, suppress
from typing import TYPE_CHECKING, NamedTuple

import canwire
from canwire import (
    BadValue,
    BitTiming,
    BoardInfo,
    Capabilities,
    HubError,
    InUse,
    LineInfo,
    LineMode,
    LineStatus,
    NoSuchBoard,
    TimingRange,
)

if TYPE_CHECKING:
    from canwire import Control, Hub

USUAL_BIT_RATE = 500_000
USUAL_DATA_BIT_RATE = 2_000_000
_ADDRESS = re.compile(r"(.+):(\d{1,3})", re.DOTALL)
_VERBS = {"CAN": "`canwire dump` or `canwire send`", "LIN": "`canwire lin dump` or `canwire lin send`"}
_FEWEST_QUANTA = 8, 5  # of a bit in the nominal and in the data phase: values/timing/limits.py


class Place(NamedTuple):
    """A line of a board."""

    board: BoardInfo
    line: int

    @property
    def info(self) -> LineInfo:
        return self.board.lines[self.line]

    @property
    def address(self) -> str:
        """What names it on a command line."""
        return f"{self.board.hardware_id}:{self.line}"


class Rates(NamedTuple):
    """Bit rates asked for in bit/s; None: whatever is usual, or there already."""

    nominal: int | None
    data: int | None


def add_hub_argument(parser: argparse.ArgumentParser) -> None:
    """--hub, as every command has it that uses shared boards."""
    parser.add_argument(
        "--hub", metavar="ADDRESS", help="the hub's socket (default: CANWIRE_HUB, or this user's)"
    )


def add_line_arguments(parser: argparse.ArgumentParser) -> None:
    """LINE, --bit-rate, --data-bit-rate, --hub."""
    parser.add_argument(
        "line", metavar="LINE", help="HW000001:0, usb-to-can-fd:1, or the name of a bus: can0"
    )
    parser.add_argument(
        "--bit-rate",
        type=int,
        metavar="BIT/S",
        help=f"for a line that nobody started (default: {USUAL_BIT_RATE})",
    )
    parser.add_argument(
        "--data-bit-rate",
        type=int,
        metavar="BIT/S",
        help=f"likewise, CAN FD (default: {USUAL_DATA_BIT_RATE})",
    )
    add_hub_argument(parser)


def connected(arguments: argparse.Namespace, verb: str, closing: ExitStack) -> Hub:
    """The shared hub; raises HubError if there is none: boards of this process alone would be nobody's."""
    hub: Hub = closing.enter_context(canwire.connect(arguments.hub, name=f"canwire {verb}"))
    if not hub.address:
        raise HubError(f"no hub is running that `{verb}` could share; `canwire serve` starts one")
    return hub


def find_line(hub: Hub, name: str, *, to_send: bool = False, bus_type: str = "CAN") -> Place:
    """The line of that name; raises NoSuchBoard with the lines there are, BadValue for one of another type."""
    boards = hub.boards()
    places = [Place(board, index) for board in boards for index in range(len(board.lines))]
    on_bus = [place for place in places if name and place.info.bus == name]
    place = on_bus[0] if on_bus else _by_address(hub, name, places)
    there = place.info.bus_type
    if there != bus_type:
        raise BadValue(
            f"{name}: {place.address} is a {there} line; use {_VERBS.get(there, 'something else')}"
        )
    return _unclaimed(hub, on_bus) if on_bus and to_send else place


def _by_address(hub: Hub, name: str, places: list[Place]) -> Place:
    if found := _ADDRESS.fullmatch(name):
        board = hub.board(found[1])
        if int(found[2]) < len(board.lines):
            return Place(board, int(found[2]))
        raise NoSuchBoard(f"{name}: {board.hardware_id} has the lines 0 to {len(board.lines) - 1}")
    there = ", ".join(f"{place.address} (on {place.info.bus or 'no bus'})" for place in places) or "none"
    raise NoSuchBoard(f"no line or bus {name!r}; there are {there}")


def bring_up(hub: Hub, place: Place, rates: Rates, closing: ExitStack) -> None:
    """Start the line unless it runs, and hold its control until `closing`, so that nobody takes it away.

    Raises BadValue if it runs with other rates than those asked for, InUse if somebody else is about to start it.
    """
    status = status_of(hub, place)
    if not status.running:
        try:
            control = closing.enter_context(hub.open_control(place.board.id, place.line))
        except InUse:
            status = status_of(hub, place)
            if not status.running:
                raise
        else:
            _start(control, place, status, rates)
            return
    _check_agreement(place, status, rates)


def status_of(hub: Hub, place: Place) -> LineStatus:
    return hub.line_status(place.board.id, place.line)


def rates_text(mode: LineMode | None) -> str:
    """`500000 bit/s`, with `, 2000000 after BRS` where there is such a phase."""
    if mode is None or mode.timing is None:
        return "no bit rate yet"
    after = f", {mode.data_timing.bit_rate} after BRS" if mode.data_timing is not None else ""
    return f"{mode.timing.bit_rate} bit/s{after}"


def line_mode(capabilities: Capabilities, rates: Rates) -> LineMode:
    """How these commands set a line up: everything it can, errors reported. Raises BadTiming, BadValue."""
    if capabilities.data is None and rates.data is not None:
        raise BadValue(f"--data-bit-rate {rates.data}: this line knows classic CAN only; leave it out")
    nominal_least, data_least = _FEWEST_QUANTA
    timing = _timing(rates.nominal or USUAL_BIT_RATE, capabilities, capabilities.nominal, nominal_least)
    if capabilities.data is None:
        return LineMode(timing, error_frames=True)
    data = _timing(rates.data or USUAL_DATA_BIT_RATE, capabilities, capabilities.data, data_least)
    return LineMode(timing, data, long_data=True, error_frames=True)


def complain(what: str) -> None:
    """One line for people, beside the output."""
    print(f"canwire: {what}", file=sys.stderr, flush=True)


def let_terminate(closing: ExitStack) -> None:
    """SIGTERM ends like Ctrl-C, with the numbers; only a main thread may ask for that."""
    with suppress(ValueError):
        closing.callback(
            signal.signal, signal.SIGTERM, signal.signal(signal.SIGTERM, signal.default_int_handler)
        )


def _unclaimed(hub: Hub, places: list[Place]) -> Place:
    return next((place for place in places if not _holder(hub, place)), places[0])


def _holder(hub: Hub, place: Place) -> str:
    if place.info.lin is not None:
        return hub.lin_status(place.board.id, place.line).control_holder
    return status_of(hub, place).control_holder


def _start(control: Control, place: Place, status: LineStatus, rates: Rates) -> None:
    if not status.initialised or not _agree(status.mode, rates):
        control.initialise(line_mode(place.info.capabilities, rates))
    control.start()


def _agree(mode: LineMode | None, rates: Rates) -> bool:
    if mode is None or mode.timing is None:
        return False
    data = mode.data_timing.bit_rate if mode.data_timing is not None else None
    return rates.nominal in (None, mode.timing.bit_rate) and rates.data in (None, data)


def _check_agreement(place: Place, status: LineStatus, rates: Rates) -> None:
    if not _agree(status.mode, rates):
        holder = f", set by {status.control_holder}" if status.control_holder else ""
        raise BadValue(
            f"{place.address} runs at {rates_text(status.mode)}{holder}; leave --bit-rate and --data-bit-rate out"
        )


def _timing(bit_rate: int, capabilities: Capabilities, registers: TimingRange, quanta_min: int) -> BitTiming:
    limits = registers.limits(quanta_min=quanta_min)
    return BitTiming.for_bit_rate(bit_rate, clock_hz=capabilities.clock_hz, limits=limits)
