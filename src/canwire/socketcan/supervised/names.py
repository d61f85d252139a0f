"""SIOCGIF... of interfaces that only the server knows; shim/interfaces.c has the same in C."""

from __future__ import annotations

import errno
import struct
from typing import TYPE_CHECKING

from canwire.socketcan.table import OFF, UP

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.setting import Setting
    from canwire.socketcan.supervised.notices import Call
    from canwire.socketcan.supervised.program import Program

_NAME, _FLAGS, _MTU, _HARDWARE, _INDEX, _QUEUE = 0x8910, 0x8913, 0x8921, 0x8927, 0x8933, 0x8942
_SETS = (0x8914, 0x8922, 0x8923, 0x8943)
_UP, _RUNNING, _NO_ARP, _ARPHRD_CAN, _LENGTH = 0x1, 0x40, 0x80, 280, 1000
_NAME_SIZE, _IFREQ = 16, 40
_INT = struct.Struct("<i")


def answer_about_interface(setting: Setting, program: Program, call: Call) -> int | None:
    """Answer the call, with 0; None: it is for the kernel. Raises OSError."""
    request, place = call.arguments[1] & 0xFFFF, call.arguments[2]
    if request not in (_NAME, _FLAGS, _MTU, _HARDWARE, _INDEX, _QUEUE, *_SETS):
        return None
    about = program.read(place, _IFREQ)
    interface = _meant(setting, about, by_index=request == _NAME)
    if interface is None:
        return None
    if request in _SETS:
        return -errno.EPERM
    if request == _NAME:
        program.write(place, interface.name.encode().ljust(_NAME_SIZE, b"\0"))
    else:
        program.write(place + _NAME_SIZE, _value(interface, request))
    return 0


def _meant(setting: Setting, about: bytes, *, by_index: bool) -> Interface | None:
    everyone = setting.interfaces.by_index
    if by_index:
        return everyone.get(_INT.unpack_from(about, _NAME_SIZE)[0])
    name = about[:_NAME_SIZE].split(b"\0", 1)[0].decode("latin-1")
    return next((one for one in everyone.values() if one.name == name), None)


def _value(interface: Interface, request: int) -> bytes:
    if request == _FLAGS:
        running = 0 if interface.flags & OFF else _RUNNING
        return struct.pack("<H", _NO_ARP | (_UP | running if interface.flags & UP else 0))
    if request == _HARDWARE:
        return struct.pack("<H14x", _ARPHRD_CAN)
    return _INT.pack({_INDEX: interface.index, _MTU: interface.mtu, _QUEUE: _LENGTH}[request])
