"""The requests of shims by number (shim/shim.h, enum operation), and those that concern one socket."""

from __future__ import annotations

import errno
import os
import struct
from enum import IntEnum
from typing import TYPE_CHECKING

from canwire.socketcan.ports import refuse
from canwire.socketcan.sockets.error_queue import SOL_SOCKET
from canwire.socketcan.sockets.j1939.socket import J1939Socket
from canwire.socketcan.sockets.messages import MessageSocket
from canwire.socketcan.sockets.packet import PacketSocket

if TYPE_CHECKING:
    from canwire.socketcan.requests.control import Asked, Request
    from canwire.socketcan.sockets.base import CanSocket

_SIZE = struct.Struct("<I")


class Operation(IntEnum):
    """enum operation."""

    OPEN_SOCKET = 1
    BIND = 2
    CONNECT = 3
    SET_OPTION = 4
    GET_OPTION = 5
    SEND_BCM = 6
    SEND_ISOTP = 7
    NOTE = 8
    AWAIT_TURN = 9
    LEAVE_TIME = 10
    SET_TIMER = 11
    OPEN_TIMER = 12
    TAKE_PART = 13
    SET_TIMER_FD = 14
    SEND_J1939 = 15
    NAME = 16
    TAKE_ERROR = 17
    PLACE_FILES = 18
    MAP_RING = 19
    SUBSCRIBE = 20
    TAKE_REST = 21
    SUPERVISE = 100


_SENDS = (Operation.SEND_BCM, Operation.SEND_ISOTP, Operation.SEND_J1939)
TAKING_PART = (
    Operation.OPEN_SOCKET,
    Operation.AWAIT_TURN,
    Operation.SET_TIMER,
    Operation.OPEN_TIMER,
    Operation.TAKE_PART,
    Operation.SET_TIMER_FD,
)


def do_with_socket(found: CanSocket, request: Request, asked: Asked) -> None:
    """Execute a request about this socket; raises OSError, with which the program's call fails."""
    if request.operation == Operation.BIND:
        found.bind(request.data)
        asked.answer(0)
    elif request.operation == Operation.CONNECT:
        found.connect(request.data)
        asked.answer(0)
    elif request.operation == Operation.SET_OPTION and request.a == SOL_SOCKET:
        found.stamps_changed()
        asked.answer(0)
    elif request.operation == Operation.SET_OPTION:
        found.set_option(request.a, request.b, request.data)
        asked.answer(0)
    elif request.operation == Operation.GET_OPTION:
        asked.answer(0, found.get_option(request.a, request.b))
    elif isinstance(found, MessageSocket) and request.operation in _SENDS:
        found.sent(request.data, request.a, bool(request.b), asked)
    elif isinstance(found, J1939Socket) and request.operation == Operation.NAME:
        asked.answer(0, found.name(of_peer=bool(request.a)))
    elif isinstance(found, J1939Socket) and request.operation == Operation.TAKE_REST:
        _answer_with_memory(asked, found.rests.take(request.a))
    elif isinstance(found, PacketSocket) and request.operation == Operation.MAP_RING:
        descriptor, size = found.memory()
        asked.answer(size, descriptor=descriptor)
    elif request.operation == Operation.TAKE_ERROR:
        entry = found.take_error()
        asked.answer(0, _SIZE.pack(len(entry.data)) + entry.data + entry.control)
    else:
        raise refuse(errno.EOPNOTSUPP)


def _answer_with_memory(asked: Asked, data: bytes) -> None:
    """So much that no message between processes has room for it: in a file of memory, at its beginning."""
    descriptor = os.memfd_create("canwire-rest", os.MFD_CLOEXEC)
    try:
        with open(descriptor, "wb", closefd=False) as file:
            file.write(data)
        asked.answer(len(data), descriptor=descriptor)
    finally:
        os.close(descriptor)
