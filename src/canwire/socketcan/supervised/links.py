"""rtnetlink of programs whose calls the server answers: their messages go to the server's netlink door."""

from __future__ import annotations

import os
import socket
import struct
from typing import TYPE_CHECKING

from canwire.socketcan.supervised.program import Message

if TYPE_CHECKING:
    from canwire.socketcan.netlink.door import NetlinkDoor
    from canwire.socketcan.supervised.notices import Call
    from canwire.socketcan.supervised.program import Program

_USER_SOCKET = 2  # NETLINK_USERSOCK
_KERNEL = struct.pack("<HHII", socket.AF_NETLINK, 0, 0, 0)  # struct sockaddr_nl
_LARGEST = 1 << 17
_TRUNCATED = 0x20


class LinkSockets:
    """The netlink sockets of one program."""

    def __init__(self, door: NetlinkDoor) -> None:
        self._door = door
        self._inodes: set[int] = set()

    def open(self, type: int) -> socket.socket:
        """Make a socket and return the program's end."""
        made = socket.socket(socket.AF_NETLINK, type, _USER_SOCKET)
        self._inodes.add(os.fstat(made.fileno()).st_ino)
        return made

    def answer(self, call: Call, program: Program) -> int | None:
        """The return value of a call; None: the kernel executes it. Raises OSError."""
        if call.name not in ("sendto", "sendmsg", "recvfrom", "recvmsg"):
            return None
        if program.inode(call.arguments[0]) not in self._inodes:
            return None
        with socket.socket(fileno=program.fetch(call.arguments[0])) as end:
            if call.name in ("sendto", "sendmsg"):
                return self._sent(call, program, end)
            return _received(call, program, end)

    def _sent(self, call: Call, program: Program, end: socket.socket) -> int:
        if call.name == "sendto":
            data = program.read(call.arguments[1], min(call.arguments[2], _LARGEST))
        else:
            data = program.gather(Message(program, call.arguments[1]).parts)
        if not end.getsockname()[0]:
            end.bind((0, 0))
        self._door.answer(data, end.getsockname()[0])
        return len(data)


def _received(call: Call, program: Program, end: socket.socket) -> int | None:
    """Waiting data, with the kernel's address as its source for the program; None: the kernel waits."""
    flags = call.arguments[2] if call.name == "recvmsg" else call.arguments[3]
    try:
        data = end.recv(_LARGEST, flags & socket.MSG_PEEK | socket.MSG_DONTWAIT)
    except BlockingIOError:
        return None
    if call.name == "recvmsg":
        message = Message(program, call.arguments[1])
        done = program.scatter(message.parts, data)
        program.write(message.name, _KERNEL[: message.name_size] if message.name else b"")
        message.finish(program, len(_KERNEL) if message.name else 0, 0, _TRUNCATED if done < len(data) else 0)
    else:
        _, place, size, _, name, length = call.arguments
        done = program.scatter([(place, size)], data)
        program.put(name, length, _KERNEL)
    return len(data) if flags & socket.MSG_TRUNC else done
