"""CAN_BCM sockets: requests to the broadcast manager and its reports."""

from __future__ import annotations

import errno
from collections.abc import Mapping
from typing import TYPE_CHECKING, Protocol

from canwire.socketcan.bcm.message import (
    MOST_FRAMES,
    RX_DELETE,
    RX_FILTER_ID,
    RX_READ,
    RX_RTR_FRAME,
    RX_SETUP,
    TX_DELETE,
    TX_READ,
    TX_SEND,
    TX_SETUP,
    Message,
)
from canwire.socketcan.bcm.sending import Repeated, Sending
from canwire.socketcan.bcm.watching import Watching
from canwire.socketcan.constants import (
    CAN_EFF_FLAG,
    CAN_EFF_MASK,
    CAN_MTU,
    CAN_RTR_FLAG,
    CAN_SFF_MASK,
)
from canwire.socketcan.netlink.proc_files import Wanted
from canwire.socketcan.ports import refuse
from canwire.socketcan.sockets.base import index_of
from canwire.socketcan.sockets.messages import MessageSocket
from canwire.socketcan.wire import HEADER_SIZE, numpy_module, row_of

if TYPE_CHECKING:
    from canwire.socketcan.cyclic import CyclicFrame
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.requests.control import Answered
    from canwire.socketcan.wire import Batch

Key = tuple[int, int, bool]  # identifier word, interface (0: all), FD


class Operation(Protocol):
    """The operation on one identifier: sending or watching."""

    def status(self) -> Message: ...

    def stop(self) -> None: ...


