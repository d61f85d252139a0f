"""What a dongle remembers without power: whether received frames get a time stamp (Z)."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Protocol


class Eeprom(Protocol):
    """Reads as it was left; a new one reads False."""

    def load(self) -> bool: ...
    def save(self, stamps: bool) -> None: ...


class MemoryEeprom:
    """Lasts as long as the object."""

    def __init__(self) -> None:
        self.stamps = False

    def load(self) -> bool:
        return self.stamps

    def save(self, stamps: bool) -> None:
        self.stamps = stamps


class FileEeprom:
    """One file per dongle, `Z0` or `Z1`. One that cannot be read counts as new, one that cannot be written is new
    the next time: a dongle whose EEPROM is worn out works all the same."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)

    def load(self) -> bool:
        try:
            return self.path.read_bytes().strip() == b"Z1"
        except OSError:
            return False

    def save(self, stamps: bool) -> None:
        with contextlib.suppress(OSError):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            new = self.path.with_name(self.path.name + ".new")
            new.write_bytes(b"Z1\n" if stamps else b"Z0\n")
            new.replace(self.path)
