"""The driver's line at the hub: its status, its configuration and its channel."""

from __future__ import annotations

import struct
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, NamedTuple

from canwire import (
    BitTiming,
    BusEvent,
    ChannelMode,
    EventKind,
    FilterMode,
    FilterSetup,
    Frame,
    LineMode,
    LineStatus,
    QueueFull,
)
from canwire.acan.hard_config import HardConfig

if TYPE_CHECKING:
    from canwire import BoardInfo, Control, Event, Hub

KIN = "ACAN"  # ACAN programs may configure a line again that another ACAN program runs, as in the manual
RECEIVE = 1024  # frames and events that wait in this program for the service thread
TRANSMIT = 256  # frames that wait in this program before they enter the queue of the line
CHANNEL = ChannelMode(
    RECEIVE,
    TRANSMIT,
    filter_size=0,
    events=(
        EventKind.INFO,
        EventKind.ERROR,
        EventKind.STATE,
        EventKind.ARBITRATION_LOST,
        EventKind.OVERRUN,
        EventKind.CHANGED,
    ),
    fd=False,
    prioritised=True,
    kin=KIN,
)
_OPEN = FilterSetup(FilterMode.PASS, 0)  # the controller's own acceptance filter is the only one
_RECORD = struct.Struct("<QII")  # time, identifier, info
_LOST, _REMOTE, _EXTENDED = 1 << 20, 1 << 22, 1 << 23  # CANMSGINFO's bits
_DATA_AT = 16
_TIMING = ("BTR0", "BTR1")  # the line computes these from the timing


class Arrival(NamedTuple):
    """A frame or an event; `lost_before` is True if others before it were lost in this program's full queue."""

    what: Frame | BusEvent
    lost_before: bool


class AcanLine:
    """One line of an SJA1000, and this program's channel on it.

    A call that configures, starts or stops the line holds its control for the length of that call. It raises InUse
    while another program holds the control: an ACAN program does so only for a moment, others may keep it.
    """

    def __init__(self, hub: Hub, board: BoardInfo, number: int) -> None:
        self.hub = hub
        self.board = board
        self.number = number
        self._held: Control | None = None
        self._channel = hub.open_channel(board.id, number)
        try:
            self._channel.set_up(CHANNEL)
            self._channel.activate()
        except BaseException:
            self._channel.close()
            raise

    @property
    def name(self) -> str:
        return f"{self.board.hardware_id} {self.board.lines[self.number].name}"

    @property
    def bus(self) -> str:
        return self.board.lines[self.number].bus

    # the line

    def status(self) -> LineStatus:
        return self.hub.line_status(self.board.id, self.number, kin=KIN)

    def registers(self) -> dict[str, int]:
        """The registers that the controller shows at present, by name."""
        return {view.name: view.value for view in self.hub.registers(self.board.id, self.number)}

    def configure(self, config: HardConfig) -> None:
        """Configure the line; it is off the bus afterwards, and keeps its configuration when this program ends.

        Raises InUse if it runs at another rate for programs of another dialect.
        """
        registers = dict(config.registers())
        mode = LineMode(
            BitTiming.from_btr(registers["BTR0"], registers["BTR1"]),
            error_frames=True,
            standard_filter=_OPEN,
            extended_filter=_OPEN,
            note=config.pack(),
            registers=tuple(pair for pair in registers.items() if pair[0] not in _TIMING),
            keeps=True,
            kin=KIN,
        )
        with self._control() as control:
            control.initialise(mode)

    def start(self) -> None:
        """Join the bus with error counters at 0 and empty queues."""
        with self._control() as control:
            control.start(abort_pending=True)

    def recover(self) -> None:
        """Join the bus again after bus-off, also while another program holds the control of the line."""
        self.hub.recover(self.board.id, self.number, abort_pending=True)

    def stop(self) -> None:
        with self._control() as control:
            control.stop()

    # the channel

    def assign(self, event: Event) -> None:
        """Signal this event when something has arrived, or when nothing more can arrive."""
        self._channel.reading.assign(event)

    def receive(self) -> Arrival | None:
        """The oldest frame or event, None if nothing waits; raises HubLost, Unplugged."""
        record = self._channel.receive_record(0)
        return None if record is None else _arrival(record)

    def send(self, frame: Frame, flags: int, priority: int) -> None:
        """Queue a frame; raises QueueFull, which names the obstacle if a real adapter cannot send."""
        try:
            self._channel.send(frame, flags, 0, priority)
        except QueueFull as full:
            raise QueueFull(full.line, full.capacity, self.hub.obstacle(self.board, self.number)) from None

    def wait_for_room(self, timeout: float | None) -> bool:
        return self._channel.writing.wait(timeout)

    def close(self) -> None:
        self._channel.close()

    @contextmanager
    def hold(self) -> Iterator[None]:
        """While entered, no other program configures, starts or stops the line."""
        with self._open_control() as control:
            self._held = control
            try:
                yield
            finally:
                self._held = None

    def _control(self) -> AbstractContextManager[Control]:
        held = self._held
        return self._open_control() if held is None else nullcontext(held)

    def _open_control(self) -> Control:
        return self.hub.open_control(self.board.id, self.number, kin=KIN)


def _arrival(record: bytes) -> Arrival:
    """Decodes one record of 80 bytes with the layout of VCI's CANMSG2."""
    time_ns, identifier, info = _RECORD.unpack_from(record)
    if info & 0xFF:
        return Arrival(BusEvent.from_record(record), False)
    dlc, remote = info >> 16 & 0xF, bool(info & _REMOTE)
    data = b"" if remote else record[_DATA_AT : _DATA_AT + min(dlc, 8)]
    frame = Frame(
        identifier, data, extended=bool(info & _EXTENDED), remote=remote, dlc=dlc, timestamp_ns=time_ns
    )
    return Arrival(frame, bool(info & _LOST))
