"""Which line a channel's name means, and how it is started if other programs may use it already.

can0              the first unused line on that bus; if all are in use, a shared one
HW000001:0        line 0 of the board with that hardware id, shared with other programs
usb-to-can-fd:1   line 1 of the first board of that kind

The first program sets a line up, with all that the line can do; other programs have to ask for the same rates.
"""

from __future__ import annotations

from contextlib import nullcontext, suppress
from dataclasses import replace

from canwire import (
    BadTiming,
    BadValue,
    CanwireError,
    Control,
    Feature,
    Hub,
    InUse,
    LineError,
    LineMode,
    LinePlace,
    LineStatus,
    NoSuchBoard,
    Unplugged,
    WantedMode,
    bring_up,
    every_line,
    find_lines,
    format_rates,
    format_setter,
    lines_now,
    start_line,
    unused_lines,
)

_CAN = "CAN"


def can_places(hub: Hub) -> list[LinePlace]:
    """All CAN lines of the hub."""
    return every_line(hub, _CAN)


def line_of_channel(hub: Hub, channel: str, wanted: WantedMode) -> tuple[LinePlace, Control | None]:
    """The line that the channel means, running as wanted, and its control if this program has started it.

    Close the control once a channel on the line is open, which then keeps the line running.
    Raises NoSuchBoard, or InUse or BadValue if the line runs with other settings; the message names these settings
    and the program that has set them.
    """
    found = find_lines(hub, channel, _CAN)
    place = found[0]
    if place.info.bus == channel:
        return _on_bus(hub, channel, found, wanted)
    _check_able(place, wanted)
    neighbours = [other for other in can_places(hub) if place.info.bus and other.info.bus == place.info.bus]
    return place, _brought_up(hub, place, _as_others(hub, neighbours, wanted))


def line_again(
    hub: Hub, channel: str, wanted: WantedMode, before: LinePlace, mode: LineMode | None
) -> tuple[LinePlace, Control | None]:
    """As `line_of_channel`, after the hub or the board was away: by preference the line that it was before.

    What `wanted` leaves open is as on the bus now, else as in the `mode` from before.
    """
    if mode is not None and mode.timing is not None:
        wanted = replace(wanted, find_rate=False)
    neighbours = [place for place in can_places(hub) if place.info.bus == before.info.bus]
    wanted = _as_others(hub, neighbours if before.info.bus else [], wanted).at_rates_of(mode)
    if any(place.address == before.address for place in neighbours):
        with suppress(LineError, BadValue, NoSuchBoard, Unplugged):
            return line_of_channel(hub, before.address, wanted)
    return line_of_channel(hub, channel, wanted)


def kept_up(hub: Hub, place: LinePlace, wanted: WantedMode) -> LineStatus:
    """The status of a line with a channel of this program. A line that was stopped before the channel is restarted.

    Raises what `line_of_channel` raises.
    """
    status = place.status(hub)
    if status.running:
        return status
    neighbours = [other for other in can_places(hub) if place.info.bus and other.info.bus == place.info.bus]
    with _brought_up(hub, place, _as_others(hub, neighbours, wanted)) or nullcontext():
        return place.status(hub)


def set_listening(hub: Hub, place: LinePlace, wanted: WantedMode) -> None:
    """Make the line only listen, or take part. A line that is bus-off is restarted, whichever program has its control.

    Raises InUse if anything else has to change while another program has the control.
    """
    _check_able(place, wanted)
    status = place.status(hub)
    if status.running and status.mode is not None and status.mode.listen_only == wanted.listen_only:
        hub.recover(place.board.id, place.line)
        return
    with hub.open_control(place.board.id, place.line) as control:
        mode = status.mode or wanted.mode(place.info.capabilities)
        if status.mode is None or mode.listen_only != wanted.listen_only:
            control.initialise(replace(mode, listen_only=wanted.listen_only))
        control.start()


def _on_bus(
    hub: Hub, bus: str, places: list[LinePlace], wanted: WantedMode
) -> tuple[LinePlace, Control | None]:
    """The first unused line on this bus, at the rate of the others; else the running line with the fewest channels."""
    able = [place for place in places if place.info.capabilities.data is not None or not wanted.fd]
    if not able:
        raise BadValue(f"{bus}: all its lines support classic CAN only; leave fd out")
    wanted = _as_others(hub, places, wanted)
    for place in unused_lines(hub, able):
        with suppress(InUse, NoSuchBoard, Unplugged):  # another program was faster
            return place, start_line(hub, place, wanted.mode(place.info.capabilities), unused=True)
    return _shared(hub, able, wanted)


