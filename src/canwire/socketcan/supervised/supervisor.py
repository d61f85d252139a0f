"""Answers the calls of programs that preload nothing; all other calls are passed to the kernel."""

from __future__ import annotations

import errno
import os
import struct
from socket import AF_NETLINK
from typing import TYPE_CHECKING, Protocol

from canwire.socketcan.constants import AF_CAN, CAN_ISOTP, CAN_RAW
from canwire.socketcan.loop import READABLE
from canwire.socketcan.ports import refuse
from canwire.socketcan.sockets.j1939.socket import J1939Socket
from canwire.socketcan.supervised.links import LinkSockets
from canwire.socketcan.supervised.many import ReceivingMany, send_many
from canwire.socketcan.supervised.names import answer_about_interface
from canwire.socketcan.supervised.notices import Call, Listener
from canwire.socketcan.supervised.options import get_socket_option, set_socket_option
from canwire.socketcan.supervised.program import Message, Program
from canwire.socketcan.supervised.receiving import Receiving

if TYPE_CHECKING:
    import socket

    from canwire.socketcan.netlink.door import NetlinkDoor
    from canwire.socketcan.setting import Setting
    from canwire.socketcan.sockets.base import CanSocket

_SOL_SOCKET = 1
_NONBLOCK, _CLOEXEC = os.O_NONBLOCK, os.O_CLOEXEC  # SOCK_NONBLOCK, SOCK_CLOEXEC are the same bits
_ADDRESS = struct.Struct("<Hxxi")
_SOCKADDR_UN = 110  # the shim asks with so much room which socket of the server's it has
_LARGEST = 1 << 16


class Sockets(Protocol):
    """The sockets of the server."""

    def make(self, type: int, protocol: int, program: str) -> socket.socket:
        """Make a socket and return the program's end; raises OSError."""

    def of_inode(self, inode: int) -> CanSocket | None: ...


class Supervisor:
    """Answers the calls of one program and of those that it starts; `listener` is closed with the last of them."""

    def __init__(
        self, setting: Setting, sockets: Sockets, listener: Listener, door: NetlinkDoor | None
    ) -> None:
        self._setting = setting
        self._sockets = sockets
        self._listener = listener
        self._links = LinkSockets(door) if door is not None else None
        setting.loop.watch(listener.descriptor, READABLE, self._called)

    def close(self) -> None:
        self._setting.loop.forget(self._listener.descriptor)
        self._listener.close()

    def _called(self, events: int) -> None:
        if not events & READABLE:  # hung up
            self.close()
            return
        call = self._listener.receive()
        if call is None:
            return
        try:
            self._answer(call, Program(call.thread))
        except OSError as error:
            self._listener.answer(call, -(error.errno or errno.EIO))
        except Exception as error:
            self._setting.fault(f"process {call.thread}, {call.name}", error)
            self._listener.answer(call, -errno.EIO)

    def _answer(self, call: Call, program: Program) -> None:
        if call.name == "socket":
            self._open(call, program)
            return
        if call.name == "ioctl":
            done = answer_about_interface(self._setting, program, call)
        else:
            found = self._sockets.of_inode(program.inode(call.arguments[0]))
            if found is not None and call.name in ("recvfrom", "recvmsg"):
                self._receive(Receiving(call, program, found), found)
                return
            if found is not None and call.name == "recvmmsg":
                self._receive(ReceivingMany(call, program, found), found)
                return
            if found is not None:
                done = self._done(call, program, found)
            else:
                done = self._links.answer(call, program) if self._links is not None else None
        if done is None:
            self._listener.let_pass(call)
        else:
            self._listener.answer(call, done)

    def _open(self, call: Call, program: Program) -> None:
        family, type, protocol, *_ = call.arguments
        if family & 0xFFFFFFFF == AF_NETLINK:
            self._open_link(call, type, protocol)
            return
        if protocol & 0xFFFF_0000:  # which would be AF_PACKET's: sockets/open_sockets.py
            raise refuse(errno.EINVAL)
        with self._sockets.make(type & 0xF, protocol & 0xFFFF, program.name) as end:
            if type & _NONBLOCK:
                end.setblocking(False)
            self._listener.put_descriptor(call, end.fileno(), close_on_exec=bool(type & _CLOEXEC))

    def _open_link(self, call: Call, type: int, protocol: int) -> None:
        if self._links is None or protocol & 0xFFFFFFFF:
            self._listener.let_pass(call)
            return
        with self._links.open(type & (0xF | _NONBLOCK)) as end:
            self._listener.put_descriptor(call, end.fileno(), close_on_exec=bool(type & _CLOEXEC))

    def _done(self, call: Call, program: Program, found: CanSocket) -> int | None:
        """Execute the call and return its result; None if the kernel must execute it."""
        _, a, b, c, d, e = call.arguments
        if call.name == "bind":
            found.bind(program.read(a, min(b, 128)))
        elif call.name == "connect":
            found.connect(program.read(a, min(b, 128)))
        elif call.name == "getsockname":
            return self._name(program, found, a, b)
        elif call.name == "setsockopt":
            value = program.read(c, min(d, _LARGEST))
            if a == _SOL_SOCKET:
                return set_socket_option(found, b, value)
            found.set_option(a, b, value)
        elif call.name == "getsockopt":
            shown = get_socket_option(found, b) if a == _SOL_SOCKET else found.get_option(a, b)
            if shown is None:
                return None
            room = program.length_at(d)
            program.write(c, shown[:room])
            program.write(d, struct.pack("<I", min(len(shown), room)))
        elif call.name == "sendto":
            return _sent(found, program.read(a, min(b, _LARGEST)), program.read(d, min(e, 128)))
        elif call.name == "sendmmsg":
            return send_many(call, program, found)
        else:
            return self._send_message(program, found, a)
        return 0

    def _name(self, program: Program, found: CanSocket, place: int, length: int) -> int | None:
        if program.length_at(length) == _SOCKADDR_UN:
            return None
        table = self._setting.table
        name = _ADDRESS.pack(AF_CAN, table.bound_to(found.slot))
        if isinstance(found, J1939Socket):
            name = found.name(of_peer=False)
        if table.protocol(found.slot) == CAN_ISOTP:
            name += struct.pack("<II", *table.identifiers(found.slot))
        program.put(place, length, name)
        return 0

    def _send_message(self, program: Program, found: CanSocket, place: int) -> int | None:
        message = Message(program, place)
        if not message.name and self._setting.table.protocol(found.slot) == CAN_RAW and not message.control:
            return None  # its messages are frames
        address = program.read(message.name, min(message.name_size, 128)) if message.name else b""
        return _sent(found, program.gather(message.parts), address)

    def _receive(self, receiving: Receiving | ReceivingMany, found: CanSocket) -> None:
        over = False

        def look() -> None:
            if over:
                return
            try:
                done = receiving.look()
            except OSError as error:
                done = -(error.errno or errno.EIO)
            if done is None:
                found.waiting.append(look)
            else:
                self._listener.answer(receiving.call, done)

        def expire() -> None:
            nonlocal over
            over = True
            self._listener.answer(receiving.call, -errno.EAGAIN)

        look()
        if look in found.waiting and receiving.limit_s:
            self._setting.loop.call_in(receiving.limit_s, expire)


def _sent(found: CanSocket, data: bytes, address: bytes) -> int:
    found.sent_to(data, address)
    return len(data)
