"""Notifications of seccomp: each is one call of a program, which waits for its answer.

Source: linux/seccomp.h, seccomp_unotify(2).
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import platform
import struct
from typing import NamedTuple

from canwire.socketcan.ports import refuse

_RECEIVE, _SEND, _ADD = 0xC0502100, 0xC0182101, 0x40182103
_NOTICE = struct.Struct("<QIIiIQ6Q")
_ANSWER = struct.Struct("<QqiI")
_ADDED = struct.Struct("<QIIII")
_CONTINUE = 1  # SECCOMP_USER_NOTIF_FLAG_CONTINUE
_ADD_AND_ANSWER = 2  # SECCOMP_ADDFD_FLAG_SEND
_PIDFD_GETFD = 438

NUMBERS = {  # of system calls
    "x86_64": {41: "socket", 49: "bind", 42: "connect", 51: "getsockname", 54: "setsockopt", 55: "getsockopt"}
    | {16: "ioctl", 44: "sendto", 46: "sendmsg", 45: "recvfrom", 47: "recvmsg"}
    | {299: "recvmmsg", 307: "sendmmsg"},
    "aarch64": {198: "socket", 200: "bind", 203: "connect", 204: "getsockname", 208: "setsockopt"}
    | {209: "getsockopt", 29: "ioctl", 206: "sendto", 211: "sendmsg", 207: "recvfrom", 212: "recvmsg"}
    | {243: "recvmmsg", 269: "sendmmsg"},
}


class Call(NamedTuple):
    """A call: `name` of the system call, "" for one that is not handled; `thread` is the caller."""

    cookie: int
    thread: int
    name: str
    arguments: tuple[int, ...]


class Listener:
    """seccomp's descriptor, which it owns. Raises OSError (EINVAL) for any other one, which it closes."""

    def __init__(self, descriptor: int) -> None:
        if os.readlink(f"/proc/self/fd/{descriptor}") != "anon_inode:seccomp notify":
            os.close(descriptor)
            raise refuse(errno.EINVAL)
        self.descriptor = descriptor

    def receive(self) -> Call | None:
        """The next call; None if its process is gone."""
        room = bytearray(_NOTICE.size)
        try:
            fcntl.ioctl(self.descriptor, _RECEIVE, room)
        except OSError:
            return None
        cookie, thread, _, number, _, _, *arguments = _NOTICE.unpack(room)
        name = NUMBERS.get(platform.machine(), {}).get(number, "")
        return Call(cookie, thread, name, tuple(arguments))

    def answer(self, call: Call, value: int) -> bool:
        """Let the call return this value, an errno if negative; False if its thread no longer waits."""
        return self._send(call, max(0, value), min(0, value), 0)

    def let_pass(self, call: Call) -> None:
        """Let the kernel execute the call."""
        self._send(call, 0, 0, _CONTINUE)

    def _send(self, call: Call, value: int, error: int, flags: int) -> bool:
        try:
            fcntl.ioctl(self.descriptor, _SEND, bytearray(_ANSWER.pack(call.cookie, value, error, flags)))
        except OSError:
            return False
        return True

    def put_descriptor(self, call: Call, descriptor: int, *, close_on_exec: bool) -> None:
        """Let the call return a copy of this descriptor. Raises OSError."""
        flags = os.O_CLOEXEC if close_on_exec else 0
        added = bytearray(_ADDED.pack(call.cookie, _ADD_AND_ANSWER, descriptor, 0, flags))
        fcntl.ioctl(self.descriptor, _ADD, added)

    def close(self) -> None:
        os.close(self.descriptor)


def fetched(process: int, descriptor: int) -> int:
    """A copy of a descriptor of another process; raises OSError if that is not permitted."""
    handle = os.pidfd_open(process)
    try:
        found = ctypes.CDLL(None, use_errno=True).syscall(_PIDFD_GETFD, handle, descriptor, 0)
    finally:
        os.close(handle)
    if found < 0:
        raise refuse(ctypes.get_errno() or errno.EPERM)
    return int(found)
