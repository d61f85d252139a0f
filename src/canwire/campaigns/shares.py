"""Which parameters fail: runs in a few classes of each parameter's values, and how much their failure rates differ."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from typing import NamedTuple

from canwire.campaigns.parameters import Value
from canwire.campaigns.playing import CampaignRun

_MOST_CLASSES = 12
_BINS = 8


class Share(NamedTuple):
    """The runs whose value of a parameter is in one class: their number, and how many of them did not pass."""

    label: str
    runs: int
    failed: int


class Parameter(NamedTuple):
    """A parameter, its classes in order, and the number of the class of each run."""

    name: str
    shares: list[Share]
    places: list[int]

    @property
    def spread(self) -> float:
        """The difference between the failure rates of the classes, 0 to 1; by chance alone it is small."""
        found = [share.failed / share.runs for share in self.shares]
        return max(found) - min(found)


def parameters_of(runs: Sequence[CampaignRun]) -> list[Parameter]:
    """The parameters that all runs have, the one with the greatest influence first."""
    names = [name for name in runs[0].parameters if all(name in run.parameters for run in runs)]
    found = [_parameter(name, runs) for name in names]
    return sorted(found, key=lambda one: (-one.spread, one.name))


def _parameter(name: str, runs: Sequence[CampaignRun]) -> Parameter:
    labels, places = _classes([run.parameters[name] for run in runs])
    counts, failed = [0] * len(labels), [0] * len(labels)
    for run, place in zip(runs, places, strict=True):
        counts[place] += 1
        failed[place] += not run.passed
    shares = [Share(label, counts[place], failed[place]) for place, label in enumerate(labels)]
    return Parameter(name, shares, places)


def _classes(values: list[Value]) -> tuple[list[str], list[int]]:
    """Return the classes: one for each value if there are few values, else ranges that contain equally many runs."""
    numbers = [float(one) for one in values if isinstance(one, int | float)]
    if len(numbers) == len(values) and len(set(values)) > _MOST_CLASSES:
        ordered = sorted(numbers)
        edges = sorted({ordered[len(ordered) * part // _BINS] for part in range(_BINS)})
        labels = [f"from {edge:g}" for edge in edges]
        return labels, [bisect_right(edges, number) - 1 for number in numbers]
    kinds = sorted(
        set(values), key=lambda one: (isinstance(one, str), one if isinstance(one, str) else float(one))
    )
    if len(kinds) > _MOST_CLASSES:
        rest = kinds[_MOST_CLASSES - 1 :]
        places = {one: min(place, _MOST_CLASSES - 1) for place, one in enumerate(kinds)}
        return [*map(str, kinds[: _MOST_CLASSES - 1]), f"{len(rest)} others"], [places[one] for one in values]
    return [str(one) for one in kinds], [kinds.index(one) for one in values]
