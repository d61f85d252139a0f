"""CAN_RAW: filtered frames, unchanged."""

from __future__ import annotations

import errno
from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire.socketcan.constants import (
    CAN_MTU,
    CAN_RAW_FD_FRAMES,
    CAN_RAW_LOOPBACK,
    CAN_RAW_XL_FRAMES,
    CANFD_MTU,
    SOL_CAN_RAW,
)
from canwire.socketcan.interfaces import NOT_BOUND, NOT_FRAMES
from canwire.socketcan.netlink.proc_files import Wanted
from canwire.socketcan.outlets import RowOutlet
from canwire.socketcan.ports import refuse
from canwire.socketcan.rings import COLLECTED
from canwire.socketcan.sockets.base import Opened, index_of
from canwire.socketcan.sockets.raw_options import RawOptions
from canwire.socketcan.sockets.stamped import StampedSocket
from canwire.socketcan.wire import numpy_module, received_dtype, row_of, sound

if TYPE_CHECKING:
    import numpy

    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.wire import Batch

    Array = numpy.ndarray

_LATER = 16  # waiting rows below which a waiting bus continues
_KICKS = 64
_MUCH = 64  # frames after which the next check follows immediately


class RawSocket(StampedSocket):
    """A socket that the program has not bound receives nothing and sends to addresses only."""

    def __init__(self, opened: Opened) -> None:
        table, slot = opened.setting.table, opened.slot
        self._hung_up = self._collects = self._hears_all = False
        self._hears_later = 0  # the interface that it is bound to, and that is down
        self._outlet = RowOutlet(opened.ring, opened.end, lambda: table.receive_buffer(slot))
        self._options = RawOptions()
        self._gathering = opened.setting.gathering()
        self._heard: list[Port] = []
        self._held: deque[tuple[int, Array]] = deque()  # sent; their interfaces have no room yet
        self._matches = 0
        super().__init__(opened)

    # what the program asks

    def bind(self, address: bytes) -> None:
        index = index_of(address)
        heard = self._ports_at(index)
        for port in self._heard:
            port.leave(self)
        self._heard = []
        self._hears_later = index if not heard else 0
        self._hears_all = index == 0
        self._hear(heard)
        self.setting.table.bind(self.slot, index)
        if index and heard:
            heard[0].tell_if_down(self)
        elif index:
            self.interface_lost(self.setting.interfaces.by_index[index], errno.ENETDOWN)

    def _ports_at(self, index: int) -> list[Port]:
        """The ports of this interface, 0: of all; empty while it is down, until it is up. Raises OSError."""
        if not index:
            return self.ports.of_all()
        return [] if self.ports.is_down(index) else [self.ports.port(index)]

    def _hear(self, ports: list[Port]) -> None:
        for port in ports:
            if port not in self._heard:
                self._heard.append(port)
                port.listeners.append(self)
                self._apply_loopback(port)

    def boards_changed(self) -> None:
        if self._hears_all or self._hears_later:
            with suppress(OSError):  # the port has said why
                self._hear(self._ports_at(self._hears_later))

    def set_option(self, level: int, name: int, value: bytes) -> None:
        if level != SOL_CAN_RAW:
            raise refuse(errno.EINVAL)
        self._options.set(name, value)
        if name in (CAN_RAW_FD_FRAMES, CAN_RAW_XL_FRAMES):
            self.setting.table.allow_fd(self.slot, self._options.on(CAN_RAW_FD_FRAMES))
        elif name == CAN_RAW_LOOPBACK:
            for port in self._heard:
                self._apply_loopback(port)

    def get_option(self, level: int, name: int) -> bytes:
        if level != SOL_CAN_RAW:
            raise refuse(errno.EINVAL)
        return self._options.get(name)

    def receive_list(self) -> list[Wanted]:
        if not self._heard:
            return []
        index = self.setting.table.bound_to(self.slot)
        return [Wanted(index, *words, "raw", self._matches) for words in self._options.wanted()]

    def _apply_loopback(self, port: Port) -> None:
        if self._options.on(CAN_RAW_LOOPBACK):
            port.silent.discard(self.slot)
        else:
            port.silent.add(self.slot)

    # from the line

    def take(self, batch: Batch) -> None:
        found = self._options.selected(batch, self.slot)
        if found is not None:
            self._matches += len(found)
            self.ports.matches += len(found)
            self.put(found)

    def congested(self) -> bool:
        return self._outlet.congested()

    def interface_lost(self, interface: Interface, error: int) -> None:
        away = self.setting.hub.lost and not self.setting.comes_back
        if self._hears_all and error == errno.ENETDOWN and not away:
            return  # it is bound to none of them, as on Linux (raw_notify)
        row = numpy_module().zeros(1, received_dtype())
        row["error"], row["interface"] = error, interface.index
        self.setting.table.set_error(self.slot, error)
        if self.errors is not None:
            self.errors.gone()
        if error == errno.ENODEV:
            self._heard = [port for port in self._heard if port.interface is not interface]
            if not self._heard:
                self.setting.table.unbind(self.slot)
        self.put(row)

    def put(self, rows: Array) -> None:
        if not self._hung_up:
            self._outlet.put(rows)
            self.rewatch()
            self.told()
        self.setting.stir()

    def wants_writable(self) -> bool:
        return self._outlet.waiting > 0

    def written(self) -> None:
        """The program has read frames: send those that wait."""
        self._outlet.flush()
        self.setting.stir()
        if self._outlet.waiting < _LATER:
            for port in self._heard:
                port.pump()

    # from the program

    def readable(self) -> None:
        messages, self._hung_up = self.arrived(_KICKS)
        if self._hung_up:
            self.setting.loop.forget(self.end.fileno())  # whose end would be reported repeatedly
            self.setting.deserted()
        for message in messages:
            if len(message) > 1:  # else a kick, or nothing
                self._send_past_library(message)
        if self.setting.timed or self._collects:
            self._collect_soon()
        else:
            self._collect()

    def _send_past_library(self, frame: bytes) -> None:
        """Send a frame from fwrite, splice or a plain system call. Failures are counted, since none can be returned."""
        index = self.setting.table.bound_to(self.slot)
        if not index or len(frame) not in (CAN_MTU, CANFD_MTU):
            self.setting.interfaces.drop(index, 1, NOT_FRAMES if index else NOT_BOUND)
            return
        self._send_all(row_of(frame, index))

    def send_to(self, data: bytes, index: int) -> None:
        if self._held:
            raise refuse(errno.ENOBUFS)
        self.ports.port(index)
        rows = row_of(data, index) if len(data) in (CAN_MTU, CANFD_MTU) else None
        if rows is None or not sound(rows).all():
            raise refuse(errno.EINVAL)
        self._send_all(rows)

    def wants_readable(self) -> bool:
        return not self._held

    def rewatch(self) -> None:
        if not self._hung_up:
            super().rewatch()

    @property
    def deserted(self) -> bool:
        return self.over or self._hung_up

    def _collect_soon(self) -> None:
        if not self._collects:
            self._collects = True
            self.setting.loop.soon(self._collect)

    def _collect(self) -> None:
        """Take in what the program has sent, in turns with everything else; a little at a time waits for more."""
        self._collects = False
        if self.over:
            return
        if not self._send_held():
            return
        rows = self.ring.collect(COLLECTED)
        count = len(rows)
        if count:
            self._send_all(rows)
            self.setting.stir()
        if count >= _MUCH or self._held or (self._hung_up and count):
            self._collect_soon()
        elif self._hung_up:
            self.close()
        elif count and self._gathering is not None and (pause_s := self._gathering.pause_s(count)):
            self._collects = True
            self.setting.loop.call_in(pause_s, self._collect)
        elif not self.ring.want_frames():
            self._collect_soon()

    def _send_held(self) -> bool:
        """Send the frames that were kept back; False if there is no room yet: `_collect` is called again then."""
        while self._held:
            index, rows = self._held[0]
            port = self.ports.known(index)
            if port is not None and not port.lost and not port.room():
                self._collects = True
                port.when_room(self._collect)
                return False
            self._held.popleft()
            self._send(index, rows)
        self.rewatch()
        return True

    def _send_all(self, rows: Array) -> None:
        good = sound(rows)
        if not good.all():
            for index in rows["interface"][~good]:
                self.setting.interfaces.drop(int(index), 1, NOT_FRAMES)
            rows = rows[good]
        interfaces = rows["interface"]
        if len(rows) and (interfaces == interfaces[0]).all():
            self._send(int(interfaces[0]), rows)
            return
        for index in numpy_module().unique(interfaces):
            self._send(int(index), rows[interfaces == index])

    def _send(self, index: int, rows: Array) -> None:
        try:
            port = self.ports.port(index)
        except OSError:  # gone since the shim looked
            self.setting.interfaces.drop(index, len(rows))
            return
        if not self._options.on(CAN_RAW_LOOPBACK):
            port.silent.add(self.slot)
        room = port.room()
        self.leaving(port, rows[:room])
        if room < len(rows):
            self._held.append((index, rows[room:].copy()))
        port.send(self.slot, rows[:room])

    def ended(self) -> None:
        for port in self._heard:
            port.leave(self)
            port.silent.discard(self.slot)
        self.ports.forget_stamper(self.slot)
        self._heard = []
        self.let_go()
