"""A shared CAN line as a source: a thread of the recorder empties its channel."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire.boards.can.modes import ChannelMode, LineStatus, Siblings
from canwire.boards.can.rates import format_rates
from canwire.errors import BadValue, NoSuchBoard
from canwire.hub.bring_up import bring_up
from canwire.hub.connect import connect
from canwire.hub.finding import every_line, find_lines
from canwire.hub.wall_clock import epoch_ns
from canwire.hub.wanted_mode import WantedMode
from canwire.logs.batch import records_of_line
from canwire.logs.entry import LogEntry, LogMark, MarkKind
from canwire.logs.recording.hub_source import HubSource
from canwire.logs.recording.shared_lin import SharedLinSource, shared_lin_source
from canwire.values.event import BusEvent, ErrorState, EventKind
from canwire.values.record import load_numpy, record_dtype

if TYPE_CHECKING:
    import numpy

    from canwire.hub.finding import LinePlace
    from canwire.hub.handles.channel import HubChannel
    from canwire.hub.handles.hub import Hub

ANY = "any"
_QUEUE = 32_768  # frames: more than a second of the busiest classic bus
_EVENTS = (EventKind.ERROR, EventKind.STATE, EventKind.OVERRUN)


class SharedSource(HubSource):
    """The frames and events that a channel receives; `epoch_ns` converts times to the wall clock."""

    def __init__(
        self, channel: HubChannel, name: str, epoch_ns: int, status: LineStatus | None, closing: ExitStack
    ) -> None:
        super().__init__(channel, name, epoch_ns, closing)
        self._channel = channel
        self._status = status
        self._missed = b""
        if status is not None and not status.running:  # stopped since it was started: the log says so
            stop = BusEvent(EventKind.STATE, status.time_ns, state=ErrorState.STOPPED)
            self._missed = stop.to_record()

    def take(self, timeout_s: float) -> numpy.ndarray:
        """Return frames and events in the order of reception."""
        if self._missed:
            heard, self._missed = load_numpy().frombuffer(self._missed, record_dtype()), b""
        else:
            heard = self._channel.receive_array(None, timeout_s)
        found = records_of_line(heard, 0)
        found["time_ns"] += self.epoch_ns
        return found

    def marks(self) -> list[LogEntry]:
        if self._status is None:
            return []
        now_ns = self.epoch_ns + self._status.time_ns
        marks = [LogMark(MarkKind.CLOCK, now_ns, text="hub")]
        mode = self._status.mode
        if mode is not None and mode.timing is not None:
            data = mode.data_timing.bit_rate if mode.data_timing is not None else 0
            marks.append(
                LogMark(MarkKind.BIT_RATE, now_ns, bit_rate=mode.timing.bit_rate, data_bit_rate=data)
            )
        return self._entries(marks)


def shared_sources(
    lines: Sequence[str], hub_address: str | None, wanted: WantedMode, name: str | None, closing: ExitStack
) -> list[SharedSource | SharedLinSource]:
    """Sources on these CAN or LIN lines, which are started; "any" is a line of every bus.

    For several lines the wanted rates are those of CAN lines. `closing` gets their resources and the hub's connection.
    Raises NoSuchBoard, HubError, BadValue.
    """
    hub = closing.enter_context(connect(hub_address, name="canwire record"))
    places = _places(hub, lines)
    if name is not None and len(places) > 1:
        raise BadValue(f"channel {name!r}: for one line; these {len(places)} have the names of their buses")
    sources: list[SharedSource | SharedLinSource] = []
    epoch = epoch_ns(hub)  # the same one for all: it is measured, and sorts the lines' frames
    for called, place in places:
        if place.info.bus_type == "LIN":
            of_lin = WantedMode(None, None) if len(places) > 1 else wanted
            source: SharedSource | SharedLinSource = shared_lin_source(
                hub, place, of_lin, name or called, epoch
            )
        else:
            source = _shared_source(hub, place, wanted, name or called, epoch)
        closing.callback(source.close)
        sources.append(source)
    return sources


def _places(hub: Hub, lines: Sequence[str]) -> list[tuple[str, LinePlace]]:
    """Return each line once, with its name in the log."""
    found: dict[str, tuple[str, LinePlace]] = {}
    for line in lines:
        if line == ANY:
            buses: dict[str, LinePlace] = {}
            for place in every_line(hub):
                buses.setdefault(place.info.bus or place.address, place)
            those = list(buses.values())
        else:
            those = find_lines(hub, line)[:1]
        for place in those:
            found.setdefault(place.address, (place.info.bus or place.address, place))
    if not found:
        raise NoSuchBoard("any: the hub has no line; `canwire plug` puts a board in")
    return list(found.values())


def _shared_source(hub: Hub, place: LinePlace, wanted: WantedMode, name: str, epoch: int) -> SharedSource:
    """Return a source on this line, which is started if it does not run."""

    def refuse_other_rates(status: LineStatus) -> None:
        if not wanted.rates_agree(status.mode):
            raise BadValue(
                f"{place.address} runs at {format_rates(status.mode)}; leave bit_rate and data_bit_rate out"
            )

    with ExitStack() as closing:
        channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
        events = tuple(int(kind) for kind in _EVENTS)
        channel.set_up(ChannelMode(receive=_QUEUE, transmit=0, siblings=Siblings.EVERY, events=events))
        control = bring_up(
            hub, place, lambda status: wanted.mode(place.info.capabilities), refuse_other_rates
        )
        if control is not None:
            control.close()
        status = channel.activate()  # its marks stand before all that is heard
        source = SharedSource(channel, name, epoch, status, closing.pop_all())
        source.address = place.address
        return source
