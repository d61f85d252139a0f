"""Requests to a channel that is already set up."""

from __future__ import annotations

from canwire.boards.can.modes import FilterContent
from canwire.hub.protocol.message import Message


class ReplaceFilters(Message):
    """Channel -> None; both filters in one step, also while it is active."""

    handle: int
    standard: FilterContent
    extended: FilterContent


class CountRefused(Message):
    """Channel -> None: this many frames of the client found no room in its queue."""

    handle: int
    count: int
