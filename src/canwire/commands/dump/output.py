"""Where `canwire dump` puts what it hears: lines on stdout, or packets for Wireshark."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from canwire.commands.dump.printing import Printer
from canwire.commands.live.listening import Record


class Output(Protocol):
    """What takes records of lines."""

    def put(self, name: str, records: Sequence[Record], most: int | None) -> int:
        """As many of a line's records as may be shown, `most` at most (None: all); how many these were."""

    def flush(self) -> None:
        """Hand it on."""

    def end(self, lost: Callable[[], Mapping[str, int]]) -> None:
        """Nothing more comes; `lost` tells how many records of each line were lost."""


class Lines:
    """Text on stdout."""

    def __init__(self, printer: Printer) -> None:
        self._printer = printer

    def put(self, name: str, records: Sequence[Record], most: int | None) -> int:
        lines = self._printer.lines(name, records)[:most]
        if lines:
            sys.stdout.write("\n".join(lines) + "\n")
        return len(lines)

    def flush(self) -> None:
        sys.stdout.flush()

    def end(self, lost: Callable[[], Mapping[str, int]]) -> None:
        """Said on stderr, where all numbers are."""
