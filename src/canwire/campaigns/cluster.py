"""Batches on a Dask cluster (extra canwire[cluster])."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice
from typing import Any

from canwire.campaigns.batches import batches, play_batch
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun
from canwire.errors import BadValue, ExtraMissing, HubError

SCHEME = "dask://"
_AHEAD = 4
_PATIENCE_S = 10


def in_cluster(
    script: Script, numbers: Sequence[int], seed: int, address: str
) -> Iterator[list[CampaignRun]]:
    """Play the runs on the workers of `address` ("dask://host:8786"); batches come as they are done.

    Workers need canwire of this version. Raises ExtraMissing, BadValue for another address, HubError where no
    cluster answers.
    """
    if not address.startswith(SCHEME):
        raise BadValue(f"cluster {address!r}: an address such as dask://host:8786")
    try:
        from distributed import Client, as_completed
    except ImportError:
        raise ExtraMissing("dask", "cluster") from None
    try:
        place = "tcp://" + address.removeprefix(SCHEME)
        client: Any = Client(place, timeout=_PATIENCE_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise HubError(f"cluster {address}: {error or 'no answer'}") from None
    with client:
        yield from _played(client, as_completed, script, numbers, seed)


def _played(
    client: Any, as_completed: Any, script: Script, numbers: Sequence[int], seed: int
) -> Iterator[list[CampaignRun]]:
    workers = max(1, sum(client.nthreads().values()))
    rest = batches(numbers, workers)

    def submitted(count: int) -> list[Any]:
        return [client.submit(play_batch, script, batch, seed, pure=False) for batch in islice(rest, count)]

    coming = as_completed(submitted(workers * _AHEAD), loop=client.loop, with_results=True)
    for _, runs in coming:
        coming.update(submitted(1))
        yield runs