def _shared(hub: Hub, able: list[LinePlace], wanted: WantedMode) -> tuple[LinePlace, Control | None]:
    shared = lines_now(hub, able)
    shared.sort(key=lambda pair: (not pair[1].running, pair[1].channels))
    failure: CanwireError = NoSuchBoard(f"{able[0].info.bus}: all its boards have just been pulled out")
    for place, _ in shared:
        try:
            return place, _brought_up(hub, place, wanted)
        except (NoSuchBoard, Unplugged):
            continue
        except (LineError, BadValue) as error:
            failure = error if isinstance(failure, NoSuchBoard) else failure
    raise failure


def _brought_up(hub: Hub, place: LinePlace, wanted: WantedMode) -> Control | None:
    """Start a line. A stopped line that already has such settings keeps them."""

    def mode_for(status: LineStatus) -> LineMode | None:
        if status.initialised and status.mode is not None and status.mode.timing is not None:
            with suppress(BadValue, InUse):
                _check_agreement(place, status, wanted)
                return None
        return wanted.mode(place.info.capabilities)

    return bring_up(hub, place, mode_for, lambda status: _check_agreement(place, status, wanted))


def _as_others(hub: Hub, places: list[LinePlace], wanted: WantedMode) -> WantedMode:
    """The same, with the rates of the bus for those that are left out."""
    return wanted.at_rates_on_bus(status for _, status in lines_now(hub, places))


def _check_able(place: LinePlace, wanted: WantedMode) -> None:
    capabilities = place.info.capabilities
    if capabilities.data is None and (wanted.fd or wanted.data):
        raise BadValue(f"{place.address} ({place.board.kind}) supports classic CAN only; leave fd out")
    if wanted.listen_only and not capabilities.can(Feature.LISTEN_ONLY):
        raise BadValue(f"{place.address} ({place.board.kind}) has no listen-only mode")


def _check_rates(place: LinePlace, status: LineStatus, wanted: WantedMode) -> None:
    """Any rate agrees with a line that has none yet; any data rate with one that has none for data."""
    mode = status.mode
    if mode is None or mode.timing is None:
        return
    asked = wanted if mode.data_timing is not None else replace(wanted, data_bit_rate=None, data_timing=None)
    if asked.rates_agree(mode) or _as_made(asked, place).rates_agree(mode):
        return
    rates = f"{wanted.nominal or mode.timing.bit_rate} bit/s"
    rates += f", {wanted.data} after BRS" if wanted.data else ""
    raise BadValue(
        f"{_described(place, status)}, not at {rates}; leave the bit rates out, or ask for the same"
    )


def _as_made(wanted: WantedMode, place: LinePlace) -> WantedMode:
    """The same with the rates that this line can have: its clock may not divide to the requested ones."""
    capabilities = place.info.capabilities
    with suppress(BadTiming):
        rate = wanted.bit_rate and capabilities.timing(wanted.bit_rate).bit_rate
        data = wanted.data_bit_rate and capabilities.data_timing(wanted.data_bit_rate).bit_rate
        return replace(wanted, bit_rate=rate, data_bit_rate=data)
    return wanted


def _check_agreement(place: LinePlace, status: LineStatus, wanted: WantedMode) -> None:
    """Raise BadValue or InUse if a line that other programs use runs with other settings."""
    _check_rates(place, status, wanted)
    mode = status.mode
    if mode is None:
        return
    asked = wanted.at_clock(place.info.capabilities.clock_hz)
    if asked.timing not in (None, mode.timing) or asked.data_timing not in (None, mode.data_timing):
        raise BadValue(f"{_described(place, status)}, with another bit timing: {mode.timing}")
    if wanted.fd and not mode.long_data:
        raise BadValue(f"{_described(place, status)}, for classic CAN; leave fd out")
    if wanted.fd and wanted.iso_fd != mode.iso_fd:
        raise BadValue(f"{_described(place, status)}, with the other form of CAN FD, ISO: {mode.iso_fd}")
    if wanted.listen_only != mode.listen_only:
        what = "only listens" if wanted.listen_only else "sends"
        raise InUse(f"a bus that {what} is not possible while {_described(place, status)}")


def _described(place: LinePlace, status: LineStatus) -> str:
    where = f"{place.address} on {place.info.bus}" if place.info.bus else place.address
    listening = ", listening only" if status.mode is not None and status.mode.listen_only else ""
    return f"{where} runs at {format_rates(status.mode)}{listening}, {format_setter(status)}"
