"""Answers for a program on this system: each calling thread has a socket, which also carries descriptors.

A request is one message: the method's name ("vci.open_socket", 40 bytes with zeros), the object's number, the size of
the data, and the data; a reply is a result code, a number, data, and descriptors. ../core/helper.c is the
other end.
"""

from __future__ import annotations

import array
import contextlib
import os
import resource
import select
import socket
import struct
import threading
from typing import TYPE_CHECKING

from canwire.native.helper.rings import States
from canwire.native.helper.serving import Helper

if TYPE_CHECKING:
    from canwire.native.helper.answers import Reply
    from canwire.native.helper.turns import Turns

_REQUEST = struct.Struct("<40sII")
_REPLY = struct.Struct("<iI")
_LARGEST = _REQUEST.size + (1 << 16)


def answer_on(helper: Helper, connection: socket.socket) -> None:
    """Answer requests on this connection until the program closes it."""
    room = bytearray(_LARGEST)
    with connection, helper.thread(), contextlib.suppress(ConnectionError):
        while length := connection.recv_into(room):
            method, number, _ = _REQUEST.unpack_from(room)
            data = bytes(room[_REQUEST.size : length])
            _send(connection, helper.answer(method.rstrip(b"\0").decode("ascii"), number, data))


def _send(connection: socket.socket, reply: Reply) -> None:
    message = _REPLY.pack(reply.result, reply.value) + reply.data
    if not reply.descriptors:
        connection.send(message)
        return
    rights = array.array("i", reply.descriptors)
    try:
        connection.sendmsg([message], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, rights)])
    finally:
        for descriptor in reply.descriptors:
            os.close(descriptor)


def turns_of_program() -> Turns | None:
    """The program's Turns if it takes part in a hub's time, else None."""
    if os.environ.get("CANWIRE_TIMED") != "1":
        return None
    from canwire.native.helper.turns import Turns  # what no other program has need of

    return Turns()


def serve_near(channel: socket.socket, program: int) -> None:
    """Answer on the sockets that arrive on `channel`, until the program closes it or ends in any way."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))  # every queue of the program takes some here
    states = States()
    helper = Helper(states, states.page, turns_of_program())
    try:
        ended = os.pidfd_open(program)
    except ProcessLookupError:  # it was quicker
        return
    while True:
        readable, _, _ = select.select([channel.fileno(), ended], [], [])
        if ended in readable:
            return
        _, descriptors, _, _ = socket.recv_fds(channel, 1, 1)
        if not descriptors:
            return
        connection = socket.socket(fileno=descriptors[0])
        threading.Thread(target=answer_on, args=(helper, connection), daemon=True).start()
