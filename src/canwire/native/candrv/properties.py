"""CAN_PROPERTIES with the TCHAR of a program on Linux, char or wchar_t of four bytes; canwire.candrv uses UTF-16.

The size of the structure shows which type the program uses.
"""

from __future__ import annotations

from canwire.candrv import CAN_PROPERTIES

_NAME = CAN_PROPERTIES.OFFSETS["device_name"]
_AFTER = CAN_PROPERTIES.OFFSETS["min"]
_UNITS = (_AFTER - _NAME) // 2
_ENCODINGS = {
    CAN_PROPERTIES.SIZE - 2 * _UNITS + _UNITS * width: (encoding, width)
    for encoding, width in (("utf-8", 1), ("utf-32-le", 4))
}


def is_of_c(size: int) -> bool:
    """True if a structure of this many bytes uses one of these types."""
    return size in _ENCODINGS


def as_in_c(data: bytes, size: int) -> bytes:
    """Return the same properties as a structure of this many bytes."""
    encoding, width = _ENCODINGS[size]
    name = CAN_PROPERTIES.unpack(data).device_name.encode(encoding)
    return data[:_NAME] + name[: (_UNITS - 1) * width].ljust(_UNITS * width, b"\0") + data[_AFTER:]
