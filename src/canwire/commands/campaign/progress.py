"""How far a campaign is, on one line of a terminal; nothing where stderr is no terminal."""

from __future__ import annotations

import sys
import time

from canwire import CampaignRun

_EVERY_S = 0.2


class Progress:
    """Counts runs as they come."""

    def __init__(self) -> None:
        self.done = 0
        self._bad = 0
        self._began = time.monotonic()
        self._shown = 0.0
        self._terminal = sys.stderr.isatty()

    def count(self, run: CampaignRun) -> None:
        """One more."""
        self.done += 1
        self._bad += not run.passed
        now = time.monotonic()
        if self._terminal and now - self._shown >= _EVERY_S:
            self._shown = now
            self._show(now)

    def end(self) -> None:
        """The last numbers, and a line of its own for what follows."""
        if self._terminal and self.done:
            self._show(time.monotonic())
            print(file=sys.stderr)

    def _show(self, now: float) -> None:
        rate = self.done / max(1e-9, now - self._began)
        print(
            f"\r{self.done} runs, {self._bad} not passed, {rate:.0f} runs/s ",
            end="",
            file=sys.stderr,
            flush=True,
        )
