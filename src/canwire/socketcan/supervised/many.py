"""recvmmsg and sendmmsg of programs whose calls the server answers: one message after the other."""

from __future__ import annotations

import socket
import struct
import time
from typing import TYPE_CHECKING

from canwire.socketcan.supervised.program import Message, Program
from canwire.socketcan.supervised.receiving import Receiving

if TYPE_CHECKING:
    from canwire.socketcan.sockets.base import CanSocket
    from canwire.socketcan.supervised.notices import Call

_SIZE, _LENGTH_AT = 64, 56  # struct mmsghdr
_MOST = 1024  # UIO_MAXIOV
_WAIT_FOR_ONE = 0x10000
_LENGTH, _SPAN = struct.Struct("<I"), struct.Struct("<qq")


class ReceivingMany:
    """One call of recvmmsg; its timeout is checked after each message, as in the kernel."""

    def __init__(self, call: Call, program: Program, found: CanSocket) -> None:
        self.call = call
        self._program = program
        self._socket = found
        _, self._place, count, self._flags, limit, _ = call.arguments
        self._count = min(count & 0xFFFF_FFFF, _MOST)
        self._done = 0
        self._until_s = float("inf")
        if limit:
            seconds, ns = _SPAN.unpack(program.read(limit, _SPAN.size))
            self._until_s = time.monotonic() + seconds + ns / 1e9
        self.limit_s = 0.0

    def look(self) -> int | None:
        """The return value of the call; None: it waits. Raises OSError."""
        while self._done < self._count:
            place, flags = self._place + self._done * _SIZE, self._flags & ~_WAIT_FOR_ONE
            if self._done and self._flags & _WAIT_FOR_ONE:
                flags |= socket.MSG_DONTWAIT
            arguments = (self.call.arguments[0], place, flags, 0, 0, 0)
            one = Receiving(
                self.call._replace(name="recvmsg", arguments=arguments), self._program, self._socket
            )
            try:
                size = one.look()
            except OSError:
                if self._done:
                    return self._done
                raise
            if size is None:
                self.limit_s = one.limit_s
                return None
            self._program.write(place + _LENGTH_AT, _LENGTH.pack(size))
            self._done += 1
            if time.monotonic() >= self._until_s:
                break
        return self._done


def send_many(call: Call, program: Program, found: CanSocket) -> int:
    """sendmmsg: returns how many messages were sent; raises OSError if the first one fails."""
    _, place, count, *_ = call.arguments
    done = 0
    try:
        for done in range(min(count & 0xFFFF_FFFF, _MOST)):
            message = Message(program, place + done * _SIZE)
            data = program.gather(message.parts)
            address = program.read(message.name, min(message.name_size, 128)) if message.name else b""
            found.sent_to(data, address)
            program.write(place + done * _SIZE + _LENGTH_AT, _LENGTH.pack(len(data)))
    except OSError:
        if not done:
            raise
        return done
    return done + 1 if count else 0
