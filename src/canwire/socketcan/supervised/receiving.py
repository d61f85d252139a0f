"""recvfrom and recvmsg of a program whose calls the server answers: data, address, times, counts of losses.

A call that waits is answered when its socket has data: `Receiving.look` is called again then.
"""

from __future__ import annotations

import errno
import fcntl
import os
import socket
import struct
from typing import TYPE_CHECKING, NamedTuple

from canwire.socketcan.constants import AF_CAN, CAN_ISOTP, CAN_J1939, SOL_CAN_J1939
from canwire.socketcan.j1939.message import NO_ADDRESS, NO_NAME
from canwire.socketcan.ports import refuse
from canwire.socketcan.sockets.error_queue import control_message
from canwire.socketcan.sockets.j1939.names import Name
from canwire.socketcan.sockets.j1939.rests import HAS_REST
from canwire.socketcan.sockets.j1939.socket import ABOUT, J1939Socket
from canwire.socketcan.supervised.program import Message, Program
from canwire.socketcan.table import Stamps

if TYPE_CHECKING:
    from canwire.socketcan.rings import Row
    from canwire.socketcan.sockets.base import CanSocket
    from canwire.socketcan.supervised.notices import Call

_CMSG_SIZE = 16  # struct cmsghdr
_SOL_SOCKET, _STAMPS_NS, _LOST = 1, (35, 64), 40  # SO_TIMESTAMPNS, SO_RXQ_OVFL
_SOFTWARE, _HARDWARE = 16, 64  # SOF_TIMESTAMPING_
_DONTROUTE, _CONFIRM, _TRUNCATED, _CONTROL_TRUNCATED = 0x4, 0x800, 0x20, 0x8
_LONGEST = 1 << 17


class Arrived(NamedTuple):
    """A message with the values of its row."""

    data: bytes
    row: Row


def _fitting(control: bytes, room: int) -> tuple[bytes, bool]:
    """The part of these messages that fits, and whether some of them do not fit."""
    return control[:room] if room >= _CMSG_SIZE else b"", len(control) > room


