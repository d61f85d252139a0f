"""Checks of arguments: numbers in the range of C's parameters, and structures."""

from __future__ import annotations

from typing import TypeVar

from canwire.vci.structures.constants import CAN_FILTER_EXT, CAN_FILTER_STD
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciError

T = TypeVar("T")
UINT8, UINT16, UINT32 = 0xFF, 0xFFFF, 0xFFFF_FFFF


def within(name: str, value: int, low: int, high: int) -> int:
    """The value; raises VciInvalidArgument if it is no whole number from `low` to `high`."""
    if not isinstance(value, int) or not low <= value <= high:
        raise VciError.of(VCI_E_INVALIDARG, f"{name} {value!r:.40}: a whole number from {low} to {high}")
    return value


def instance(value: T, kind: type[T]) -> T:
    """The value; raises VciInvalidArgument if it is not an instance of `kind`."""
    if not isinstance(value, kind):
        raise VciError.of(VCI_E_INVALIDARG, f"a {kind.__name__} belongs here, not {value!r:.60}")
    return value


def is_extended(select: int) -> bool:
    """Whether bSelect is CAN_FILTER_EXT, not CAN_FILTER_STD; raises VciInvalidArgument for another number."""
    return within("select", select, CAN_FILTER_STD, CAN_FILTER_EXT) == CAN_FILTER_EXT
