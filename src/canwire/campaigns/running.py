"""Plays a whole campaign on processes of this machine or on a cluster, or repeats one of its runs."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

from canwire.campaigns.batches import Rules
from canwire.campaigns.campaign import MOST_RUNS, Campaign
from canwire.campaigns.change import Change
from canwire.campaigns.cluster import in_cluster
from canwire.campaigns.journal import Journal, journal_of
from canwire.campaigns.junit import Played, check_report, write_junit
from canwire.campaigns.limit import limit_of
from canwire.campaigns.loading import Script, script_of
from canwire.campaigns.page import write_page
from canwire.campaigns.parameters import Value
from canwire.campaigns.playing import CampaignRun, Order, play
from canwire.campaigns.shrinking.shrink import smallest_cause
from canwire.campaigns.table import check_table, write
from canwire.campaigns.workers import in_processes
from canwire.errors import BadValue
from canwire.values.checks import whole

_MOST_WORKERS = 4096
_MOST_SEED = 1 << 63
_MOST_SHRUNK = 5


def run_campaign(
    campaign: Campaign | str | Path,
    *,
    runs: int | None = None,
    seed: int = 1,
    workers: int | None = None,
    cluster: str | None = None,
    results: str | Path | None = None,
    time_limit: float | None = None,
    report: str | Path | None = None,
    shrink: int = 0,
    told: Callable[[CampaignRun], object] | None = None,
) -> list[CampaignRun]:
    """Play a campaign, or the only one in a file. Returns the results of all runs in the order of their numbers.

    `runs` is the number of runs (None: the grid of its lists once), `workers` the number of processes (None: one per
    processor), `cluster` the address of a Dask scheduler, "dask://host:8786", in place of processes. `results` is a
    Parquet or CSV file for the table, which is always written: after Ctrl-C it contains the runs that were done. Until
    all runs are done, a journal beside it contains each finished run, even after a kill; the same call then plays only
    the missing runs. `report` is an .xml file for JUnit XML, or an .html file for a page that shows which parameters
    fail; it is written together with the table, completely or not at all.
    `shrink` searches for the smallest cause of the first run of each failure, of five failures at most, with up to
    `shrink` runs each (0: no search), as `shrink_run` does. The cause is in `smallest` of that run, and in the report.
    `told` is called with each run when it is done, in any order. A run that takes longer than `time_limit` seconds
    (None: no limit) is ended, and its verdict is "timeout". Each worker reads the file again: a script that calls this
    function does so under `if __name__ == "__main__"`.

    Raises BadValue, ExtraMissing, HubError (no cluster, or workers that cannot load the file), OSError. Exceptions of a
    run are in its row.
    """
    script = script_of(campaign)
    made = script.load()
    count = whole("runs", made.space.size if runs is None else runs, 1, MOST_RUNS)
    rules = Rules(whole("seed", seed, 0, _MOST_SEED), limit_of(time_limit))
    account = _Account(script, Played(script.path, made.name, rules.seed), count, results, report)
    try:
        for batch in _batches(script, account.missing(), rules, workers, cluster):
            account.write(batch)
            if told is not None:
                for run in batch:
                    told(run)
        if shrink:
            account.shrink(shrink, time_limit)
    finally:
        account.close()
    return [account.done[number] for number in sorted(account.done)]


class _Account:
    """The runs that are done, and the files they are written to. Raises the files' errors before any run is played."""

    def __init__(
        self,
        script: Script,
        played: Played,
        count: int,
        results: str | Path | None,
        report: str | Path | None,
    ) -> None:
        self._script = script
        self._played = played
        self._count = count
        self._results = None if results is None else check_table(results)
        self._report = None if report is None else check_report(report)
        self._journal: Journal | None = None
        self.done: dict[int, CampaignRun] = {}
        if self._results is not None:
            self._journal = Journal(journal_of(self._results), script, played.name, played.seed)
            self.done = {number: run for number, run in self._journal.runs.items() if number < count}

    def missing(self) -> Sequence[int]:
        numbers = range(self._count)
        return [number for number in numbers if number not in self.done] if self.done else numbers

    def write(self, batch: list[CampaignRun]) -> None:
        self.done.update({run.number: run for run in batch})
        if self._journal is not None:
            self._journal.write(batch)

    def shrink(self, most_runs: int, time_limit: float | None) -> None:
        """Add the smallest cause to the first run of each failure, or a note if the run now passes."""
        first: dict[tuple[str, str], CampaignRun] = {}
        for _, run in sorted(self.done.items()):
            if not run.passed:
                first.setdefault((run.verdict, run.place), run)
        for run in islice(first.values(), _MOST_SHRUNK):
            try:
                words = str(
                    smallest_cause(self._script, run.number, self._played.seed, most_runs, time_limit)
                )
            except BadValue as error:
                words = str(error)
            self.done[run.number] = replace(run, smallest=words)

    def close(self) -> None:
        """Write the report and the table; the journal is removed once the table contains all runs."""
        if self._report is not None and self.done:
            form = write_page if self._report.suffix == ".html" else write_junit
            form(self._report, self._played, self.done.values())
        if self._results is not None and self._journal is not None:
            if self.done:
                write(self._results, self.done.values())
            some_missing = bool(self.done) and len(self.done) < self._count
            self._journal.close(not some_missing and max(self._journal.runs, default=0) < self._count)


def repeat_run(
    campaign: Campaign | str | Path,
    number: int,
    *,
    seed: int = 1,
    name: str = "",
    time_limit: float | None = None,
    given: Mapping[str, Value] | None = None,
    only: Mapping[str, Iterable[int] | str] | None = None,
    flips: Iterable[str] = (),
) -> tuple[CampaignRun, list[str]]:
    """Repeat run `number` in this process. Returns its result, and its frames as lines of a candump log.

    `given` replaces parameters. `only` selects by kind ("frames", "faults", "noise") the numbers that take place,
    counted from 0 in the order in which the script requests them; text such as "3,7-9" or "none" is accepted. See
    `shrink_run`. `flips` are additional inverted bits, such as "can0:103:45": bit 45 of the first frame 0x103 on bus
    can0.

    A KeyboardInterrupt ends the run with a verdict, so Ctrl-C shows where it was. After `time_limit` seconds (None: no
    limit) the run is ended at the next bytecode of Python.
    """
    log: list[str] = []
    script, limit_s = script_of(campaign, name), limit_of(time_limit)
    change = Change.of(given, only, flips) if given or only or flips else None
    run = play(
        script.load(), Order(number, change), whole("seed", seed, 0, _MOST_SEED), log=log, limit_s=limit_s
    )
    return run, log


def _batches(
    script: Script, numbers: Sequence[int], rules: Rules, workers: int | None, cluster: str | None
) -> Iterator[list[CampaignRun]]:
    if not numbers:
        return iter(())
    if cluster is not None:
        return in_cluster(script, numbers, rules, cluster)
    processes = min(len(numbers), whole("workers", workers or os.cpu_count() or 1, 1, _MOST_WORKERS))
    return in_processes(script, numbers, rules, processes)
