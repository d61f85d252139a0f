"""Batches on this machine's processes; a run that takes its process down is found and named."""

from __future__ import annotations

import multiprocessing
from collections.abc import Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool

from canwire.campaigns.batches import Batch, batches, play_batch
from canwire.campaigns.campaign import Campaign
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun

_AHEAD = 2  # batches handed out a worker: its next one waits for it


def in_processes(
    script: Script, numbers: Sequence[int], seed: int, workers: int
) -> Iterator[list[CampaignRun]]:
    """Play the runs on so many processes; batches come as they are done."""
    suspects: list[Batch] = []
    rest = batches(numbers, workers)
    while True:
        yield from _until_broken(script, rest, seed, workers, suspects)
        if not suspects:
            return
        for number in [number for batch in suspects for number in batch]:
            yield [_alone(script, number, seed)]
        suspects.clear()


def _until_broken(
    script: Script, rest: Iterator[Batch], seed: int, workers: int, suspects: list[Batch]
) -> Iterator[list[CampaignRun]]:
    """Until all is done, or a process has ended: what was under way then is `suspects`."""
    under_way: dict[Future[list[CampaignRun]], Batch] = {}
    with _pool(workers) as pool:
        try:
            while True:
                while len(under_way) < workers * _AHEAD and (batch := next(rest, None)) is not None:
                    _hand_out(pool, script, batch, seed, under_way, suspects)
                if not under_way:
                    return
                for done in wait(under_way, return_when=FIRST_COMPLETED).done:
                    runs = done.result()
                    del under_way[done]
                    yield runs
        except BrokenProcessPool:
            suspects += sorted(under_way.values())
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _hand_out(
    pool: ProcessPoolExecutor,
    script: Script,
    batch: Batch,
    seed: int,
    under_way: dict[Future[list[CampaignRun]], Batch],
    suspects: list[Batch],
) -> None:
    """A batch that comes too late for a broken pool is played alone as well: it is nowhere else."""
    try:
        under_way[pool.submit(play_batch, script, batch, seed)] = batch
    except BrokenProcessPool:
        suspects.append(batch)
        raise


def _alone(script: Script, number: int, seed: int) -> CampaignRun:
    """This run in a process of its own: if that ends, it was this run."""
    with _pool(1) as pool:
        try:
            return pool.submit(play_batch, script, (number,), seed).result()[0]
        except BrokenProcessPool:
            return crashed(script.load(), number, seed)


def crashed(campaign: Campaign, number: int, seed: int) -> CampaignRun:
    """What there is to say of a run whose process ended."""
    own_seed = campaign.seed_of(number, seed)
    return CampaignRun(
        number, own_seed, campaign.space.at(number, own_seed), "crashed", "its process ended by itself"
    )


def _pool(workers: int) -> ProcessPoolExecutor:
    return ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
