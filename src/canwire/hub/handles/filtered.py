"""Frame filters: a control sets those of its line, a channel sets its own."""

from __future__ import annotations

from canwire.hub.handles.lease import Lease
from canwire.hub.protocol import messages as m


class Filtered(Lease):
    """The filters of a control or a channel: one for 11-bit and one for 29-bit frames, with two stages each.

    Code and mask are VCI's: id << 1 | remote, a mask bit of 1 compares (VCI V4 manual 5.2.4). Filters change
    only while the line is stopped or the channel inactive, else WrongState.
    """

    def filter_mode(self, *, extended: bool) -> int:
        """The present FilterMode."""
        return int(self.ask(m.GetFilterMode(self._handle, extended)).value)

    def set_filter_mode(self, mode: int, *, extended: bool) -> int:
        """Set the mode; returns the previous one."""
        return int(self.ask(m.SetFilterMode(self._handle, extended, mode)).value)

    def set_acceptance(self, code: int, mask: int, *, extended: bool) -> None:
        """The first stage: one bit pattern."""
        self.ask(m.SetAcceptanceFilter(self._handle, extended, code, mask))

    def add_ids(self, code: int, mask: int, *, extended: bool) -> None:
        """The second stage: add every identifier that matches the pattern to the list."""
        self.ask(m.ListIds(self._handle, extended, code, mask, True))

    def remove_ids(self, code: int, mask: int, *, extended: bool) -> None:
        """Remove every identifier that matches the pattern from the list."""
        self.ask(m.ListIds(self._handle, extended, code, mask, False))
