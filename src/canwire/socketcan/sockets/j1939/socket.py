"""CAN_J1939 sockets: messages between names or addresses, of up to 117,440,505 bytes.

Source: Linux' Documentation/networking/j1939.rst, linux/can/j1939.h.
"""

from __future__ import annotations

import errno
import struct
from collections import deque
from typing import TYPE_CHECKING

from canwire.socketcan.constants import SOL_CAN_J1939
from canwire.socketcan.j1939.codes import LARGEST_ETP, LARGEST_TP, RESERVED
from canwire.socketcan.j1939.endpoint import Endpoint, checked_priority, parse_filters
from canwire.socketcan.j1939.message import (
    LARGEST_PGN,
    LARGEST_SINGLE,
    NO_ADDRESS,
    NO_PGN,
    Message,
)
from canwire.socketcan.j1939.outbox import Outbox
from canwire.socketcan.j1939.reports import Report
from canwire.socketcan.ports import refuse
from canwire.socketcan.sockets.base import Opened
from canwire.socketcan.sockets.error_queue import Queued
from canwire.socketcan.sockets.j1939.bus import J1939Bus, J1939Buses
from canwire.socketcan.sockets.j1939.errors import Reports
from canwire.socketcan.sockets.j1939.names import Name, parsed
from canwire.socketcan.sockets.j1939.rests import HAS_REST, LARGEST_IN_PAIR, Rests
from canwire.socketcan.sockets.messages import MessageSocket
from canwire.socketcan.table import UP
from canwire.socketcan.wire import LOCAL

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.requests.control import Answered

FILTER, PROMISCUOUS, PRIORITY, ERROR_QUEUE = range(1, 5)
MORE_FOLLOWS = 0x100  # of a request to send: these bytes are not all
ABOUT = struct.Struct("<QQIBBBB")  # shim/shim.h, struct about
_SEND_BUFFER = 400_000  # bytes: several of the longest messages in the pair
_INT = struct.Struct("<i")
_MOST_PENDING, _MOST_QUEUED = 256, 8192  # messages: where a write waits, and where one fails that cannot


