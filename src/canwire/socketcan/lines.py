"""How an interface starts its line, and a second line that acknowledges.

A kernel's vcan delivers the frames of one program even if no other program receives them. A bus does not: a controller
that is alone on it repeats its frame without end. So an interface that is named after a bus starts a second line if no
other line runs; an interface that is named after a board's line starts only that line.
"""

from __future__ import annotations

from contextlib import ExitStack, nullcontext, suppress
from typing import TYPE_CHECKING

from canwire import (
    BadValue,
    ChannelMode,
    EventKind,
    InUse,
    LineError,
    NoSuchBoard,
    Siblings,
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

if TYPE_CHECKING:
    from canwire import Control, Hub, HubChannel, Lease, LineMode, LinePlace, LineStatus

_RECEIVE, _TRANSMIT = 32_768, 4096  # frames
_EVENTS = tuple(
    map(
        int,
        (EventKind.ERROR, EventKind.STATE, EventKind.ARBITRATION_LOST, EventKind.OVERRUN, EventKind.INFO),
    )
)


def channel_on(
    hub: Hub, target: str, wanted: WantedMode, before: tuple[LinePlace, LineMode | None] | None = None
) -> tuple[LinePlace, HubChannel]:
    """A new channel on the line, which runs. Raises what `line_of` does.

    `before`: the line and the mode that it had at a hub that is back; the same are taken if that is possible.
    """
    place, started = (
        line_of(hub, target, wanted) if before is None else _line_again(hub, target, wanted, *before)
    )
    with started or nullcontext(), ExitStack() as on_failure:
        channel = on_failure.enter_context(hub.open_channel(place.board.id, place.line))
        # who had it running may have left before there was this channel, which keeps it
        if not place.status(hub).running:
            with _joined(hub, place, _at_rates_there(hub, place.info.bus, wanted)) or nullcontext():
                pass
        channel.set_up(
            ChannelMode(_RECEIVE, _TRANSMIT, siblings=Siblings.EVERY, events=_EVENTS, kin="SocketCAN")
        )
        on_failure.pop_all()
    return place, channel


def _line_again(
    hub: Hub, target: str, wanted: WantedMode, place: LinePlace, mode: LineMode | None
) -> tuple[LinePlace, Control | None]:
    wanted = _at_rates_there(hub, place.info.bus, wanted).at_rates_of(mode)
    with suppress(LineError, BadValue, NoSuchBoard):
        if find_lines(hub, place.address)[0].info.bus == place.info.bus:
            return line_of(hub, place.address, wanted)
    return line_of(hub, target, wanted)


def line_of(hub: Hub, target: str, wanted: WantedMode) -> tuple[LinePlace, Control | None]:
    """The running line, and its control if this process started it: close that once there is a channel.

    Raises NoSuchBoard, or InUse or BadValue if the line runs with other settings than wanted.
    """
    places = find_lines(hub, target, "CAN")
    by_bus = places[0].info.bus == target
    wanted = _at_rates_there(hub, places[0].info.bus, wanted)
    if by_bus:
        able = [place for place in places if place.info.capabilities.data is not None]
        places = able or places  # where a bus has lines that know CAN FD, its interface does
        for place in unused_lines(hub, places):
            with suppress(InUse):  # somebody was quicker
                return place, start_line(hub, place, wanted.mode(place.info.capabilities), unused=True)
        there = lines_now(hub, places)
        there.sort(key=lambda pair: pair[1].channels)
        places = [place for place, _ in there] or places
    return _shared(hub, places, wanted)


class Company:
    """A second line that acknowledges, for an interface that is named after a bus on which no other line runs."""

    def __init__(self, hub: Hub, own: LinePlace, target: str) -> None:
        self._hub = hub
        self._own = own
        self._wanted = target == own.info.bus
        self._there: tuple[LinePlace, Lease] | None = None

    def seek(self, wanted: WantedMode) -> None:
        """Start the second line, unless another one runs."""
        if self._there is None and self._wanted:
            self._there = company_for(self._hub, self._own, wanted)

    def leave(self) -> None:
        """Release the second line; a second call has no effect."""
        there, self._there = self._there, None
        if there is not None:
            there[1].close()


def company_for(hub: Hub, own: LinePlace, wanted: WantedMode) -> tuple[LinePlace, Lease] | None:
    """Start another line of the bus while the lease is open; None if one runs already, or if there is no other line."""
    others = [place for place in _on_bus(hub, own.info.bus) if place.address != own.address]
    if not own.info.bus or any(status.running for _, status in lines_now(hub, others)):
        return None
    wanted = _at_rates_there(hub, own.info.bus, wanted)
    fd = own.info.capabilities.data is not None
    others.sort(key=lambda place: (place.info.capabilities.data is None) == fd)
    for place in unused_lines(hub, others):
        with suppress(InUse, LineError, BadValue):
            return place, _kept_running(hub, place, wanted)
    return None


def _kept_running(hub: Hub, place: LinePlace, wanted: WantedMode) -> Lease:
    with start_line(hub, place, wanted.mode(place.info.capabilities), unused=True):
        return hub.keep_settings(place.board.id, place.line)


def _on_bus(hub: Hub, bus: str) -> list[LinePlace]:
    return [place for place in every_line(hub, "CAN") if place.info.bus == bus]


def _at_rates_there(hub: Hub, bus: str, wanted: WantedMode) -> WantedMode:
    """The wanted mode, with the rates of the bus for those that were not requested."""
    places = _on_bus(hub, bus) if bus else []
    return wanted.at_rates_on_bus(status for _, status in lines_now(hub, places))


def _shared(hub: Hub, places: list[LinePlace], wanted: WantedMode) -> tuple[LinePlace, Control | None]:
    failure: LineError | BadValue | None = None
    for place in places:
        try:
            return place, _joined(hub, place, wanted)
        except (LineError, BadValue) as error:
            failure = failure or error
    assert failure is not None
    raise failure


def _joined(hub: Hub, place: LinePlace, wanted: WantedMode) -> Control | None:
    def check(status: LineStatus) -> None:
        if not wanted.rates_agree(status.mode):
            raise BadValue(
                f"{place.address} runs at {format_rates(status.mode)}, {format_setter(status)}; "
                "leave --bit-rate and --data-bit-rate out"
            )

    return bring_up(hub, place, lambda _: wanted.mode(place.info.capabilities), check)
