"""What sources on shared lines have in common: the recorder's thread empties them, `closing` has what they hold."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack


class HubSource:
    """`channel` is its name in the log; times become those of the wall clock by `epoch_ns`."""

    def __init__(self, name: str, epoch_ns: int, closing: ExitStack) -> None:
        self.channel = name
        self.epoch_ns = epoch_ns
        self._closing = closing

    def start(self, drain: Callable[[], None]) -> bool:
        del drain
        return False

    def close(self) -> None:
        self._closing.close()