class Receiving:
    """One call of recvfrom or recvmsg."""

    def __init__(self, call: Call, program: Program, found: CanSocket) -> None:
        self.call = call
        self._program = program
        self._socket = found
        arguments = call.arguments
        self._flags = arguments[2] if call.name == "recvmsg" else arguments[3]
        self._waits = not self._flags & socket.MSG_DONTWAIT
        self.limit_s = 0.0  # SO_RCVTIMEO; 0: none

    def look(self) -> int | None:
        """The return value of the call; None: it waits. Raises OSError."""
        if self._flags & socket.MSG_ERRQUEUE:
            return self._error()
        descriptor = self._program.fetch(self.call.arguments[0])
        with socket.socket(fileno=descriptor) as end:
            blocks = not fcntl.fcntl(end.fileno(), fcntl.F_GETFL) & os.O_NONBLOCK
            seconds, micros = struct.unpack("<qq", end.getsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, 16))
            self.limit_s = seconds + micros / 1e6
            peeks = self._flags & socket.MSG_PEEK
            try:
                data = end.recv(_LONGEST, peeks | socket.MSG_DONTWAIT)
            except BlockingIOError:
                if blocks and self._waits:
                    return None
                raise
        row = self._socket.row_of_message(data, bool(peeks))
        if (
            row.error == errno.ENOMSG and not data
        ):  # its error queue has something, which only the shim's poll tells
            return self.look()
        if row.flags & HAS_REST and isinstance(self._socket, J1939Socket):
            data += self._socket.rests.take(ABOUT.unpack(row.about)[-1])
        return self._told(Arrived(data, row))

    def _error(self) -> int:
        """The entry of the error queue; raises OSError (EAGAIN) if it is empty."""
        program, arguments = self._program, self.call.arguments
        entry = self._socket.take_error()
        if self.call.name == "recvfrom":
            return program.scatter([(arguments[1], arguments[2])], entry.data)
        message = Message(program, arguments[1])
        done = program.scatter(message.parts, entry.data)
        control, cut = _fitting(entry.control, message.control_size if message.control else 0)
        program.write(message.control, control)
        flags = (_TRUNCATED if done < len(entry.data) else 0) | (_CONTROL_TRUNCATED if cut else 0)
        message.finish(program, 0, len(control), flags | socket.MSG_ERRQUEUE)
        return done

    def _told(self, arrived: Arrived) -> int:
        if arrived.row.error:
            raise refuse(arrived.row.error)
        if self.call.name == "recvmsg":
            return self._as_message(arrived)
        _, place, size, _, name, length = self.call.arguments
        done = self._program.scatter([(place, size)], arrived.data)
        self._program.put(name, length, self._address(arrived))
        return done

    def _as_message(self, arrived: Arrived) -> int:
        program = self._program
        message = Message(program, self.call.arguments[1])
        done = program.scatter(message.parts, arrived.data)
        name = self._address(arrived) if message.name else b""
        program.write(message.name, name[: message.name_size])
        whole = self._about(arrived)
        whole += b"".join(control_message(_SOL_SOCKET, kind, data) for kind, data in self._control(arrived))
        control, cut = _fitting(whole, message.control_size if message.control else 0)
        program.write(message.control, control)
        flags = (_TRUNCATED if done < len(arrived.data) else 0) | (_CONTROL_TRUNCATED if cut else 0)
        flags |= (_DONTROUTE if arrived.row.flags & 1 else 0) | (_CONFIRM if arrived.row.flags & 2 else 0)
        message.finish(program, len(name), len(control), flags)
        return done

    def _address(self, arrived: Arrived) -> bytes:
        table, slot = self._socket.setting.table, self._socket.slot
        if table.protocol(slot) == CAN_J1939:
            name, _, pgn, source, *_ = ABOUT.unpack(arrived.row.about)
            return Name(arrived.row.interface, name, pgn, source).pack()
        if table.protocol(slot) == CAN_ISOTP:
            return struct.pack("<HxxiII", AF_CAN, arrived.row.interface, *table.identifiers(slot))
        return struct.pack("<Hxxi", AF_CAN, arrived.row.interface)

    def _about(self, arrived: Arrived) -> bytes:
        """The ancillary data of a CAN_J1939 message; b"" for other protocols."""
        if self._socket.setting.table.protocol(self._socket.slot) != CAN_J1939:
            return b""
        _, name, _, _, address, priority, _ = ABOUT.unpack(arrived.row.about)
        found = control_message(SOL_CAN_J1939, 1, bytes((address,))) if address != NO_ADDRESS else b""
        found += control_message(SOL_CAN_J1939, 2, struct.pack("<Q", name)) if name != NO_NAME else b""
        return found + control_message(SOL_CAN_J1939, 3, bytes((priority,)))

    def _control(self, arrived: Arrived) -> list[tuple[int, bytes]]:
        stamps: Stamps = self._socket.setting.table.stamps(self._socket.slot)
        seconds, ns = divmod(arrived.row.stamp_ns, 1_000_000_000)
        fine, found = struct.pack("<qq", seconds, ns), []
        if stamps.plain:
            coarse = struct.pack("<qq", seconds, ns // 1000)
            found.append((stamps.plain, fine if stamps.plain in _STAMPS_NS else coarse))
        if stamps.flags & (_SOFTWARE | _HARDWARE):
            software = fine if stamps.flags & _SOFTWARE else bytes(16)
            hardware = fine if stamps.flags & _HARDWARE else bytes(16)
            found.append((stamps.stamping, software + bytes(16) + hardware))
        if stamps.counts_drops and arrived.row.drops:
            found.append((_LOST, struct.pack("<I", arrived.row.drops)))
        return found
