"""The pace of the host's bytes: that of a serial line, or as fast as the host writes."""

from __future__ import annotations

_BITS = 10  # a byte on a serial line: start bit, eight, stop bit
_BEHIND_S = 0.05  # a loop that comes late catches up with this much at most


class Pace:
    """Holds bytes of the host until a serial line would have carried them, one command at a time.

    With `baud_rate` 0 all bytes are due immediately. No further bytes are read while some are held, so a host that
    writes too fast has to wait in its write.
    """

    def __init__(self, baud_rate: int = 0) -> None:
        self._byte_s = _BITS / baud_rate if baud_rate else 0.0
        self._left = bytearray()
        self._free_s = 0.0

    def __bool__(self) -> bool:
        """True while bytes are held."""
        return bool(self._left)

    @property
    def paced(self) -> bool:
        """True if there is a baud rate."""
        return self._byte_s > 0

    def put(self, data: bytes) -> None:
        self._left += data

    def due(self, now_s: float) -> bytes:
        """The next command, or the part of it that is here, if it is due; else b"". Without a rate, all bytes."""
        self._free_s = max(self._free_s, now_s - _BEHIND_S)
        if self._free_s > now_s:
            return b""
        length = (self.paced and self._left.find(b"\r") + 1) or len(self._left)
        data = bytes(self._left[:length])
        del self._left[:length]
        self._free_s += length * self._byte_s
        return data

    def wait_s(self, now_s: float) -> float | None:
        """Seconds until the next command is due; None if no bytes are held."""
        return max(0.0, self._free_s - now_s) if self._left else None
