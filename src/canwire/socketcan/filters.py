"""CAN_RAW's filters, applied to many frames in one call.

Source: linux/can.h (struct can_filter), linux/can/raw.h; what a mask means for 11-bit frames is the kernel's
documentation, networking/can.rst 4.1.1.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

from canwire.socketcan.constants import (
    CAN_EFF_FLAG,
    CAN_ERR_FLAG,
    CAN_ERR_MASK,
    CAN_INV_FILTER,
    CAN_RTR_FLAG,
    CAN_SFF_MASK,
)
from canwire.socketcan.wire import numpy_module

if TYPE_CHECKING:
    import numpy

    Array = numpy.ndarray

_FILTER = struct.Struct("<II")
_WORD_MASK = 0xFFFF_FFFF


class Filter(NamedTuple):
    """A frame passes if its identifier word, with flags, matches where `mask` has ones; `inverted`: if it does not."""

    id: int
    mask: int
    inverted: bool = False

    @property
    def for_errors(self) -> bool:
        """True for a filter of error frames: CAN_ERR_FLAG in the mask."""
        return bool(self.mask & CAN_ERR_FLAG)

    @classmethod
    def of_words(cls, id: int, mask: int) -> Filter:
        """The filter in the words that a program writes."""
        inverted = bool(id & CAN_INV_FILTER)
        id &= ~CAN_INV_FILTER
        if mask & CAN_ERR_FLAG:
            mask = mask & CAN_ERR_MASK | CAN_ERR_FLAG
            return cls(id & mask & CAN_ERR_MASK, mask, inverted)
        if mask & CAN_EFF_FLAG and not id & CAN_EFF_FLAG:
            mask &= CAN_SFF_MASK | CAN_EFF_FLAG | CAN_RTR_FLAG
        return cls(id & mask, mask & _WORD_MASK, inverted)


@dataclass(frozen=True)
class Filters:
    """The filters of one socket: a frame must match one of them, with `joined` all. Without filters none passes."""

    filters: tuple[Filter, ...] = (Filter(0, 0),)
    joined: bool = False

    @classmethod
    def parse(cls, data: bytes, joined: bool) -> Filters:
        """The filters in an array of `struct can_filter`; raises ValueError for an incomplete one."""
        if len(data) % _FILTER.size:
            raise ValueError(f"{len(data)} bytes: filters have {_FILTER.size} each")
        return cls(tuple(Filter.of_words(*words) for words in _FILTER.iter_unpack(data)), joined)

    def passing(self, can_ids: Array) -> Array | None:
        """A mask over identifier words of data and remote frames; None: all."""
        numpy = numpy_module()
        about_frames = [one for one in self.filters if not one.for_errors]
        if not about_frames or (self.joined and len(about_frames) < len(self.filters)):  # no frame is both
            return numpy.zeros(len(can_ids), bool)
        if not self.joined and any(one.mask == 0 and not one.inverted for one in about_frames):
            return None
        found = [_agrees(one, can_ids) for one in about_frames]
        combine = numpy.logical_and if self.joined else numpy.logical_or
        return combine.reduce(found)

    def error_mask(self) -> int:
        """The error classes that filters select, in addition to those of CAN_RAW_ERR_FILTER."""
        found = 0
        for one in self.filters:
            if one.for_errors and not one.inverted:
                found |= one.mask & CAN_ERR_MASK
        return found


def _agrees(one: Filter, can_ids: Array) -> Array:
    same = can_ids & one.mask == one.id
    return ~same if one.inverted else same
