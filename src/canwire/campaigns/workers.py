"""Plays batches in processes of this machine: one keeper each, which starts another player if a run ends its player."""

from __future__ import annotations

import multiprocessing
from collections import deque
from collections.abc import Iterator, Sequence
from multiprocessing.connection import Connection, wait

from canwire.campaigns.batches import Batch, Rules, batches
from canwire.campaigns.keeping import keep
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun, Order, crashed
from canwire.errors import HubError


def in_processes(
    script: Script, numbers: Sequence[int], rules: Rules, workers: int
) -> Iterator[list[CampaignRun]]:
    """Play the runs on this number of processes; yields each run when it is done.

    Raises HubError if a process ends before it can play, because it cannot load the file.
    """
    rest = batches(numbers, workers)
    crew: dict[Connection, Worker] = {}
    try:
        for batch in _first(rest, workers):
            _employ(crew, Worker(script, rules), batch)
        while crew:
            for pipe in wait(list(crew)):
                worker = crew[pipe]  # type: ignore[index]
                yield from worker.come()
                if worker.lost:
                    del crew[worker.pipe]
                    worker.end()
                    yield from _replace(crew, worker, rest, script, rules)
                elif not worker.rest:
                    _continue(crew, worker, next(rest, None))
    finally:
        for worker in crew.values():
            worker.pipe.close()
        for worker in crew.values():
            worker.end()


def _first(rest: Iterator[Batch], count: int) -> Iterator[Batch]:
    for _ in range(count):
        if (batch := next(rest, None)) is not None:
            yield batch


def _employ(crew: dict[Connection, Worker], worker: Worker, batch: Batch) -> None:
    crew[worker.pipe] = worker
    worker.play(batch)


def _continue(crew: dict[Connection, Worker], worker: Worker, batch: Batch | None) -> None:
    if batch is not None:
        worker.play(batch)
    else:
        del crew[worker.pipe]
        worker.end()


def _replace(
    crew: dict[Connection, Worker], dead: Worker, rest: Iterator[Batch], script: Script, rules: Rules
) -> Iterator[list[CampaignRun]]:
    """A new worker gets the remaining runs of `dead`; a run that was first in two such workers ended them both."""
    suspect = dead.rest[0] if dead.rest else None
    if suspect is not None and dead.suspect == suspect:
        dead.rest.popleft()
        yield [crashed(script.load(), suspect, rules.seed)]
    if batch := tuple(dead.rest) or next(rest, ()):
        _employ(crew, Worker(script, rules, suspect), batch)


class Worker:
    """A keeper's process, as the campaign sees it. `suspect`: the run at which the previous worker was lost."""

    def __init__(self, script: Script, rules: Rules, suspect: Order | None = None) -> None:
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process = context.Process(target=keep, args=(theirs, script, rules))
        self.process.start()
        theirs.close()
        self.rest: deque[Order] = deque()
        self.suspect = suspect
        self.lost = False
        self._ready = False

    def play(self, batch: Batch) -> None:
        """Hand out the next batch."""
        self.rest = deque(batch)
        try:
            self.pipe.send(batch)
        except OSError:  # it has ended, which the next read finds
            self.lost = True

    def come(self) -> Iterator[list[CampaignRun]]:
        """Yield the runs that have arrived. Raises HubError if the process ended before it was ready."""
        try:
            run: CampaignRun | None = self.pipe.recv()
        except (EOFError, OSError):
            self.lost = True
            if not self._ready:
                self.process.join()
                raise HubError(
                    f"a worker of the campaign ended with status {self.process.exitcode} before its first run: "
                    'a script that calls run_campaign() does so under `if __name__ == "__main__":`'
                ) from None
            return
        self._ready = True
        if run is not None:
            self.rest.popleft()
            yield [run]

    def end(self) -> None:
        """Close the pipe; the process ends when it notices that."""
        self.pipe.close()
        self.process.join()
