"""What a client asks of a channel that is set up already."""

from __future__ import annotations

from canwire.boards.can.modes import FilterContent
from canwire.hub.protocol.message import Message


class ReplaceFilters(Message):
    """Channel -> None; both filters in one step, also while it is active."""

    handle: int
    standard: FilterContent
    extended: FilterContent


class CountRefused(Message):
    """Channel -> None; so many frames its client could not queue for want of room in its queue."""

    handle: int
    count: int
