"""The message filters of ICanControl, ICanControl2 and ICanChannel2.

Source: VCI V4 manual 5.2.4; rulings.md 5.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.vci.arguments import UINT32, is_extended, within
from canwire.vci.structures.constants import CAN_FILTER_EXCL, CAN_FILTER_LOCK
from canwire.vci.unknown import Unknown, vci_call

if TYPE_CHECKING:
    from canwire import Filtered


class FilterLists(Unknown):
    """A filter for 11-bit and one for 29-bit identifiers, each with an acceptance filter and then a list.

    `select` is CAN_FILTER_STD or CAN_FILTER_EXT. `code` and `mask` are patterns of identifier << 1 | rtr; a 1 in the
    mask means that the bit is compared. The list of the 11-bit filter has room for 2048 identifiers, each with and
    without rtr. Changes raise VciInvalidState while the line runs or the channel is active.
    """

    def _filters(self) -> Filtered:
        """The lease that has the filters; raises VciNotInitialized before they are made."""
        raise NotImplementedError

    @vci_call
    def set_acc_filter(self, select: int, code: int, mask: int) -> None:
        """SetAccFilter: replace the pattern of the acceptance filter.

        All identifiers pass CAN_ACC_CODE_ALL with CAN_ACC_MASK_ALL, none passes CAN_ACC_CODE_NONE with
        CAN_ACC_MASK_NONE.
        """
        extended = is_extended(select)
        self._filters().set_acceptance(_pattern("code", code), _pattern("mask", mask), extended=extended)

    @vci_call
    def add_filter_ids(self, select: int, code: int, mask: int) -> None:
        """AddFilterIds: add each identifier that matches the pattern to the list."""
        extended = is_extended(select)
        self._filters().add_ids(_pattern("code", code), _pattern("mask", mask), extended=extended)

    @vci_call
    def rem_filter_ids(self, select: int, code: int, mask: int) -> None:
        """RemFilterIds: remove each identifier that matches the pattern from the list."""
        extended = is_extended(select)
        self._filters().remove_ids(_pattern("code", code), _pattern("mask", mask), extended=extended)


class FilterModes(FilterLists):
    """Filters whose mode can be chosen: CAN_FILTER_LOCK, PASS, INCL or EXCL."""

    @vci_call
    def get_filter_mode(self, select: int) -> int:
        """GetFilterMode: the present CAN_FILTER_ mode."""
        return self._filters().filter_mode(extended=is_extended(select))

    @vci_call
    def set_filter_mode(self, select: int, mode: int) -> int:
        """SetFilterMode: set a CAN_FILTER_ mode; returns the previous one."""
        within("mode", mode, CAN_FILTER_LOCK, CAN_FILTER_EXCL)
        return self._filters().set_filter_mode(mode, extended=is_extended(select))


def _pattern(name: str, value: int) -> int:
    return within(name, value, 0, UINT32)
