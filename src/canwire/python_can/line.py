"""Which line a channel's name means, and how it is brought up beside the programs that use it already.

can0              the first line on that bus that nobody uses; where there is none left, one that others use
HW000001:0        line 0 of the board with that hardware id, shared with whoever else uses it
usb-to-can-fd:1   line 1 of the first board of that kind

Who comes first sets a line up, with everything that it can; the others have to agree with the rates.
"""

from __future__ import annotations

import re
import time
from dataclasses import replace
from typing import NamedTuple

from canwire import (
    BadValue,
    BoardInfo,
    Control,
    ErrorState,
    Feature,
    Hub,
    InUse,
    LineError,
    LineInfo,
    LineStatus,
    NoSuchBoard,
)
from canwire.python_can.wanted import Wanted, at_clock, at_rates_of, line_mode, rates_text

_PATIENCE_S = 2.0  # for whoever has the control of a line, and is about to start it
_LOOK_S = 0.02
_ADDRESS = re.compile(r"(.+):(\d{1,3})", re.DOTALL)


class Place(NamedTuple):
    """A line of a board."""

    board: BoardInfo
    line: int

    @property
    def info(self) -> LineInfo:
        return self.board.lines[self.line]

    @property
    def address(self) -> str:
        return f"{self.board.hardware_id}:{self.line}"


def can_places(hub: Hub) -> list[Place]:
    """Every CAN line there is."""
    boards = hub.boards()
    places = [Place(board, index) for board in boards for index in range(len(board.lines))]
    return [place for place in places if place.info.bus_type == "CAN"]


def set_listening(hub: Hub, place: Place, control: Control, wanted: Wanted) -> None:
    """Have the line only listen, or take part; one that is bus-off begins again."""
    _check_able(place, wanted)
    status = status_of(hub, place)
    mode = status.mode or line_mode(place.info.capabilities, wanted)
    if status.mode is None or mode.listen_only != wanted.listen_only:
        control.initialise(replace(mode, listen_only=wanted.listen_only))
    elif status.running and status.state == ErrorState.BUS_OFF:
        control.stop()
    control.start()


def bring_up(hub: Hub, channel: str, wanted: Wanted) -> tuple[Place, Control | None]:
    """The line that the channel means, running as wanted, and its control if this program has that.

    Raises NoSuchBoard; InUse or BadValue where it runs otherwise, naming who has set it up, and how.
    """
    places = can_places(hub)
    on_bus = [place for place in places if place.info.bus == channel]
    if not on_bus:
        place = _by_address(hub, channel, places)
        _check_able(place, wanted)
        neighbours = [other for other in places if place.info.bus and other.info.bus == place.info.bus]
        return place, _brought_up(hub, place, _as_others(_running(hub, neighbours), wanted))
    return _on_bus(hub, channel, on_bus, wanted)


def status_of(hub: Hub, place: Place) -> LineStatus:
    return hub.line_status(place.board.id, place.line)


def _by_address(hub: Hub, name: str, places: list[Place]) -> Place:
    found = _ADDRESS.fullmatch(name)
    if found:
        board = hub.board(found[1])
        for place in places:
            if place.board.id == board.id and place.line == int(found[2]):
                return place
    there = ", ".join(f"{place.address} (on {place.info.bus or 'no bus'})" for place in places) or "none"
    raise NoSuchBoard(f"no CAN line or bus {name!r}; there are {there}")


def _check_able(place: Place, wanted: Wanted) -> None:
    capabilities = place.info.capabilities
    if capabilities.data is None and (wanted.fd or wanted.data):
        raise BadValue(f"{place.address} ({place.board.kind}) knows classic CAN only; leave fd out")
    if wanted.listen_only and not capabilities.can(Feature.LISTEN_ONLY):
        raise BadValue(f"{place.address} ({place.board.kind}) cannot only listen")


