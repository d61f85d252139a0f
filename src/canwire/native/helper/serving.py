"""The helper's threads: one for each socket that the program calls on.

A request is one message: the method's name ("vci.open_socket", 40 bytes with zeros), the object's number, a reserved
word, and data; a reply is the interface's result code, a number, data, and descriptors. ../core/helper.c is the other
end.
"""

from __future__ import annotations

import array
import contextlib
import gc
import importlib
import os
import resource
import select
import socket
import struct
import sys
import threading
from typing import TYPE_CHECKING

from canwire import BadMessage
from canwire.native.helper.answers import Reply
from canwire.native.helper.rings import States, duplicates

if TYPE_CHECKING:
    from canwire.native.helper.answers import Answers

INTERFACES = {
    "acan": "canwire.native.acan",
    "candrv": "canwire.native.candrv",
    "vci": "canwire.native.vci",
}
"""Where an interface's `interface(states)` is, by the part of a method's name before the dot."""

_REQUEST = struct.Struct("<40sII")
_REPLY = struct.Struct("<iI")
_LARGEST = _REQUEST.size + (1 << 16)
_UNEXPECTED = -1  # where not even the interface could be found


class Helper:
    """All that is answered for one program."""

    def __init__(self) -> None:
        self.states = States()
        self._interfaces: dict[str, Answers] = {}
        self._loading = threading.Lock()

    def answer(self, method: str, number: int, data: bytes) -> Reply:
        """Raises nothing: what no interface has foreseen is printed, for the program's user to report."""
        try:
            if method == "helper.hello":
                return Reply(descriptors=duplicates(self.states.descriptor))
            interface, _, name = method.partition(".")
            return self._interface(interface).answer(name, number, data)
        except Exception:
            print(f"canwire: the call {method} failed in an unexpected way:", file=sys.stderr)
            sys.excepthook(*sys.exc_info())
            return Reply(_UNEXPECTED)

    def _interface(self, name: str) -> Answers:
        with self._loading:
            found = self._interfaces.get(name)
            if found is None:
                if name not in INTERFACES:
                    raise BadMessage(f"there is no interface {name!r}")
                found = self._interfaces[name] = importlib.import_module(INTERFACES[name]).interface(
                    self.states
                )
            return found

    def answer_on(self, connection: socket.socket) -> None:
        """Until the program closes it."""
        room = bytearray(_LARGEST)
        with connection, contextlib.suppress(ConnectionError):
            while length := connection.recv_into(room):
                method, number, _ = _REQUEST.unpack_from(room)
                data = bytes(room[_REQUEST.size : length])
                _send(connection, self.answer(method.rstrip(b"\0").decode("ascii"), number, data))


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


def serve(channel: socket.socket, program: int) -> None:
    """Answer at the sockets that come on `channel`, until the program has closed it or ended, in whatever way."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))  # every queue of the program takes some here
    gc.disable()  # a program's objects are few, and each is given back by hand
    helper = Helper()
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
        threading.Thread(target=helper.answer_on, args=(connection,), daemon=True).start()
