"""Where `canwire dump` puts what it hears: lines on stdout, or packets for Wireshark."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from canwire.commands.dump.printing import Printer
from canwire.commands.live.listening import Record

_SIGNS = "|/-\\"


class Output(Protocol):
    """What takes records of lines."""

    def put(self, name: str, records: Sequence[Record], most: int | None) -> int:
        """As many of a line's records as may be shown, `most` at most (None: all); how many these were."""

    def flush(self) -> None:
        """Hand it on."""

    def end(self, lost: Callable[[], Mapping[str, int]]) -> None:
        """Nothing more comes; `lost` tells how many records of each line were lost."""


class Lines:
    """Text on stdout; `silent` as candump's -s has it: 0 lines, 1 a sign that turns with each, 2 nothing."""

    def __init__(self, printer: Printer, silent: int = 0) -> None:
        self._printer = printer
        self._silent = silent
        self._turned = 0

    def put(self, name: str, records: Sequence[Record], most: int | None) -> int:
        lines = self._printer.lines(name, records)[:most]
        if lines and self._silent == 0:
            sys.stdout.write("\n".join(lines) + "\n")
        elif lines and self._silent == 1:
            self._turned += len(lines)
            sys.stdout.write(f"{_SIGNS[self._turned % len(_SIGNS)]}\b")
        return len(lines)

    def flush(self) -> None:
        sys.stdout.flush()

    def end(self, lost: Callable[[], Mapping[str, int]]) -> None:
        """Said on stderr, where all numbers are."""
