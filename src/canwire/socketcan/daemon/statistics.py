"""`< statistics 1000 >`: reports the traffic of a client's bus at an interval in milliseconds."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import BadText

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from canwire.socketcan.loop import Loop, Timer

_LONGEST_INTERVAL_MS = 1 << 31


class Statistics:
    """Frames and their bytes, received and sent; `tell` sends the report to the client."""

    def __init__(self, loop: Loop, tell: Callable[[str], object]) -> None:
        self._loop = loop
        self._tell = tell
        self._timer: Timer | None = None
        self._received = [0, 0]
        self._sent = [0, 0]

    def receive(self, size: int) -> None:
        self._received[0] += 1
        self._received[1] += size

    def send(self, size: int) -> None:
        self._sent[0] += 1
        self._sent[1] += size

    def ask(self, words: Sequence[str]) -> None:
        """Execute the command; interval 0 ends the reports. Raises BadText."""
        if len(words) != 2 or not words[1].isdecimal() or int(words[1]) > _LONGEST_INTERVAL_MS:
            raise BadText("statistics: an interval in milliseconds")
        self.stop()
        if interval_ms := int(words[1]):
            self._wait(interval_ms / 1000)

    def stop(self) -> None:
        """Stops the reports."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def _wait(self, interval_s: float) -> None:
        self._timer = self._loop.call_in(interval_s, lambda: self._due(interval_s))

    def _due(self, interval_s: float) -> None:
        self._wait(interval_s)
        self._tell(f"< stat {self._received[1]} {self._received[0]} {self._sent[1]} {self._sent[0]} >")
