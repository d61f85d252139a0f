"""A line that programs share as a source: its channel is emptied by a thread of the recorder's."""

from __future__ import annotations

from contextlib import ExitStack
from typing import TYPE_CHECKING

from canwire.boards.can.modes import ChannelMode, LineStatus, Siblings
from canwire.boards.can.rates import format_rates
from canwire.errors import BadValue
from canwire.hub.bring_up import bring_up
from canwire.hub.connect import connect
from canwire.hub.finding import find_lines
from canwire.hub.wall_clock import epoch_ns
from canwire.hub.wanted_mode import WantedMode
from canwire.logs.batch import records_of_line
from canwire.logs.entry import LogMark, MarkKind
from canwire.logs.recording.hub_source import HubSource
from canwire.logs.recording.shared_lin import SharedLinSource, shared_lin_source
from canwire.values.event import BusEvent, ErrorState, EventKind
from canwire.values.record import load_numpy, record_dtype

if TYPE_CHECKING:
    import numpy

    from canwire.hub.handles.channel import HubChannel

_QUEUE = 32_768  # frames: more than a second of the busiest classic bus
_EVENTS = (EventKind.ERROR, EventKind.STATE, EventKind.OVERRUN)


class SharedSource(HubSource):
    """What a channel hears; times become those of the wall clock by `epoch_ns`."""

    def __init__(
        self, channel: HubChannel, name: str, epoch_ns: int, status: LineStatus | None, closing: ExitStack
    ) -> None:
        super().__init__(name, epoch_ns, closing)
        self._handle = channel
        self._status = status
        self._missed = b""
        if (
            status is not None and not status.running
        ):  # stopped since it was brought up: that stands in the log
            stop = BusEvent(EventKind.STATE, status.time_ns, state=ErrorState.STOPPED)
            self._missed = stop.to_record()

    def take(self, timeout_s: float) -> numpy.ndarray:
        """Frames and events, in the order that they came in."""
        if self._missed:
            heard, self._missed = load_numpy().frombuffer(self._missed, record_dtype()), b""
        else:
            heard = self._handle.receive_array(None, timeout_s)
        found = records_of_line(heard, 0)
        found["time_ns"] += self.epoch_ns
        return found

    def lost(self) -> int:
        return self._handle.status().lost

    def marks(self) -> list[LogMark]:
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
        return marks


def shared_source(
    line: str, hub_address: str | None, wanted: WantedMode, name: str | None
) -> SharedSource | SharedLinSource:
    """The line of that name, of CAN or LIN, running, with what hears all of it; NoSuchBoard, HubError, BadValue."""
    with ExitStack() as closing:
        hub = closing.enter_context(connect(hub_address, name="canwire record"))
        place = find_lines(hub, line)[0]
        if place.info.bus_type == "LIN":
            called = name or place.info.bus or line
            return shared_lin_source(hub, place, wanted, called, closing)
        channel = closing.enter_context(hub.open_channel(place.board.id, place.line))
        events = tuple(int(kind) for kind in _EVENTS)
        channel.set_up(ChannelMode(receive=_QUEUE, transmit=0, siblings=Siblings.EVERY, events=events))

        def refuse_other_rates(status: LineStatus) -> None:
            if not wanted.rates_agree(status.mode):
                raise BadValue(
                    f"{place.address} runs at {format_rates(status.mode)}; leave bit_rate and data_bit_rate out"
                )

        control = bring_up(
            hub, place, lambda status: wanted.mode(place.info.capabilities), refuse_other_rates
        )
        if control is not None:
            control.close()
        status = channel.activate()  # its marks stand before all that is heard
        return SharedSource(channel, name or place.info.bus or line, epoch_ns(hub), status, closing.pop_all())
