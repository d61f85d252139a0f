"""Options of level SOL_SOCKET that differ from those of the kernel's socket below; shim/sockets.c has the same in C."""

from __future__ import annotations

import errno
import struct
from typing import TYPE_CHECKING

from canwire.socketcan.constants import AF_CAN, TYPE_OF_PROTOCOL
from canwire.socketcan.ports import refuse

if TYPE_CHECKING:
    from canwire.socketcan.sockets.base import CanSocket

_INT = struct.Struct("<i")
_TYPE, _ERROR, _RECEIVE_BUFFER, _BIND_TO_DEVICE, _FORCED_BUFFER, _PROTOCOL, _DOMAIN, _LOST = (
    3,
    4,
    8,
    25,
    33,
    38,
    39,
    40,
)
_STAMPS, _STAMPING = (29, 35, 63, 64), (37, 65)  # SO_TIMESTAMP, SO_TIMESTAMPNS, SO_TIMESTAMPING, old and new
_KNOWN_STAMPING = (1 << 16) - 1
_LEAST, _LEAST_SHOWN, _MOST = 1152, 2304, 0x3FFF_FFFF


def set_socket_option(found: CanSocket, name: int, value: bytes) -> int | None:
    """Set the option and return 0; None: it is for the kernel. Raises OSError."""
    table, slot = found.setting.table, found.slot
    if name == _BIND_TO_DEVICE:  # which a CAN socket's bind does not look at
        device = value.split(b"\0", 1)[0].decode("latin-1")
        names = {one.name for one in found.setting.interfaces.by_index.values()}
        return 0 if not device or device in names else None
    if name not in (_RECEIVE_BUFFER, _FORCED_BUFFER, _LOST, *_STAMPS, *_STAMPING):
        return None
    if len(value) < _INT.size:
        raise refuse(errno.EINVAL)
    number = _INT.unpack_from(value)[0]
    stamps = table.stamps(slot)
    if name == _LOST:
        table.set_stamps(slot, stamps._replace(counts_drops=int(number != 0)))
    elif name in _STAMPS:
        table.set_stamps(slot, stamps._replace(plain=name if number else 0))
    elif name in _STAMPING:
        if number & ~_KNOWN_STAMPING:
            raise refuse(errno.EINVAL)
        table.set_stamps(slot, stamps._replace(stamping=name, flags=number))
        found.stamps_changed()
    else:
        table.set_receive_buffer(slot, _LEAST_SHOWN if number < _LEAST else 2 * min(number, _MOST))
    return 0


def get_socket_option(found: CanSocket, name: int) -> bytes | None:
    """The value of the option; None: it is for the kernel."""
    table, slot = found.setting.table, found.slot
    stamps = table.stamps(slot)
    if name == _ERROR:
        number = table.take_error(slot)
    elif name == _RECEIVE_BUFFER:
        number = table.receive_buffer(slot)
    elif name in (_DOMAIN, _TYPE, _PROTOCOL):
        number = {_DOMAIN: AF_CAN, _TYPE: TYPE_OF_PROTOCOL[table.protocol(slot)], _PROTOCOL: 0}[name]
    elif name == _LOST:
        number = stamps.counts_drops
    elif name in _STAMPS:
        number = int(stamps.plain == name)
    elif name in _STAMPING:
        number = stamps.flags
    else:
        return None
    return _INT.pack(number)
