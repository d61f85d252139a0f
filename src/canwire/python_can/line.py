"""Which line a channel's name means, and how it is brought up beside the programs that use it already.

can0              the first line on that bus that nobody uses; where there is none left, one that others use
HW000001:0        line 0 of the board with that hardware id, shared with whoever else uses it
usb-to-can-fd:1   line 1 of the first board of that kind

Who comes first sets a line up, with everything that it can; the others have to agree with the rates.
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
    """Every CAN line there is."""
    return every_line(hub, _CAN)


def line_of_channel(hub: Hub, channel: str, wanted: WantedMode) -> tuple[LinePlace, Control | None]:
    """The line that the channel means, running as wanted, and its control if this program has started it.

    Give that back once there is a channel on the line, which then keeps it.
    Raises NoSuchBoard; InUse or BadValue where it runs otherwise, naming who has set it up, and how.
    """
    found = find_lines(hub, channel, _CAN)
    place = found[0]
    if place.info.bus == channel:
        return _on_bus(hub, channel, found, wanted)
    _check_able(place, wanted)
    neighbours = [other for other in can_places(hub) if place.info.bus and other.info.bus == place.info.bus]
    return place, _brought_up(hub, place, _as_others(hub, neighbours, wanted))


def kept_up(hub: Hub, place: LinePlace, wanted: WantedMode) -> LineStatus:
    """The line that this program has a channel on now, brought up once more if who had it running left before that.

    Raises what `line_of_channel` does.
    """
    status = place.status(hub)
    if status.running:
        return status
    neighbours = [other for other in can_places(hub) if place.info.bus and other.info.bus == place.info.bus]
    with _brought_up(hub, place, _as_others(hub, neighbours, wanted)) or nullcontext():
        return place.status(hub)


def set_listening(hub: Hub, place: LinePlace, wanted: WantedMode) -> None:
    """Have the line only listen, or take part; one that is bus-off begins again, whoever has its control.

    Raises InUse where anything else is to be changed while somebody has the control.
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
    """The first line there that nobody uses, at the rate of the others; else the least used one of those that run."""
    able = [place for place in places if place.info.capabilities.data is not None or not wanted.fd]
    if not able:
        raise BadValue(f"{bus}: all its lines know classic CAN only; leave fd out")
    wanted = _as_others(hub, places, wanted)
    for place in unused_lines(hub, able):
        with suppress(InUse, NoSuchBoard, Unplugged):  # somebody was quicker
            return place, start_line(hub, place, wanted.mode(place.info.capabilities))
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
    """One that was set up in such a way, and stopped, goes on as it is."""

    def mode_for(status: LineStatus) -> LineMode | None:
        if status.initialised and status.mode is not None and status.mode.timing is not None:
            with suppress(BadValue, InUse):
                _check_agreement(place, status, wanted)
                return None
        return wanted.mode(place.info.capabilities)

    return bring_up(hub, place, mode_for, lambda status: _check_agreement(place, status, wanted))


def _as_others(hub: Hub, places: list[LinePlace], wanted: WantedMode) -> WantedMode:
    """Rates that are left open are those of the bus."""
    return wanted.at_rates_on_bus(status for _, status in lines_now(hub, places))


def _check_able(place: LinePlace, wanted: WantedMode) -> None:
    capabilities = place.info.capabilities
    if capabilities.data is None and (wanted.fd or wanted.data):
        raise BadValue(f"{place.address} ({place.board.kind}) knows classic CAN only; leave fd out")
    if wanted.listen_only and not capabilities.can(Feature.LISTEN_ONLY):
        raise BadValue(f"{place.address} ({place.board.kind}) cannot only listen")


def _check_rates(place: LinePlace, status: LineStatus, wanted: WantedMode) -> None:
    """A line that has no rate yet, or none for data, agrees with any."""
    mode = status.mode
    if mode is None or mode.timing is None:
        return
    asked = wanted if mode.data_timing is not None else replace(wanted, data_bit_rate=None, data_timing=None)
    if asked.rates_agree(mode) or _as_made(asked, place).rates_agree(mode):
        return
    rates = f"{wanted.nominal or mode.timing.bit_rate} bit/s"
    rates += f", {wanted.data} after BRS" if wanted.data else ""
    raise BadValue(
        f"{rates} is not what {_described(place, status)}; leave the bit rates out, or ask for these"
    )


def _as_made(wanted: WantedMode, place: LinePlace) -> WantedMode:
    """With the rates that this line makes of those asked for: its clock does not divide to all of them."""
    capabilities = place.info.capabilities
    with suppress(BadTiming):
        rate = wanted.bit_rate and capabilities.timing(wanted.bit_rate).bit_rate
        data = wanted.data_bit_rate and capabilities.data_timing(wanted.data_bit_rate).bit_rate
        return replace(wanted, bit_rate=rate, data_bit_rate=data)
    return wanted


def _check_agreement(place: LinePlace, status: LineStatus, wanted: WantedMode) -> None:
    """Of a line that others use, too."""
    _check_rates(place, status, wanted)
    mode = status.mode
    if mode is None:
        return
    asked = wanted.at_clock(place.info.capabilities.clock_hz)
    if asked.timing not in (None, mode.timing) or asked.data_timing not in (None, mode.data_timing):
        raise BadValue(f"this bit timing is not what {_described(place, status)}: {mode.timing}")
    if wanted.fd and not mode.long_data:
        raise BadValue(f"there is no CAN FD as {_described(place, status)}, for classic CAN")
    if wanted.fd and wanted.iso_fd != mode.iso_fd:
        raise BadValue(f"the other CAN FD is what {_described(place, status)}, ISO: {mode.iso_fd}")
    if wanted.listen_only != mode.listen_only:
        what = "to listen only" if wanted.listen_only else "to send"
        raise InUse(f"it is not possible {what} while {_described(place, status)}")


def _described(place: LinePlace, status: LineStatus) -> str:
    where = f"{place.address} on {place.info.bus}" if place.info.bus else place.address
    listening = ", listening only" if status.mode is not None and status.mode.listen_only else ""
    return f"{where} runs at: {format_rates(status.mode)}{listening}, {format_setter(status)}"
