"""The progress of a campaign: how many runs are done."""

from __future__ import annotations

import time

from canwire import CampaignRun
from canwire.commands.shell import progress


class Progress:
    """Counts finished runs, out of `total` if the command line gives a number."""

    def __init__(self, total: int | None = None, *, quiet: bool = False) -> None:
        self.done = 0
        self._bad = 0
        self._began = time.monotonic()
        self._shown = progress.Progress(total, "campaign", unit=" runs", lines=True, quiet=quiet)

    def count(self, run: CampaignRun) -> None:
        """Count one finished run, and show the progress."""
        self.done += 1
        self._bad += not run.passed
        rate = self.done / max(1e-9, time.monotonic() - self._began)
        self._shown.show(self.done, f", {self._bad} not passed, {rate:.0f} runs/s")

    def end(self) -> None:
        """End the progress line, so that other output can follow."""
        self._shown.end()
