"""The setting that a dongle keeps without power: whether received frames get a time stamp (Z)."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Protocol


class Eeprom(Protocol):
    """Returns the stored setting; False if none was stored."""

    def load(self) -> bool: ...
    def save(self, stamps: bool) -> None: ...


class MemoryEeprom:
    """Stores the setting in this object only."""

    def __init__(self) -> None:
        self.stamps = False

    def load(self) -> bool:
        return self.stamps

    def save(self, stamps: bool) -> None:
        self.stamps = stamps


class FileEeprom:
    """Stores the setting in one file for each dongle, `Z0` or `Z1`. A file that cannot be read or written raises no
    error, as a dongle works with a worn-out EEPROM: the setting is then the one of a new dongle at the next start."""

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
