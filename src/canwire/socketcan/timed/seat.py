"""A thread of a SocketCAN program that takes part in its hub's time."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from canwire.socketcan.timed.children import is_below

NEVER = (1 << 63) - 1


class Seat:
    """A thread that takes part: it runs, or waits for `give`. `round` is the server's turn in which it last ran.

    One that `sleeps` waits only for its time, and one with `children` waits for the end of one of these processes.
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
        """True if it runs, or if it waits for children of which neither they nor descendants are in `processes`."""
        if self.give is None or not self.children or self.looks:
            return self.give is None
        return not any(is_below(process, child) for child in self.children for process in processes)
