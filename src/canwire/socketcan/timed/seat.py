"""A thread of a SocketCAN program that takes part in its hub's time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from canwire.socketcan.timed.children import is_below

NEVER = (1 << 63) - 1


class Seat:
    """A thread that takes part: it runs, or waits for `give`. `round` is the server's turn in which it had its last.

    One that `sleeps` waits for nothing but its time, and one with `children` for the end of one of these processes.
    """

    def __init__(self, process: int) -> None:
        self.process = process
        self.give: Callable[[], object] | None = None
        self.until_ns = NEVER
        self.looks = False
        self.sleeps = False
        self.children: list[int] = []
        self.round = -1

    def runs(self, processes: Sequence[int]) -> bool:
        """So does who waits for a child, as long as neither that nor what it has started is one of these processes."""
        if self.give is None or not self.children or self.looks:
            return self.give is None
        return not any(is_below(process, child) for child in self.children for process in processes)
