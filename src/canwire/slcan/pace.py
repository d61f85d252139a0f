"""How fast the host's bytes come in: as a serial line would bring them, or as they are written."""

from __future__ import annotations

_BITS = 10  # a byte on a serial line: start bit, eight, stop bit
_BEHIND_S = 0.05  # a loop that comes late catches up with this much at most


class Pace:
    """What the host has written and the line has not brought yet, a command at a time; `baud_rate` 0: all at once.

    Nobody reads on while something is left in here, so a host that writes too fast has to wait in its own write.
    """

    def __init__(self, baud_rate: int = 0) -> None:
        self._byte_s = _BITS / baud_rate if baud_rate else 0.0
        self._left = bytearray()
        self._free_s = 0.0

    def __bool__(self) -> bool:
        """Something is left."""
        return bool(self._left)

    @property
    def paced(self) -> bool:
        """There is a rate."""
        return self._byte_s > 0

    def put(self, data: bytes) -> None:
        self._left += data

    def due(self, now_s: float) -> bytes:
        """The next command, or what there is of it, if the line has brought it by now, else b""; unpaced: all."""
        self._free_s = max(self._free_s, now_s - _BEHIND_S)
        if self._free_s > now_s:
            return b""
        length = (self.paced and self._left.find(b"\r") + 1) or len(self._left)
        data = bytes(self._left[:length])
        del self._left[:length]
        self._free_s += length * self._byte_s
        return data

    def wait_s(self, now_s: float) -> float | None:
        """Until the next is due; None if nothing is left."""
        return max(0.0, self._free_s - now_s) if self._left else None
