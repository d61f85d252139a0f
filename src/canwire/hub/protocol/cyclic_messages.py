"""Requests to the cyclic transmit list of a line."""

from __future__ import annotations

from canwire.hub.protocol.message import Message


class OpenScheduler(Message):
    """-> Opened. One at a time for each line."""

    board: int
    line: int
    kin: str = ""


class AddCyclic(Message):
    """Scheduler -> Number: its index. `record` is the frame's 80 bytes, request bits included."""

    handle: int
    record: bytes
    cycle: int
    increment: int
    byte_index: int
    channel: int = 0  # of this client, whose own frames these are; 0: none's


class ReplaceCyclic(Message):
    """Scheduler -> None: replace the frame; the ticks stay the same."""

    handle: int
    index: int
    record: bytes


class StartInTurn(Message):
    """Scheduler -> None: one after the other, `step` ticks apart, the first one in the next tick."""

    handle: int
    indices: tuple[int, ...]
    counts: tuple[int, ...]
    step: int


class RemoveCyclic(Message):
    """Scheduler -> None"""

    handle: int
    index: int


class StartCyclic(Message):
    """Scheduler -> None; `count` 0: until it is stopped."""

    handle: int
    index: int
    count: int


class StopCyclic(Message):
    """Scheduler -> None"""

    handle: int
    index: int


class RunScheduler(Message):
    """Scheduler -> None: resume or suspend the task."""

    handle: int
    running: bool


class ResetScheduler(Message):
    """Scheduler -> None"""

    handle: int


class GetSchedulerStatus(Message):
    """Scheduler -> SchedulerState"""

    handle: int
