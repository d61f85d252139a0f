"""One interface in use: a channel on its line, whose received frames go to sockets, and the frames that these send."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

from canwire import CanwireError, ErrorState, EventKind, HubError
from canwire.socketcan.cyclic import CyclicFrames
from canwire.socketcan.echoes import Echoes
from canwire.socketcan.error_frames import put_error_frames
from canwire.socketcan.interfaces import FULL, WENT
from canwire.socketcan.lines import Company, channel_on
from canwire.socketcan.loop import READABLE
from canwire.socketcan.netlink.restarting import Restarting
from canwire.socketcan.sockets.line_room import LineRoom
from canwire.socketcan.table import GONE, OFF, UP
from canwire.socketcan.wire import (
    LOCAL,
    SELF_RECEPTION,
    TYPE_MASK,
    Batch,
    frames_received,
    numpy_module,
    records_to_send,
)

if TYPE_CHECKING:
    from collections.abc import Callable

    import numpy

    from canwire import HubChannel, LinePlace
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.listener import Listener, Tap
    from canwire.socketcan.setting import Setting

    Array = numpy.ndarray

_AT_ONCE = 2048
_MUCH = 64  # frames after which the next check follows immediately
_LOOK_S = 0.02


class Port:
    """Opens the line immediately; raises HubError, LineError, BadValue if that fails."""

    def __init__(self, setting: Setting, interface: Interface, on_lost: Callable[[Port], object]) -> None:
        self.interface = interface
        self.lost = self._pumps = False
        self.heard = 0  # frames, errors included
        self._on_lost = on_lost
        self.listeners: list[Listener] = []
        self.taps: set[Tap] = set()
        self.stampers: dict[int, Callable[[Array], object]] = {}  # by slot: called for its frames on the bus
        self.silent: set[int] = set()  # slots whose frames are not looped back to any socket of this server
        self._setting = setting
        self._loop = setting.loop
        self._echoes = Echoes()
        self._gathering = setting.gathering()
        wanted = interface.wanted or setting.wanted
        self._use(*channel_on(setting.hub, interface.target, wanted))
        self.cyclic = CyclicFrames(setting.hub, self.place)
        self.pump()

    def open_again(self) -> None:
        """With a hub that is back; raises what the constructor raises, and is still lost then."""
        setting, interface = self._setting, self.interface
        wanted = interface.wanted or setting.wanted
        self._use(*channel_on(setting.hub, interface.target, wanted, (self.place, self._mode)))
        self.lost, self._echoes = False, Echoes()
        self.cyclic.move(setting.hub, self.place, setting)
        self.pump()

    def _use(self, place: LinePlace, channel: HubChannel) -> None:
        setting, interface = self._setting, self.interface
        self.place, self._channel = place, channel
        self.company = Company(setting.hub, self.place, interface.target)
        self.company.seek(interface.wanted or setting.wanted)
        self.restarting = Restarting(setting, interface, self.place, self._restarted)
        self._reading, self._writing = self._channel.reading, self._channel.writing
        self._loop.watch(self._reading.descriptor.fileno(), READABLE, self._rung)
        self._room = LineRoom(
            setting,
            interface,
            self._writing,
            lambda: setting.hub.line_status(self.place.board.id, self.place.line),
        )
        status = self._channel.activate()  # it may have been stopped since it was brought up
        self._mode = status.mode
        setting.interfaces.show(interface, UP if status.running else 0)

    # receiving

    def pump(self) -> None:
        """Pass received frames on; if there are more, continue in the loop's next turn."""
        if self._pumps:
            return
        self._pumps = True
        self._loop.soon(self._turn)

    def _rung(self, _: int) -> None:
        self._reading.descriptor.clear()
        if self._setting.timed:  # whatever else is there at this time comes first
            self.pump()
        elif not self._pumps:
            self._turn()

    def _turn(self) -> None:
        self._pumps = False
        if self._setting.fast and any(listener.congested() for listener in self.listeners):
            self._loop.call_in(_LOOK_S, self.pump)  # earlier if a reader makes room
            return
        try:
            records = self._channel.receive_array(_AT_ONCE)
        except CanwireError as error:
            self._lose(error)
            return
        if len(records):
            self._hand_on(records)
        if len(records) >= _MUCH:
            self.pump()
            return
        pause_s = (
            self._gathering.pause_s(len(records)) if self._gathering is not None and len(records) else 0.0
        )
        if pause_s:
            self._pumps = True
            self._loop.call_in(pause_s, self._turn)
        elif not self.lost:
            self._reading.ring.arm()
            if len(records) and self._channel.over:  # it rang for frames and for its end at the same time
                self.pump()

    def _hand_on(self, records: Array) -> None:
        was_up, up = self._follow(records)
        self.heard += len(records)
        batch = self._batch_of(records)
        for listener in list(self.listeners):
            listener.take(batch)
        if was_up and not up:
            self._tell_lost(errno.ENETDOWN)

    def _follow(self, records: Array) -> tuple[bool, bool]:
        """The interface is up while its line runs; whether it was, and whether it is now."""
        was_up = bool(self.interface.flags & UP)
        started_or_stopped = (records["info"] & TYPE_MASK == EventKind.INFO).any()
        # down: STARTED may have been lost with a full queue, and then anything tells that the line runs again
        up = self._runs() if started_or_stopped or not was_up else was_up
        if up != was_up:
            self._setting.interfaces.show(self.interface, UP if up else 0)
        return was_up, up

    def _batch_of(self, records: Array) -> Batch:
        owners = self._echoes.owners(records)
        for slot, call in list(self.stampers.items()):
            own = owners == slot
            if own.any():
                call(self._rows_of(records[own]))
        errors: Array = records["info"] & TYPE_MASK != 0
        if errors.any():
            rows = self._rows_of(records)
            kept = put_error_frames(records, rows, errors, self._show_carrier)
            rows, owners, errors = rows[kept], owners[kept], errors[kept]
            return Batch(lambda: rows, owners, errors)
        if self.silent:
            heard = ~numpy_module().isin(owners, list(self.silent))
            return Batch(lambda: self._rows_of(records[heard]), owners[heard], None)
        return Batch(lambda: self._rows_of(records), owners, None)

    def _rows_of(self, records: Array) -> Array:
        rows = frames_received(records, self.interface.index, self._setting.epoch_ns)
        rows["flags"] = (records["info"] & SELF_RECEPTION != 0) * LOCAL
        return rows

    def _show_carrier(self, state: ErrorState) -> None:
        """IFF_RUNNING follows bus-off, as with the kernel's drivers."""
        off = OFF if state is ErrorState.BUS_OFF else 0
        if off and not self.interface.flags & OFF:
            self.restarting.bus_off()
        self._setting.interfaces.show(self.interface, self.interface.flags & ~OFF | off)

    def _restarted(self, batch: Batch) -> None:
        """The line has left bus-off, and an error frame says so."""
        self._show_carrier(ErrorState.ERROR_ACTIVE)
        for listener in list(self.listeners):
            listener.take(batch)

    def _runs(self) -> bool:
        """True if the line runs, by its status: the state in a STARTED event is the previous one."""
        try:
            return self.place.status(self._setting.hub).running
        except HubError:
            return False

    # sending

    def room(self) -> int:
        """The number of frames that can be sent now."""
        return 0 if self.lost else int(self._writing.ring.free())

    def send(self, slot: int, rows: Array) -> None:
        """Queue rows of `sent_dtype`; those that do not fit are dropped and counted."""
        room = self.room()
        self.drop(len(rows) - min(room, len(rows)), FULL)
        rows = rows[:room]
        if not len(rows):
            return
        records = records_to_send(rows)
        try:
            self._channel.send_array(records)
        except CanwireError as error:
            self.drop(len(rows))
            self._lose(error)
            return
        self._echoes.sent(slot, records, rows)
        for tap in self.taps:
            tap.going(self.interface, rows)

    def drop(self, count: int, why: str = WENT) -> None:
        """Count this many frames that cannot be sent."""
        self._setting.interfaces.drop(self.interface.index, count, why)

    def when_room(self, call: Callable[[], object]) -> None:
        """Call this once there is room for more, or the interface is lost."""
        self._room.wait(call)

    @property
    def sent(self) -> int:
        """The number of frames that the line has accepted so far."""
        return 0 if self.lost else int(self._writing.ring.taken)

    @property
    def pending(self) -> int:
        """The number of frames that have not come back from the bus, and still may."""
        if self.lost or not self._echoes.outstanding:
            return 0
        try:
            return min(self._echoes.outstanding, self._channel.status().pending)
        except CanwireError as error:
            self._lose(error)
            return 0

    # the end

    def tell_if_down(self, listener: Listener) -> None:
        """A socket that binds to an interface that is down gets the error from its next read, as on Linux."""
        if not self.interface.flags & UP:
            listener.interface_lost(self.interface, errno.ENETDOWN)

    def leave(self, listener: Listener) -> None:
        """A second time does nothing."""
        if listener in self.listeners:
            self.listeners.remove(listener)

    def _lose(self, error: CanwireError) -> None:
        if self.lost:
            return
        self._setting.say(f"{self.interface.name}: {error}")
        hub_gone = self._setting.hub.lost
        self.drop(self._echoes.outstanding)
        waiting = self._room.end()
        self.close()
        if hub_gone:
            self._setting.interfaces.take_down(self.interface)
            self._tell_lost(errno.ENETDOWN)
            self._setting.hub_gone()
        if not hub_gone:
            self.vanish()
        elif not self._setting.comes_back:
            self._on_lost(self)
        for call in waiting:
            self._loop.soon(call)

    def vanish(self) -> None:
        """The line does not exist any more."""
        self._setting.interfaces.show(self.interface, GONE)
        self._tell_lost(errno.ENODEV)
        self._on_lost(self)

    def _tell_lost(self, error: int) -> None:
        for listener in list(self.listeners):
            listener.interface_lost(self.interface, error)

    def close(self) -> None:
        """A second time does nothing."""
        if self.lost:
            return
        self.lost = True
        self.restarting.stop()
        self._loop.forget(self._reading.descriptor.fileno())
        self._room.end()
        self._channel.close()
        self.company.leave()
