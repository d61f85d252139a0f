"""The options of a CAN_RAW socket, and the frames of a line that it receives with them."""

from __future__ import annotations

import errno
import struct
from typing import TYPE_CHECKING

from canwire.socketcan.constants import (
    CAN_ERR_FLAG,
    CAN_ERR_MASK,
    CAN_MTU,
    CAN_RAW_ERR_FILTER,
    CAN_RAW_FD_FRAMES,
    CAN_RAW_FILTER,
    CAN_RAW_JOIN_FILTERS,
    CAN_RAW_LOOPBACK,
    CAN_RAW_RECV_OWN_MSGS,
    CAN_RAW_XL_FRAMES,
    MOST_FILTERS,
)
from canwire.socketcan.filters import Filters
from canwire.socketcan.ports import refuse
from canwire.socketcan.wire import OWN, numpy_module

if TYPE_CHECKING:
    import numpy

    from canwire.socketcan.wire import Batch

    Array = numpy.ndarray

_INT = struct.Struct("<i")
_WORD = struct.Struct("<I")
_FILTER = struct.Struct("<II")
_SWITCHES = {
    CAN_RAW_LOOPBACK: 1,
    CAN_RAW_RECV_OWN_MSGS: 0,
    CAN_RAW_FD_FRAMES: 0,
    CAN_RAW_JOIN_FILTERS: 0,
    CAN_RAW_XL_FRAMES: 0,
}


class RawOptions:
    """The options of one socket; `set` and `get` raise OSError like the kernel's calls."""

    def __init__(self) -> None:
        self._switches = dict(_SWITCHES)
        self._filter_words = b"\0" * 8
        self._filters = Filters()
        self._deaf = False
        self._error_mask = 0

    def on(self, switch: int) -> bool:
        """CAN_RAW_LOOPBACK, CAN_RAW_FD_FRAMES ..."""
        return self._switches[switch] != 0

    def wanted(self) -> list[tuple[int, int]]:
        """Identifier words and masks of its filters; the one for errors is last."""
        found = [] if self._deaf else list(_FILTER.iter_unpack(self._filter_words))
        return found + ([(0, self._error_mask | CAN_ERR_FLAG)] if self._error_mask else [])

    def set(self, name: int, value: bytes) -> None:
        if name == CAN_RAW_FILTER:
            self._set_filters(value)
        elif name == CAN_RAW_ERR_FILTER:
            if len(value) != _WORD.size:
                raise refuse(errno.EINVAL)
            self._error_mask = _WORD.unpack(value)[0] & CAN_ERR_MASK
        elif name in _SWITCHES:
            self._switch(name, value)
        else:
            raise refuse(errno.ENOPROTOOPT)

    def get(self, name: int) -> bytes:
        if name == CAN_RAW_FILTER:
            return self._filter_words
        if name == CAN_RAW_ERR_FILTER:
            return _WORD.pack(self._error_mask)
        if name in _SWITCHES:
            return _INT.pack(self._switches[name])
        raise refuse(errno.ENOPROTOOPT)

    def _set_filters(self, value: bytes) -> None:
        if len(value) % 8 or len(value) > MOST_FILTERS * 8:
            raise refuse(errno.EINVAL)
        self._filters = Filters.parse(value, self.on(CAN_RAW_JOIN_FILTERS))
        self._filter_words = value
        self._deaf = not self._filters.filters

    def _switch(self, name: int, value: bytes) -> None:
        if len(value) != _INT.size:
            raise refuse(errno.EINVAL)
        self._switches[name] = _INT.unpack(value)[0]
        if name == CAN_RAW_XL_FRAMES and self.on(name):
            self._switches[CAN_RAW_FD_FRAMES] = self._switches[name]  # as the kernel does
        if name == CAN_RAW_JOIN_FILTERS:
            self._filters = Filters(self._filters.filters, self.on(name))

    def selected(self, batch: Batch, slot: int) -> Array | None:
        """The rows that this socket receives, with its own ones marked; None: none."""
        if self._deaf and batch.errors is None:
            return None
        rows = batch.rows
        kept = self._filters.passing(rows["can_id"])
        if not self.on(CAN_RAW_FD_FRAMES):
            kept = _both(kept, rows["length"] == CAN_MTU)
        own = batch.owners == slot
        returns_own = own.any()
        if returns_own and not self.on(CAN_RAW_RECV_OWN_MSGS):
            kept = _both(kept, ~own)
        if batch.errors is not None:
            kept = self._with_errors(kept, rows, batch.errors)
        found: Array = rows.copy() if kept is None else rows[kept]
        if returns_own and self.on(CAN_RAW_RECV_OWN_MSGS):
            found["flags"][own if kept is None else own[kept]] |= OWN
        return found if len(found) else None

    def _with_errors(self, kept: Array | None, rows: Array, errors: Array) -> Array:
        numpy = numpy_module()
        classes = self._error_mask | self._filters.error_mask()
        wanted = rows["can_id"] & numpy.uint32(classes) != 0
        everything = numpy.ones(len(rows), bool) if kept is None else kept
        found: Array = numpy.where(errors, wanted, everything)
        return found


def _both(kept: Array | None, mask: Array) -> Array | None:
    if kept is None:
        return None if mask.all() else mask
    return kept & mask
