"""A dongle's CAN side over a line of the hub, on a separate board that only the dongle sets up.

Other programs may listen on that line as on any other.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from canwire import (
    SELF_RECEPTION,
    SINGLE_SHOT,
    BadTiming,
    BitTiming,
    BusEvent,
    ChannelMode,
    Event,
    EventKind,
    FilterMode,
    FilterSetup,
    Frame,
    LineMode,
    NoSuchBoard,
)
from canwire.slcan.can_side import ACCEPT_ALL, TRANSMIT_QUEUE, Setup

if TYPE_CHECKING:
    from canwire import BoardInfo, Hub
    from canwire.slcan.dialects import Dialect

RECEIVE = 8192  # frames that the hub holds for us: about a second of the busiest bus
_EVENTS = (
    EventKind.ERROR,
    EventKind.STATE,
    EventKind.ARBITRATION_LOST,
    EventKind.ABORTED,
    EventKind.OVERRUN,
)
_BATCH = 256
_KIN = "CANBUS dongle"
_MAILBOXES = 4  # room for frames given up that the hub has not taken out yet
_OPEN = FilterSetup(FilterMode.PASS, 0)  # the controller's own acceptance filter is the only one


def plug_dongle(hub: Hub, dialect: Dialect, bus: str) -> BoardInfo:
    """Plug in a board for a dongle of this dialect, with its CAN lines on this bus; raises NoSuchBoard.

    The board is removed when this connection ends, even if the program is killed.
    """
    why: NoSuchBoard | None = None
    for kind in dialect.kinds:
        try:
            return hub.plug(kind, buses=(bus, bus) if dialect.fd else (bus,), temporary=True)
        except NoSuchBoard as error:
            if "no bus" in str(error):
                raise
            why = why or error
    raise why or NoSuchBoard(f"{dialect.name}: no board is known for it")


class HubPort:
    """The CanSide on line 0 of a board, whose control it holds until `end`; `event` is signalled when `poll` has data.

    Raises InUse if another program has the control of that line.
    """

    def __init__(self, hub: Hub, board: BoardInfo, line: int = 0) -> None:
        self.hub = hub
        self.board = board
        self.event = Event()
        self._capabilities = board.lines[line].capabilities
        self._opened = False
        self._control = hub.open_control(board.id, line, kin=_KIN)
        self._frames = hub.open_channel(board.id, line)
        self._happenings = hub.open_channel(board.id, line)
        self._frames.set_up(
            ChannelMode(
                RECEIVE,
                TRANSMIT_QUEUE + _MAILBOXES,
                filter_size=0,
                fd=self._capabilities.data is not None,
                kin=_KIN,
            )
        )
        self._happenings.set_up(
            ChannelMode(RECEIVE, 0, filter_size=0, frames=False, events=tuple(map(int, _EVENTS)), kin=_KIN)
        )
        for channel in (self._frames, self._happenings):
            channel.reading.assign(self.event)
            channel.activate()

    @property
    def now_ns(self) -> Callable[[], int]:
        """The hub's clock, which stamps frames."""
        return self.hub.now_ns

    def open(self, setup: Setup) -> None:
        self._control.initialise(self._mode(setup))
        self._control.start()
        self._opened = True

    def close(self) -> None:
        if self._opened:
            self._opened = False
            self._control.reset()
            self._frames.cancel()
            self.poll_all()

    def send(self, frame: Frame, *, single_shot: bool = False) -> None:
        self._frames.send(frame, SELF_RECEPTION | (SINGLE_SHOT if single_shot else 0))

    def poll(self) -> Sequence[Frame]:
        return self._frames.receive_many(_BATCH)

    def events(self) -> Sequence[BusEvent]:
        found: list[BusEvent] = []
        while (record := self._happenings.receive_record()) is not None:
            found.append(BusEvent.from_record(record))
        return found

    def count_refused(self, count: int) -> None:
        self._frames.count_refused(count)

    def lost(self) -> int:
        return self._frames.reading.ring.lost

    def poll_all(self) -> None:
        """Discard all frames and events."""
        while self.poll():
            pass
        self.events()

    def end(self) -> None:
        """Release the line; a second call has no effect."""
        for lease in (self._frames, self._happenings, self._control):
            lease.close()
        self.event.close()

    def _mode(self, setup: Setup) -> LineMode:
        capabilities = self._capabilities
        registers: tuple[tuple[str, int], ...] = ()
        if capabilities.data is None:
            registers = tuple((f"ACR{k}", value) for k, value in enumerate(setup.code))
            registers += tuple((f"AMR{k}", value) for k, value in enumerate(setup.mask))
        elif (setup.code, setup.mask) != ACCEPT_ALL:
            raise BadTiming(f"{self.board.kind}: no acceptance registers")
        data = None
        if setup.data_timing is not None and capabilities.data is not None:
            data = _converted(setup.data_timing, capabilities.clock_hz, capabilities.data_timing)
        return LineMode(
            _converted(setup.timing, capabilities.clock_hz, capabilities.timing),
            data,
            long_data=data is not None,
            error_frames=True,
            listen_only=setup.listen_only,
            standard_filter=_OPEN,
            extended_filter=_OPEN,
            registers=registers,
            kin=_KIN,
        )


def _converted(timing: BitTiming, clock_hz: int, made: Callable[[int, float], BitTiming]) -> BitTiming:
    """The same rate and sample point by the board's clock."""
    return timing if timing.clock_hz == clock_hz else made(timing.bit_rate, timing.sample_point)