class J1939Socket(MessageSocket):
    """A CAN_J1939 socket. Messages that are being sent are completed after `close`."""

    def __init__(self, opened: Opened, buses: J1939Buses) -> None:
        table, slot = opened.setting.table, opened.slot
        self.endpoint = Endpoint(lambda: table.broadcasts(slot), self._deliver, self._report)
        self._buses = buses
        self._bus: J1939Bus | None = None
        self._outbox: Outbox | None = None
        self._errors: Reports | None = None
        self._begun = bytearray()  # of a message that comes in parts
        self._waiting: deque[tuple[Message, int, Answered]] = deque()
        self._left = False
        self.rests = Rests()
        super().__init__(opened)
        self.end.setsockopt(1, 7, _SEND_BUFFER)  # SO_SNDBUF, which the kernel doubles

    # what the program asks

    def bind(self, address: bytes) -> None:
        name = parsed(address)
        if self._bus is not None and self._bus.port.interface.index != name.interface:
            raise refuse(errno.EINVAL)
        bus = self._bus or self._joined(name.interface)
        bus.network.addresses.leave(self.endpoint.name, self.endpoint.address)
        if name.pgn <= LARGEST_PGN:
            self.endpoint.pgn_heard = name.pgn
        self.endpoint.name, self.endpoint.address = name.name, name.address
        bus.network.addresses.use(name.name, name.address)

    def _joined(self, index: int) -> J1939Bus:
        port = self.ports.port(index)
        if not port.interface.flags & UP:
            raise refuse(errno.ENETDOWN)
        bus = self._bus = self._buses.of(port)
        bus.join(self)
        bus.network.addresses.use(self.endpoint.name, self.endpoint.address)
        self._outbox = Outbox(bus.network, self.endpoint, self._one_over)
        self.setting.table.bind(self.slot, index)
        return bus

    def connect(self, address: bytes) -> None:
        name = parsed(address)
        if self._bus is None or self._bus.port.interface.index != name.interface:
            raise refuse(errno.EINVAL)
        if not name.name and name.address == NO_ADDRESS and not self.endpoint.broadcasts():
            raise refuse(errno.EACCES)
        self.endpoint.peer_name, self.endpoint.peer_address = name.name, name.address
        if name.pgn <= LARGEST_PGN:
            self.endpoint.pgn = name.pgn
        self.endpoint.connected = True

    def name(self, *, of_peer: bool) -> bytes:
        """getsockname, getpeername."""
        endpoint = self.endpoint
        if of_peer and not endpoint.connected:
            raise refuse(errno.EADDRNOTAVAIL)
        own, peer = (endpoint.name, endpoint.address), (endpoint.peer_name, endpoint.peer_address)
        name, address = peer if of_peer else own
        return Name(self.setting.table.bound_to(self.slot), name, endpoint.pgn, address).pack()

    def set_option(self, level: int, name: int, value: bytes) -> None:
        if level != SOL_CAN_J1939:
            raise refuse(errno.EINVAL)
        if name == FILTER:
            self.endpoint.filters = parse_filters(value)
            return
        if name not in (PROMISCUOUS, PRIORITY, ERROR_QUEUE):
            raise refuse(errno.ENOPROTOOPT)
        if len(value) != _INT.size:
            raise refuse(errno.EINVAL)
        number = _INT.unpack(value)[0]
        if name == PROMISCUOUS:
            self.endpoint.promiscuous = number != 0
        elif name == PRIORITY:
            self.endpoint.priority = checked_priority(number)
        else:
            self._errors = (self._errors or Reports()) if number else None
            self.setting.table.watch(self.slot, number != 0)
            self._count_errors()

    def get_option(self, level: int, name: int) -> bytes:
        if level != SOL_CAN_J1939:
            raise refuse(errno.EINVAL)
        values = {
            PROMISCUOUS: int(self.endpoint.promiscuous),
            PRIORITY: self.endpoint.priority,
            ERROR_QUEUE: int(self._errors is not None),
        }
        if name not in values:
            raise refuse(errno.ENOPROTOOPT)
        return _INT.pack(values[name])

    def take_error(self) -> Queued:
        """The oldest entry of the error queue; raises OSError."""
        found = self._errors.take() if self._errors is not None else None
        if found is None:
            raise refuse(errno.EAGAIN)
        self._count_errors()
        return found

    # sending

    def sent_to(self, data: bytes, address: bytes) -> None:
        self._send(self._composed(data, address, len(data)), False, len(data), None)

    def sent(self, data: bytes, index: int, waits: bool, asked: Answered) -> None:
        """`index`: so many bytes of address come first, and perhaps MORE_FOLLOWS."""
        ahead = index & ~MORE_FOLLOWS
        address, data = data[:ahead], data[ahead:]
        size = len(data)
        if index & MORE_FOLLOWS:
            self._composed(b"", address, len(self._begun) + size)
            self._begun += data
            asked.answer(size)
            return
        whole = bytes(self._begun) + data if self._begun else data
        self._begun.clear()
        message = self._composed(whole, address, len(whole))
        self._send(message, waits, size, asked)

    def _composed(self, data: bytes, address: bytes, size: int) -> Message:
        endpoint = self.endpoint
        if self._bus is None or not (endpoint.name or endpoint.address != NO_ADDRESS):
            raise refuse(errno.EBADFD)
        to = Name(0, endpoint.peer_name, NO_PGN, endpoint.peer_address)
        if address:
            to = parsed(address, index_needed=False)
            if to.interface and to.interface != self._bus.port.interface.index:
                raise refuse(errno.EBADFD)
        if not to.name and to.address == NO_ADDRESS and not endpoint.broadcasts():
            raise refuse(errno.EACCES)
        message = endpoint.message(data, to.pgn, to.name, to.address)
        if message.pgn in RESERVED:
            raise refuse(errno.EDOM)
        if size > LARGEST_ETP:
            raise refuse(errno.EMSGSIZE)
        if size > LARGEST_TP and message.is_broadcast:
            raise refuse(errno.EDESTADDRREQ)
        return message

    def _send(self, message: Message, waits: bool, size: int, asked: Answered | None) -> None:
        assert self._outbox is not None
        pending = self._outbox.pending
        if pending >= (_MOST_PENDING if waits else _MOST_QUEUED) and asked is not None:
            if not waits:
                raise refuse(errno.EAGAIN)
            self._waiting.append((message, size, asked))
            return
        self._outbox.send(message)
        if asked is not None:
            asked.answer(size)

    def _one_over(self, error: int) -> None:
        if error and self._errors is None:
            self._fail(error)
        assert self._outbox is not None
        while self._waiting and self._outbox.pending < _MOST_PENDING:
            message, size, asked = self._waiting.popleft()
            try:
                self._outbox.send(message)
            except OSError as refused:
                asked.answer(-(refused.errno or errno.EIO))
            else:
                asked.answer(size)
        if self.over and not self._outbox.pending:
            self.setting.loop.soon(self._leave)

    def confirm(self, message: Message) -> None:
        if self._outbox is not None and len(message.data) <= LARGEST_SINGLE:
            self._outbox.confirm(message)

    # what the network tells

    def _deliver(self, message: Message, stamp_ns: int, own: bool) -> None:
        assert self._bus is not None
        data, rest = message.data[:LARGEST_IN_PAIR], message.data[LARGEST_IN_PAIR:]
        about = ABOUT.pack(
            message.source_name,
            message.destination_name,
            message.pgn,
            message.source,
            message.destination,
            message.priority,
            self.rests.keep(rest),
        )
        index = self._bus.port.interface.index
        flags = (LOCAL if own else 0) | (HAS_REST if rest else 0)
        self.tell(data, stamp_ns, index, flags=flags, about=about)

    def _report(self, report: Report) -> None:
        if self._errors is None or self.over:
            return
        now_ns = self.setting.hub.now_ns() + self.setting.epoch_ns
        before = len(self._errors)
        if self._errors.put(report, self.setting.table.stamps(self.slot), now_ns):
            self._count_errors()
            if not before:  # something to wake up for: an error of which SO_ERROR says nothing
                self.tell(b"", 0, self.setting.table.bound_to(self.slot), errno.ENOMSG)

    def _count_errors(self) -> None:
        self.setting.table.count_errors(self.slot, len(self._errors or ()))

    def _fail(self, error: int) -> None:
        self.setting.table.set_error(self.slot, error)
        self.tell(b"", 0, self.setting.table.bound_to(self.slot), error)

    def bus_lost(self, interface: Interface, error: int) -> None:
        """ENETDOWN: its line was stopped; ENODEV: it is gone."""
        if self._outbox is not None:
            self._outbox.stop(error)
        while self._waiting:
            self._waiting.popleft()[2].answer(-error)
        if error == errno.ENODEV:
            self._part()
        if self.over:
            self._leave()
        else:
            self.interface_lost(interface, error)

    # the end

    def ended(self) -> None:
        self.setting.table.watch(self.slot, False)
        if self._outbox is None or not self._outbox.pending:
            self._leave()

    def _leave(self) -> None:
        if not self._left:
            self._left = True
            self._part()
            self.let_go()

    def _part(self) -> None:
        bus, self._bus, self._outbox = self._bus, None, None
        if bus is not None:
            bus.network.addresses.leave(self.endpoint.name, self.endpoint.address)
            bus.leave(self)
