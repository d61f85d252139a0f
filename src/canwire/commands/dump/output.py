"""Where `canwire dump` writes received records: as lines on stdout, or as packets for Wireshark."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from canwire.commands.dump.printing import Printer
from canwire.commands.live.listening import Record

_SIGNS = "|/-\\"


class Output(Protocol):
    """What takes records of lines; `shown` counts those of each that have gone out, a signal meanwhile or not."""

    shown: defaultdict[str, int]

    def put(self, name: str, records: Sequence[Record], most: int | None) -> int:
        """Print a line's records, at most `most` (None: all); returns their number."""

    def flush(self) -> None:
        """Flush what was printed."""

    def end(self, lost: Callable[[], Mapping[str, int]]) -> None:
        """End the output; `lost` has the number of lost records of each line."""


class Lines:
    """Text on stdout; `silent` as candump's -s has it: 0 lines, 1 a sign that turns with each, 2 nothing."""

    def __init__(self, printer: Printer, silent: int = 0) -> None:
        self.shown: defaultdict[str, int] = defaultdict(int)
        self._printer = printer
        self._silent = silent
        self._turned = 0

    def put(self, name: str, records: Sequence[Record], most: int | None) -> int:
        lines = self._printer.lines(name, records)[:most]
        count = len(lines)
        if not count:
            return 0
        if self._silent:
            self._turned += count
            text = f"{_SIGNS[self._turned % len(_SIGNS)]}\b" if self._silent == 1 else ""
        else:
            text = "\n".join(lines) + "\n"
        self.shown[name] += count  # first: Python lets a signal raise behind a call, here that of `write`
        sys.stdout.write(text)
        return count

    def flush(self) -> None:
        sys.stdout.flush()

    def end(self, lost: Callable[[], Mapping[str, int]]) -> None:
        """Said on stderr, where all numbers are."""
