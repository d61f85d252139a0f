"""The rests of messages that do not fit into a socket pair: the first bytes use the pair, the rest a request."""

from __future__ import annotations

import errno

from canwire.socketcan.ports import refuse

LARGEST_IN_PAIR = 65_536  # bytes
HAS_REST = 8  # a flag of such a message: shim/shim.h
_MOST = 16


class Rests:
    """The rests of one socket's messages. If a program reads without the library, the oldest rests are dropped."""

    def __init__(self) -> None:
        self._rests: dict[int, bytes] = {}
        self._next = 0

    def keep(self, rest: bytes) -> int:
        """Keep a rest; returns its number, 1 to 255, or 0 if it is empty."""
        if not rest:
            return 0
        if len(self._rests) >= _MOST:
            self._rests.pop(next(iter(self._rests)))
        self._next = self._next % 255 + 1
        self._rests[self._next] = rest
        return self._next

    def take(self, number: int) -> bytes:
        """Remove and return a rest; raises OSError: ENOBUFS if it was dropped."""
        if number not in self._rests:
            raise refuse(errno.ENOBUFS)
        return self._rests.pop(number)
