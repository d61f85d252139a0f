"""Two error counters and what they make of a node: the twelve rules, one line each.

Source: ISO 11898-1:2015 12.1.4; reference/can-protocol.md section 7.
"""

from __future__ import annotations

ACTIVE, WARNING, PASSIVE, BUS_OFF, STOPPED = range(5)


class Confinement:
    """TEC and REC. TEC stays at 256 in bus-off, REC is held at 255 (both as registers show them)."""

    def __init__(self, tec: int = 0, rec: int = 0) -> None:
        self.tec = tec
        self.rec = rec

    def state(self) -> int:
        """Rules 9, 10 and 11, and the warning limit."""
        if self.tec >= 256:
            return BUS_OFF
        if max(self.tec, self.rec) >= 128:
            return PASSIVE
        return WARNING if max(self.tec, self.rec) >= 96 else ACTIVE

    def transmitter_error(self) -> None:
        """Rules 3, 4 and 6."""
        self.tec = min(self.tec + 8, 256)

    def receiver_error(self) -> None:
        """Rule 1."""
        self.rec = min(self.rec + 1, 255)

    def severe_receiver_error(self) -> None:
        """Rules 2, 5 and 6."""
        self.rec = min(self.rec + 8, 255)

    def transmitted(self) -> None:
        """Rule 7."""
        self.tec = max(self.tec - 1, 0)

    def received(self) -> None:
        """Rule 8."""
        if self.rec > 127:
            self.rec = 127
        elif self.rec:
            self.rec -= 1
