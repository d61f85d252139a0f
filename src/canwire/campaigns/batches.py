"""Runs in batches: what a worker does with one, wherever it is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from itertools import islice

from canwire.campaigns.campaign import Campaign
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun, play
from canwire.errors import HubError
from canwire.version import __version__

Batch = tuple[int, ...]
_MOST = 64
_BATCHES_A_WORKER = 16  # of a short campaign: nobody is idle for long at its end


def batches(numbers: Sequence[int], workers: int) -> Iterator[Batch]:
    """`numbers` in pieces, small enough that workers end at about the same time."""
    size = max(1, min(_MOST, len(numbers) // (workers * _BATCHES_A_WORKER)))
    rest = iter(numbers)
    while batch := tuple(islice(rest, size)):
        yield batch


def play_batch(script: Script, batch: Batch, seed: int, version: str = __version__) -> list[CampaignRun]:
    """Play these runs. Raises HubError where this worker's canwire is not the caller's."""
    if version != __version__:
        raise HubError(
            f"this worker has canwire {__version__}, the campaign was started by {version}: install one of them"
        )
    campaign = _loaded(script)
    return [play(campaign, number, seed) for number in batch]


@lru_cache(maxsize=4)
def _loaded(script: Script) -> Campaign:
    return script.load()
