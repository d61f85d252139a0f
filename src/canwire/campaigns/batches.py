"""Batches of runs, as a worker plays them on this machine or on a cluster."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import islice
from typing import NamedTuple

from canwire.campaigns.campaign import Campaign
from canwire.campaigns.limit import GRACE_S, process_at_most
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun, Order, play
from canwire.errors import HubError
from canwire.version import __version__

Batch = tuple[Order, ...]
_MOST = 64
_BATCHES_A_WORKER = 16  # of a short campaign: no worker is idle for long at its end


def batches(numbers: Sequence[int], workers: int) -> Iterator[Batch]:
    """Split `numbers` into batches small enough that all workers end at about the same time."""
    size = max(1, min(_MOST, len(numbers) // (workers * _BATCHES_A_WORKER)))
    rest = iter(numbers)
    while batch := tuple(map(Order, islice(rest, size))):
        yield batch


class Rules(NamedTuple):
    """How runs are played: the campaign's seed, and the time limit of each run in s (None: no limit).

    `alone`: nothing else runs in the worker's process. A run that does not stop at its limit may then be ended with
    that process, `grace_s` after the limit.
    """

    seed: int
    limit_s: float | None = None
    alone: bool = True
    grace_s: float = GRACE_S


def play_batch(script: Script, batch: Batch, rules: Rules, version: str = __version__) -> list[CampaignRun]:
    """Play these runs. Raises HubError if this worker has another version of canwire than the caller."""
    if version != __version__:
        raise HubError(
            f"this worker has canwire {__version__}, the campaign was started by {version}: install one of them"
        )
    campaign = loaded(script)
    runs = []
    for order in batch:
        with process_at_most(rules.limit_s if rules.alone else None, rules.grace_s):
            runs.append(play(campaign, order, rules.seed, limit_s=rules.limit_s))
    return runs


@lru_cache(maxsize=4)
def loaded(script: Script) -> Campaign:
    """Load the campaign; each process loads it only once."""
    return script.load()
