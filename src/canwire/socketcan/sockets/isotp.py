"""CAN_ISOTP sockets: whole messages, over a pair of identifiers."""

from __future__ import annotations

import errno
import struct
from collections import deque
from typing import TYPE_CHECKING

from canwire.socketcan.constants import (
    AF_CAN,
    CAN_EFF_FLAG,
    CAN_EFF_MASK,
    CAN_RTR_FLAG,
    CAN_SFF_MASK,
    CANFD_MTU,
    SOCKADDR_CAN,
    SOL_CAN_ISOTP,
)
from canwire.socketcan.isotp import layout
from canwire.socketcan.isotp.options import (
    LARGEST_PDU,
    SF_BROADCAST,
    WAIT_TX_DONE,
    Options,
)
from canwire.socketcan.isotp.receiver import Receiver
from canwire.socketcan.isotp.sender import Sender, State
from canwire.socketcan.netlink.proc_files import Wanted
from canwire.socketcan.ports import refuse
from canwire.socketcan.sockets.base import Opened
from canwire.socketcan.sockets.messages import MessageSocket

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.requests.control import Answered
    from canwire.socketcan.wire import Batch

_ADDRESS = struct.Struct(SOCKADDR_CAN)
_SHORTEST_ADDRESS = 16
_HEAD = struct.Struct("<IBBBB")


class IsoTpSocket(MessageSocket):
    """Options are set before `bind`, which starts transfers. A message that is being sent survives `close`."""

    def __init__(self, opened: Opened) -> None:
        self._options = Options()
        self._port: Port | None = None
        self._receives = self._sends = 0
        self._sender = Sender(opened.setting.loop, self._put, self._sent)
        self._receiver = Receiver(opened.setting.loop, self._put, self._deliver, self._fail)
        self._waiting: deque[tuple[bytes, Answered]] = deque()
        self._asked: tuple[int, Answered] | None = None  # who waits until a message is out
        super().__init__(opened)

    # what the program asks

    def set_option(self, level: int, name: int, value: bytes) -> None:
        if level != SOL_CAN_ISOTP:
            raise refuse(errno.EINVAL)
        if self._port is not None:
            raise refuse(errno.EISCONN)
        self._options = self._options.changed(name, value)

    def get_option(self, level: int, name: int) -> bytes:
        if level != SOL_CAN_ISOTP:
            raise refuse(errno.EINVAL)
        return self._options.value(name)

    def bind(self, address: bytes) -> None:
        if len(address) < _SHORTEST_ADDRESS:
            raise refuse(errno.EINVAL)
        family, index, receives, sends = _ADDRESS.unpack(address.ljust(_ADDRESS.size, b"\0")[: _ADDRESS.size])
        if family != AF_CAN:
            raise refuse(errno.EINVAL)
        if self._port is not None:
            raise refuse(errno.EINVAL)
        if not index:
            raise refuse(errno.ENODEV)
        self._receives, self._sends = _identifier(receives), _identifier(sends)
        if (self._receives, self._sends) != (receives, sends):
            self._receives = self._sends = 0
            raise refuse(errno.EINVAL)
        if self._receives == self._sends and not self._options.flags & SF_BROADCAST:
            raise refuse(errno.EADDRNOTAVAIL)
        port = self.ports.port(index)
        if self._options.mtu == CANFD_MTU and port.place.info.capabilities.data is None:
            raise refuse(errno.EINVAL)
        self._port = port
        self._sender.options = self._receiver.options = self._options
        port.listeners.append(self)
        self.setting.table.bind(self.slot, index)
        self.setting.table.set_identifiers(self.slot, self._receives, self._sends)
        port.tell_if_down(self)

    def sent(self, data: bytes, index: int, waits: bool, asked: Answered) -> None:
        if self._port is None:
            raise refuse(errno.EADDRNOTAVAIL)
        if self._port.lost:
            raise refuse(errno.ENETDOWN)
        if len(data) > LARGEST_PDU or not self._sender.fits(len(data)):
            raise refuse(errno.EINVAL)
        if self._sender.state is not State.IDLE:
            if not waits:
                raise refuse(errno.EAGAIN)
            self._waiting.append((data, asked))
            return
        self._begin(data, asked)

    def _begin(self, data: bytes, asked: Answered) -> None:
        if self._options.flags & WAIT_TX_DONE:
            self._asked = len(data), asked
        else:
            asked.answer(len(data))
        self._sender.send(data)

    def receive_list(self) -> list[Wanted]:
        if self._port is None:
            return []
        mask = CAN_EFF_FLAG | CAN_RTR_FLAG | (CAN_EFF_MASK if self._receives & CAN_EFF_FLAG else CAN_SFF_MASK)
        return [Wanted(self._port.interface.index, self._receives, mask, "isotp", 0)]

    # what the protocol's two halves do

    def _put(self, data: bytes) -> None:
        assert self._port is not None
        fd = self._options.mtu == CANFD_MTU
        flags = self._options.frame_flags if fd else 0
        frame = _HEAD.pack(self._sends, len(data), flags, 0, 0) + data.ljust(64 if fd else 8, b"\0")
        self.send_frame(self._port, frame)

    def _sent(self, error: int) -> None:
        asked, self._asked = self._asked, None
        if asked is not None:
            asked[1].answer(-error if error else asked[0])
        elif error and self._waiting:
            self._waiting.popleft()[1].answer(-error)  # the next write learns it, as of the kernel's sk_err
        elif error:
            self._fail(error)
        if self._waiting:
            self._begin(*self._waiting.popleft())
        elif self.over:
            self._leave()

    def interface_lost(self, interface: Interface, error: int) -> None:
        self._receiver.stop()
        if self._sender.state is not State.IDLE:
            self._sender.stop()
            self._sent(error)
        super().interface_lost(interface, error)

    def _deliver(self, message: bytes, stamp_ns: int) -> None:
        assert self._port is not None
        self.tell(message, stamp_ns, self._port.interface.index)

    def _fail(self, error: int) -> None:
        assert self._port is not None
        self.setting.table.set_error(self.slot, error)
        self.tell(b"", 0, self._port.interface.index, error)

    # from the line

    def take(self, batch: Batch) -> None:
        own = int((batch.owners == self.slot).sum())
        if own:
            self._sender.confirm(own)
        wanted = (batch.rows["can_id"] == self._receives) & (batch.owners != self.slot)
        if batch.errors is not None:
            wanted &= ~batch.errors
        for row in batch.rows[wanted] if wanted.any() else ():
            self._take_frame(row["data"][: int(row["len"])].tobytes(), int(row["stamp_ns"]))

    def _take_frame(self, frame: bytes, stamp_ns: int) -> None:
        ahead = self._options.extended
        if len(frame) <= ahead or (ahead and frame[0] != self._options.address_heard):
            return
        if frame[ahead] & 0xF0 == layout.FLOW_CONTROL:
            self._sender.flow_control(frame[ahead:])
        elif not self._options.flags & SF_BROADCAST and not self.over:
            self._receiver.take(frame, stamp_ns)

    def ended(self) -> None:
        self._receiver.stop()
        if self._sender.state is State.IDLE:
            self._leave()

    def _leave(self) -> None:
        while self._waiting:
            self._waiting.popleft()[1].answer(-errno.EBADF)
        if self._port is not None:
            self._port.leave(self)
        self.let_go()


def _identifier(word: int) -> int:
    return word & (CAN_EFF_FLAG | CAN_EFF_MASK) if word & CAN_EFF_FLAG else word & CAN_SFF_MASK
