"""Batches on this machine's processes; a run that takes its process down is found and named."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.connection import Connection

from canwire.campaigns.batches import Batch, Rules, batches, play_batch
from canwire.campaigns.campaign import Campaign
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun, late, play

_AHEAD = 2  # batches handed out a worker: its next one waits for it


def in_processes(
    script: Script, numbers: Sequence[int], rules: Rules, workers: int
) -> Iterator[list[CampaignRun]]:
    """Play the runs on so many processes; batches come as they are done."""
    suspects: list[Batch] = []
    rest = batches(numbers, workers)
    while True:
        yield from _until_broken(script, rest, rules, workers, suspects)
        if not suspects:
            return
        for number in [number for batch in suspects for number in batch]:
            yield [_alone(script, number, rules)]
        suspects.clear()


def _until_broken(
    script: Script, rest: Iterator[Batch], rules: Rules, workers: int, suspects: list[Batch]
) -> Iterator[list[CampaignRun]]:
    """Until all is done, or a process has ended: what was under way then is `suspects`."""
    under_way: dict[Future[list[CampaignRun]], Batch] = {}
    pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    try:
        while True:
            while len(under_way) < workers * _AHEAD and (batch := next(rest, None)) is not None:
                _hand_out(pool, script, batch, rules, under_way, suspects)
            if not under_way:
                return
            for done in wait(under_way, return_when=FIRST_COMPLETED).done:
                runs = done.result()
                del under_way[done]
                yield runs
    except BrokenProcessPool:
        suspects += sorted(under_way.values())
    finally:
        # without waiting, the pool's thread closes a pipe that the interpreter's end writes to: "Bad file descriptor"
        pool.shutdown(wait=True, cancel_futures=True)


def _hand_out(
    pool: ProcessPoolExecutor,
    script: Script,
    batch: Batch,
    rules: Rules,
    under_way: dict[Future[list[CampaignRun]], Batch],
    suspects: list[Batch],
) -> None:
    """A batch that comes too late for a broken pool is played alone as well: it is nowhere else."""
    try:
        under_way[pool.submit(play_batch, script, batch, rules)] = batch
    except BrokenProcessPool:
        suspects.append(batch)
        raise


def _alone(script: Script, number: int, rules: Rules) -> CampaignRun:
    """This run in a process of its own: if that ends, it was this run."""
    context = multiprocessing.get_context("spawn")
    told, telling = context.Pipe(duplex=False)
    process = context.Process(target=_play_alone, args=(telling, script, number, rules), daemon=True)
    process.start()
    telling.close()
    try:
        told.recv()  # it has begun
        if rules.limit_s is not None and not told.poll(rules.limit_s + rules.grace_s):
            return late(script.load(), number, rules.seed, rules.limit_s)
        run: CampaignRun = told.recv()
        return run
    except EOFError:
        return crashed(script.load(), number, rules.seed)
    finally:
        process.kill()
        process.join()
        told.close()


def _play_alone(telling: Connection, script: Script, number: int, rules: Rules) -> None:
    """In that process, which whoever started it ends."""
    campaign = script.load()
    telling.send(None)
    telling.send(play(campaign, number, rules.seed, limit_s=rules.limit_s))


def crashed(campaign: Campaign, number: int, seed: int) -> CampaignRun:
    """What there is to say of a run whose process ended."""
    own_seed = campaign.seed_of(number, seed)
    return CampaignRun(
        number, own_seed, campaign.space.at(number, own_seed), "crashed", "its process ended by itself"
    )
