"""Messages longer than what a socket pair has room for: their first bytes come by that, the rest is asked for."""

from __future__ import annotations

import errno

from canwire.socketcan.ports import refuse

LARGEST_IN_PAIR = 65_536  # bytes
HAS_REST = 8  # a flag of such a message: shim/shim.h
_MOST = 16


class Rests:
    """Of one socket's messages; who reads past the library does not ask for them, so the oldest ones go."""

    def __init__(self) -> None:
        self._rests: dict[int, bytes] = {}
        self._next = 0

    def keep(self, rest: bytes) -> int:
        """Its number, 1 to 255; 0 where there is none."""
        if not rest:
            return 0
        if len(self._rests) >= _MOST:
            self._rests.pop(next(iter(self._rests)))
        self._next = self._next % 255 + 1
        self._rests[self._next] = rest
        return self._next

    def take(self, number: int) -> bytes:
        """Raises OSError: ENOBUFS where it has gone."""
        if number not in self._rests:
            raise refuse(errno.ENOBUFS)
        return self._rests.pop(number)
