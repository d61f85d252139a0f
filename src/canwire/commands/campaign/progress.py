"""How far a campaign is: its runs as they come."""

from __future__ import annotations

import time

from canwire import CampaignRun
from canwire.commands.shell import progress


class Progress:
    """Counts runs as they come; of `total`, if the command line says how many."""

    def __init__(self, total: int | None = None, *, quiet: bool = False) -> None:
        self.done = 0
        self._bad = 0
        self._began = time.monotonic()
        self._shown = progress.Progress(total, "campaign", unit=" runs", lines=True, quiet=quiet)

    def count(self, run: CampaignRun) -> None:
        """One more."""
        self.done += 1
        self._bad += not run.passed
        rate = self.done / max(1e-9, time.monotonic() - self._began)
        self._shown.show(self.done, f", {self._bad} not passed, {rate:.0f} runs/s")

    def end(self) -> None:
        """Its line is free for what follows."""
        self._shown.__exit__()
