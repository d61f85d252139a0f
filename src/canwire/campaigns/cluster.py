"""Batches on a Dask cluster (extra canwire[cluster])."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from itertools import islice
from typing import Any

from canwire.campaigns.batches import Batch, Rules, batches, play_batch
from canwire.campaigns.loading import Script
from canwire.campaigns.playing import CampaignRun, Order, crashed
from canwire.errors import BadValue, ExtraMissing, HubError, HubLost

SCHEME = "dask://"
_AHEAD = 4
_PATIENCE_S = 10


def in_cluster(
    script: Script, numbers: Sequence[int], rules: Rules, address: str
) -> Iterator[list[CampaignRun]]:
    """Play the runs on the workers of `address` ("dask://host:8786"); yields each batch when it is done.

    Workers need the same version of canwire. Raises ExtraMissing, BadValue for an invalid address, HubError if no
    cluster answers, HubLost if its scheduler is gone.
    """
    if not address.startswith(SCHEME):
        raise BadValue(f"cluster {address!r}: an address such as dask://host:8786")
    try:
        from distributed import Client, KilledWorker, as_completed
    except ImportError:
        raise ExtraMissing("dask", "cluster") from None
    try:
        place = "tcp://" + address.removeprefix(SCHEME)
        client: Any = Client(place, timeout=_PATIENCE_S, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError) as error:
        raise HubError(f"cluster {address}: {error or 'no answer'}") from None
    with client:
        try:
            yield from _played(client, as_completed, KilledWorker, script, numbers, rules)
        except (CancelledError, OSError) as error:  # runs that raise these have them in their rows
            raise HubLost(
                f"cluster {address}: its scheduler is gone; start it again and repeat the command: with --results "
                f"the runs that were done are not played again ({_reason(error)})"
            ) from None


def _played(
    client: Any,
    as_completed: Any,
    killed: type[Exception],
    script: Script,
    numbers: Sequence[int],
    rules: Rules,
) -> Iterator[list[CampaignRun]]:
    threads = list(client.nthreads().values())
    workers = max(1, sum(threads))
    rules = rules._replace(alone=all(count == 1 for count in threads))
    rest = batches(numbers, workers)
    under_way: dict[Any, Batch] = {}
    suspects: list[Order] = []

    def submitted(handed: Iterable[Batch]) -> list[Any]:
        found = {client.submit(play_batch, script, batch, rules, pure=False): batch for batch in handed}
        under_way.update(found)
        return list(found)

    coming = as_completed(submitted(islice(rest, workers * _AHEAD)), loop=client.loop)
    for future in coming:
        batch = under_way.pop(future)
        coming.update(submitted(islice(rest, 1)))
        try:
            yield future.result()
        except killed:  # the scheduler blames all that a worker had when it died
            suspects += batch
    for order in sorted(suspects):  # alone: if a worker dies now, it was this run
        try:
            yield submitted([(order,)])[0].result()
        except killed:
            yield [crashed(script.load(), order, rules.seed)]


def _reason(error: Exception) -> str:
    """Return the last line of Dask's error message."""
    return (str(error).strip().splitlines() or ["no answer"])[-1]
