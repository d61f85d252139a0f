"""The receive window: the events of one handle, its event mask and its acceptance filter.

Source: CANDRV manual, 10.4, receive dialog; rulings.md 31 and 33.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadValue
from canwire.candrv import (
    CAN_ACCEPTANCE_FILTER,
    EVERY_EVENT,
    CanbusEvent,
    CanMode,
    Command,
    Filter,
)
from canwire.web.cancheck.listing import Listing, event_row

if TYPE_CHECKING:
    from canwire.candrv import Handle

KINDS = (
    CanbusEvent.RECEIVED,
    CanbusEvent.TRANSMITTED,
    CanbusEvent.ENTERING_STANDBY,
    CanbusEvent.LEAVING_STANDBY,
    CanbusEvent.OVERRUN,
    CanbusEvent.ABORTED,
    CanbusEvent.WARNING,
    CanbusEvent.BUS_ERROR,
    CanbusEvent.PASSIVE,
    CanbusEvent.ARBITRATION_LOST,
    CanbusEvent.DEVICE_CHANGED,
)
"""In the order of the manual's table of icons."""


class FilterRows(NamedTuple):
    """The filter, with 0, 1 or + for each bit: the identifier, then a space and the first two data bytes.

    `extended` is "" in CAN2.0A."""

    standard: str
    extended: str


class ReceiveWindow:
    """`take` moves events from the handle to the list without waiting. Methods raise CandrvError."""

    kind = "receive"

    def __init__(self, number: int, handle: Handle, changed: Callable[[], None] = lambda: None) -> None:
        self.number = number
        self.handle = handle
        self.list = Listing(changed)
        self.trouble = ""
        self._changed = changed
        self._filter = Filter.registered(handle.device.settings)

    def take(self) -> int:
        """Move the waiting events to the list; returns their number."""
        count = self.handle.waiting
        self.list.append(*(event_row(self.handle.read_event()) for _ in range(count)))
        return count

    def wait(self) -> None:
        """Wait until there is an event to take, or the handle is closed."""
        self.handle.wait_comm_event()

    def clear_overrun(self) -> None:
        """Execute CANBUS_CMD_CLEAR_OVERRUN."""
        self.handle.command(Command.CLEAR_OVERRUN)

    @property
    def mask(self) -> int:
        return self.handle.mask

    @mask.setter
    def mask(self, mask: int) -> None:
        """Set the event mask immediately; waiting events that it excludes are discarded, and count as lost."""
        if mask & ~int(EVERY_EVENT):  # ~ of a flag would leave out the bits that it has no name for
            raise BadValue(f"event mask {mask:X}: {int(EVERY_EVENT):X} has all types")
        self.handle.mask = mask
        self._changed()

    def toggle(self, kind: int) -> None:
        """Switch one type of event on or off; raises BadValue for an unknown type."""
        if kind not in [int(one) for one in KINDS]:
            raise BadValue(f"event type {kind:X}: one of {', '.join(f'{int(one):X}' for one in KINDS)}")
        self.mask = self.mask ^ kind

    @property
    def filter(self) -> Filter:
        return self._filter

    def set_filter(self, code: int, mask: int) -> None:
        settings = self.handle.device.settings
        chosen = Filter(code, mask, settings.align, settings.mask_active)
        self.handle.filter = CAN_ACCEPTANCE_FILTER(code, mask)
        self._filter = chosen
        self._changed()

    def filter_rows(self) -> FilterRows:
        """The rows for the present filter, with the Align and MaskActive with which the driver was loaded."""
        standard = self._filter.bits(False)
        if self._filter.data_bits:
            standard += " " + self._filter.data_bits
        extended = self._filter.bits(True) if self.handle.can_mode == CanMode.CAN_2_0_B else ""
        return FilterRows(standard, extended)

    def close(self) -> None:
        """Close the log and the handle; a second call does nothing."""
        self.list.close_log()
        self.handle.close()
