"""Plays many changed runs one after the other, in a separate process, because a run may end its process."""

from __future__ import annotations

from canwire.campaigns.batches import Rules
from canwire.campaigns.change import Change
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun, Order, crashed
from canwire.campaigns.workers import Worker


class Spent(Exception):
    """Raised when all trials are used up."""


class Trials:
    """Plays at most `most` runs; a change that was already tried is not played again."""

    def __init__(self, script: Script, rules: Rules, most: int) -> None:
        self.script = script
        self.rules = rules
        self.count = 0
        self._most = most
        self._worker: Worker | None = None
        self._known: dict[str, CampaignRun] = {}

    def play(
        self, number: int, change: Change, *, words: bool = False, until_ns: int | None = None
    ) -> CampaignRun:
        """Play run `number` with these changes. Raises Spent when no trial is left, and BadValue, HubError."""
        key = f"{number} {words} {change.options()}"
        if key not in self._known:
            if self.count >= self._most and not words:
                raise Spent
            self.count += not words
            self._known[key] = self._played(Order(number, change, words, until_ns))
        return self._known[key]

    def close(self) -> None:
        """End the process."""
        if self._worker is not None:
            self._worker.end()
            self._worker = None

    def _played(self, order: Order) -> CampaignRun:
        if self._worker is None:
            self._worker = Worker(self.script, self.rules)
        self._worker.play((order,))
        while not self._worker.lost:
            for (run,) in self._worker.come():
                return run
        self.close()  # the run has killed the keeper of its process, too
        return crashed(self.script.load(), order, self.rules.seed)