def _on_bus(hub: Hub, bus: str, places: list[Place], wanted: Wanted) -> tuple[Place, Control | None]:
    """The first line there that nobody uses, at the rate of the others; else the least used one of those that run."""
    able = [place for place in places if place.info.capabilities.data is not None or not wanted.fd]
    if not able:
        raise BadValue(f"{bus}: all its lines know classic CAN only; leave fd out")
    running = _running(hub, places)
    for place, status in running:
        _check_rates(place, status, wanted)
    wanted = _as_others(running, wanted)
    for place in able:
        status = status_of(hub, place)
        if status.running or status.channels or status.control_holder:
            continue
        try:
            control = hub.open_control(place.board.id, place.line)
        except InUse:
            continue
        _start(control, place, wanted)
        return place, control
    shared = [(place, status_of(hub, place)) for place in able]
    shared.sort(key=lambda pair: (not pair[1].running, pair[1].channels))
    failure: LineError | BadValue | None = None
    for place, _ in shared:
        try:
            return place, _brought_up(hub, place, wanted)
        except (LineError, BadValue) as error:
            failure = failure or error
    assert failure is not None
    raise failure


def _running(hub: Hub, places: list[Place]) -> list[tuple[Place, LineStatus]]:
    found = [(place, status_of(hub, place)) for place in places]
    return [(place, status) for place, status in found if status.running]


def _as_others(running: list[tuple[Place, LineStatus]], wanted: Wanted) -> Wanted:
    """Rates that are left open are those of the bus."""
    if not wanted.find_rate:
        for _, status in running:
            wanted = at_rates_of(status.mode, wanted)
    return wanted


def _brought_up(hub: Hub, place: Place, wanted: Wanted) -> Control | None:
    """Start the line unless it runs; who starts it has its control."""
    control = _control(hub, place)
    status = status_of(hub, place)
    try:
        if status.running:
            _check_agreement(place, status, wanted)
            return control
        if control is not None:
            _start(control, place, wanted)
            return control
        status = _started_by_somebody(hub, place)
        _check_agreement(place, status, wanted)
    except BaseException:
        if control is not None:
            control.close()
        raise
    return None


def _control(hub: Hub, place: Place) -> Control | None:
    """The line's control if nobody has it."""
    try:
        return hub.open_control(place.board.id, place.line)
    except InUse:
        return None


def _started_by_somebody(hub: Hub, place: Place) -> LineStatus:
    """Whoever has the control is about to start it, or else InUse says who that is."""
    end_s = time.monotonic() + _PATIENCE_S
    while not (status := status_of(hub, place)).running:
        if time.monotonic() >= end_s:
            raise InUse(f"{place.address} does not run, and its control is held by {status.control_holder}")
        time.sleep(_LOOK_S)
    return status


def _start(control: Control, place: Place, wanted: Wanted) -> None:
    try:
        control.initialise(line_mode(place.info.capabilities, wanted))
        control.start()
    except BaseException:
        control.close()
        raise


def _check_rates(place: Place, status: LineStatus, wanted: Wanted) -> None:
    mode = status.mode
    if mode is None or mode.timing is None:
        return
    data = mode.data_timing.bit_rate if mode.data_timing is not None else None
    same_data = wanted.data is None or data is None or wanted.data == data
    if wanted.nominal in (None, mode.timing.bit_rate) and same_data:
        return
    asked = f"{wanted.nominal or mode.timing.bit_rate} bit/s"
    asked += f", {wanted.data} after BRS" if wanted.data else ""
    raise BadValue(
        f"{asked} is not what {_described(place, status)}; leave the bit rates out, or ask for these"
    )


def _check_agreement(place: Place, status: LineStatus, wanted: Wanted) -> None:
    """Of a line that others use, too."""
    _check_rates(place, status, wanted)
    mode = status.mode
    if mode is None:
        return
    asked = [at_clock(timing, place.info.capabilities) for timing in (wanted.timing, wanted.data_timing)]
    if asked[0] not in (None, mode.timing) or asked[1] not in (None, mode.data_timing):
        raise BadValue(f"this bit timing is not what {_described(place, status)}: {mode.timing}")
    if wanted.fd and not mode.long_data:
        raise BadValue(f"there is no CAN FD as {_described(place, status)}, for classic CAN")
    if wanted.fd and wanted.iso_fd != mode.iso_fd:
        raise BadValue(f"the other CAN FD is what {_described(place, status)}, ISO: {mode.iso_fd}")
    if wanted.listen_only != mode.listen_only:
        what = "to listen only" if wanted.listen_only else "to send"
        raise InUse(f"it is not possible {what} while {_described(place, status)}")


def _described(place: Place, status: LineStatus) -> str:
    where = f"{place.address} on {place.info.bus}" if place.info.bus else place.address
    holder = status.control_holder or "a program that has left it"
    return f"{where} runs at: {rates_text(status.mode)}, set by {holder}"
