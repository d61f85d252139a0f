"""The programs that have a line open, for reading and for writing, by the rules of Win32 share modes.

Source: CANDRV manual 7.3 and 8.1, CreateFile.
"""

from __future__ import annotations

from dataclasses import dataclass

from canwire.errors import InUse, NoChannel

SHARE_READ, SHARE_WRITE = 1, 2


@dataclass(frozen=True, slots=True)
class Share:
    """One opener: its access, and the access that it permits others (`share`: SHARE_READ, SHARE_WRITE, both or 0)."""

    name: str
    read: bool
    write: bool
    share: int


class Sharing:
    """The openers of one line, with limits for the channels to receive and to send with; 0: any number."""

    def __init__(self, line: str, receive_channels: int = 0, send_channels: int = 0) -> None:
        self._line = line
        self._limits = receive_channels, send_channels
        self._shares: list[Share] = []

    def __len__(self) -> int:
        return len(self._shares)

    def open(self, share: Share) -> None:
        """Add an opener. Raises InUse if the modes exclude each other, NoChannel if all channels are taken."""
        for other in self._shares:
            self._admit(share, other)
        self._check_room("receive", self._limits[0], share.read, sum(other.read for other in self._shares))
        self._check_room("send", self._limits[1], share.write, sum(other.write for other in self._shares))
        self._shares.append(share)

    def close(self, share: Share) -> None:
        """Remove an opener, so that its channels are free; a second call does nothing."""
        self._shares = [other for other in self._shares if other is not share]

    def _admit(self, share: Share, other: Share) -> None:
        for access, bit, what in ((share.read, SHARE_READ, "reading"), (share.write, SHARE_WRITE, "writing")):
            if access and not other.share & bit and (other.read or other.write):
                raise InUse(f"{self._line}: {other.name} has opened it without sharing it for {what}")
        for access, bit, what in ((other.read, SHARE_READ, "reads"), (other.write, SHARE_WRITE, "writes")):
            if access and not share.share & bit and (share.read or share.write):
                raise InUse(f"{self._line}: {other.name} {what} there, and would not be allowed to")

    def _check_room(self, what: str, limit: int, wanted: bool, taken: int) -> None:
        if wanted and limit and taken >= limit:
            raise NoChannel(f"{self._line}: all {limit} {what} channels are taken; close one of them")