class BcmSocket(MessageSocket):
    """A CAN_BCM socket; its operations end with it."""

    _connected = False
    _index = 0

    def set_option(self, level: int, name: int, value: bytes) -> None:
        raise refuse(errno.EOPNOTSUPP)

    def get_option(self, level: int, name: int) -> bytes:
        raise refuse(errno.EOPNOTSUPP)

    def connect(self, address: bytes) -> None:
        if self._connected:
            raise refuse(errno.EISCONN)
        self._index = index_of(address)
        if self._index:
            self.ports.port(self._index)
        self._sendings: dict[Key, Sending] = {}
        self._watchings: dict[Key, Watching] = {}
        self._heard: list[Port] = []
        self._connected = True
        self.setting.table.bind(self.slot, self._index)

    def sent(self, data: bytes, index: int, waits: bool, asked: Answered) -> None:
        if not self._connected:
            raise refuse(errno.ENOTCONN)
        message = Message.parse(data)
        asked.answer(self._done(message, index or self._index))

    def _done(self, message: Message, index: int) -> int:
        """How many bytes of the request were taken; raises OSError."""
        key = message.can_id, index, message.fd
        if message.opcode == TX_SETUP:
            self._set_up_sending(key, message)
        elif message.opcode == TX_SEND:
            if len(message.frames) != 1:
                raise refuse(errno.EINVAL)
            self.send_frame(self._device(index), message.frames[0])
        elif message.opcode == RX_SETUP:
            self._set_up_watching(key, message)
        elif message.opcode in (TX_DELETE, TX_READ):
            self._end_or_read(key, sends=True, ends=message.opcode == TX_DELETE)
        elif message.opcode in (RX_DELETE, RX_READ):
            self._end_or_read(key, sends=False, ends=message.opcode == RX_DELETE)
        else:
            raise refuse(errno.EINVAL)
        return message.size

    def _device(self, index: int) -> Port:
        if not index:
            raise refuse(errno.ENODEV)
        return self.ports.port(index)

    def _set_up_sending(self, key: Key, message: Message) -> None:
        port = self._device(key[1])
        if not 1 <= len(message.frames) <= MOST_FRAMES:
            raise refuse(errno.EINVAL)
        if key in self._sendings:
            self._sendings[key].change(message)
            return

        def send(frame: bytes) -> None:
            self.send_frame(port, frame)

        def tell(told: Message) -> None:
            self.tell(told.pack(), 0, 0)

        def repeat(frame: bytes, interval_s: float) -> Repeated | None:
            made = port.cyclic.start(row_of(frame, key[1]), interval_s)
            return None if made is None else _Repeated(made, key[1])

        self._sendings[key] = Sending(self.setting.loop, send, tell, message, repeat)

    def _set_up_watching(self, key: Key, message: Message) -> None:
        if len(message.frames) > MOST_FRAMES + 1:
            raise refuse(errno.EINVAL)
        replies = message.flags & RX_RTR_FRAME
        if replies and (len(message.frames) != 1 or not message.can_id & CAN_RTR_FLAG):
            raise refuse(errno.EINVAL)
        if message.flags & RX_FILTER_ID and message.frames:
            message = Message(*(getattr(message, name) for name in _HEAD_FIELDS))
        self._hear(key[1])
        if key in self._watchings:
            self._watchings[key].change(message)
            return

        def send(frame: bytes) -> None:
            for port in self._heard:
                self.send_frame(port, frame)

        def tell(told: Message, stamp_ns: int) -> None:
            self.tell(told.pack(), stamp_ns, key[1] or self._last_index)

        self._watchings[key] = Watching(self.setting.loop, send, tell, message)

    _last_index = 0

    def receive_list(self) -> list[Wanted]:
        if not self._connected:
            return []
        mask = CAN_EFF_FLAG | CAN_RTR_FLAG
        return [
            Wanted(key[1], key[0], mask | (CAN_EFF_MASK if key[0] & CAN_EFF_FLAG else CAN_SFF_MASK), "bcm", 0)
            for key in self._watchings
        ]

    def _hear(self, index: int) -> None:
        for port in [self.ports.port(index)] if index else self.ports.of_all():
            if port not in self._heard:
                self._heard.append(port)
                port.listeners.append(self)

    def _end_or_read(self, key: Key, *, sends: bool, ends: bool) -> None:
        there: Mapping[Key, Operation] = self._sendings
        if not sends:
            there = self._watchings
        operation = there.get(key)
        if operation is None:
            raise refuse(errno.EINVAL)
        if ends:
            operation.stop()
            self._sendings.pop(key, None) if sends else self._watchings.pop(key, None)
        else:
            self.tell(operation.status().pack(), 0, 0 if sends else key[1])

    def take(self, batch: Batch) -> None:
        if not self._watchings:
            return
        ids = list({key[0] for key in self._watchings})
        numpy = numpy_module()
        wanted = numpy.isin(batch.rows["can_id"], numpy.array(ids, "u4"))
        if batch.errors is not None:
            wanted &= ~batch.errors
        for row in batch.rows[wanted]:
            index, size = int(row["interface"]), int(row["length"])
            frame = row.tobytes()[HEADER_SIZE : HEADER_SIZE + size]
            self._last_index = index
            for place in (index, 0):
                watching = self._watchings.get((int(row["can_id"]), place, size != CAN_MTU))
                if watching is not None:
                    watching.take(frame, int(row["stamp_ns"]))

    def interface_lost(self, interface: Interface, error: int) -> None:
        if error == errno.ENODEV:
            self._stop_operations()
        super().interface_lost(interface, error)

    def _stop_operations(self) -> None:
        operations: list[Operation] = [*self._sendings.values(), *self._watchings.values()]
        for operation in operations:
            operation.stop()
        self._sendings.clear()
        self._watchings.clear()

    def ended(self) -> None:
        if self._connected:
            self._stop_operations()
            for port in self._heard:
                port.leave(self)
        self.let_go()


class _Repeated:
    """By the hub."""

    def __init__(self, frame: CyclicFrame, index: int) -> None:
        self._frame = frame
        self._index = index

    def replace(self, frame: bytes) -> bool:
        return self._frame.replace(row_of(frame, self._index))

    def stop(self) -> None:
        self._frame.stop()


_HEAD_FIELDS = ("opcode", "flags", "count", "interval1_s", "interval2_s", "can_id")
