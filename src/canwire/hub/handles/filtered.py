"""What lets only some frames through: a line's control for the line, a channel for its own."""

from __future__ import annotations

from canwire.hub.handles.lease import Lease
from canwire.hub.protocol import messages as m


class Filtered(Lease):
    """A control or a channel: both have a filter for 11-bit and one for 29-bit frames, of two stages each.

    Code and mask are VCI's: id << 1 | remote, a mask bit of 1 compares (VCI V4 manual 5.2.4). Filters change
    only while the line is stopped or the channel inactive, else WrongState.
    """

    def filter_mode(self, *, extended: bool) -> int:
        """FilterMode now."""
        return int(self.ask(m.GetFilterMode(self._handle, extended)).value)

    def set_filter_mode(self, mode: int, *, extended: bool) -> int:
        """Returns the mode before."""
        return int(self.ask(m.SetFilterMode(self._handle, extended, mode)).value)

    def set_acceptance(self, code: int, mask: int, *, extended: bool) -> None:
        """The first stage: one bit pattern."""
        self.ask(m.SetAcceptanceFilter(self._handle, extended, code, mask))

    def add_ids(self, code: int, mask: int, *, extended: bool) -> None:
        """The second stage: put every identifier that agrees with the pattern on the list."""
        self.ask(m.ListIds(self._handle, extended, code, mask, True))

    def remove_ids(self, code: int, mask: int, *, extended: bool) -> None:
        """Take them off the list."""
        self.ask(m.ListIds(self._handle, extended, code, mask, False))
