"""What the soak measured over time: a CSV file as it goes, a table and a picture of it."""

from __future__ import annotations

import csv
import math
import statistics
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple


class Sample(NamedTuple):
    """One look, every ten seconds. `life` counts hubs; times in milliseconds, of what ended since the look before."""

    minute: float
    life: int
    memory_mb: float
    shared_mb: float
    descriptors: int
    threads: int
    calls: int
    call_p50: float
    call_p99: float
    call_max: float
    leases: int
    lease_p50: float
    lease_max: float
    sleep_p99: float
    sleep_max: float
    skipped_ms: int


def quantile(times: Iterable[float], share: float) -> float:
    """0 of none."""
    ordered = sorted(times)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else 0.0


def write_csv(samples: list[Sample], to: Path) -> None:
    with to.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(Sample._fields)
        writer.writerows([f"{value:.6g}" for value in sample] for sample in samples)


def growth(samples: list[Sample], of: str) -> str:
    """How a figure went in the longest life of a hub: its medians over five parts of it."""
    lives: dict[int, list[Sample]] = {}
    for sample in samples:
        lives.setdefault(sample.life, []).append(sample)
    longest = max(lives.values(), key=len, default=[])
    size = max(1, len(longest) // 5)
    parts = [longest[begin : begin + size] for begin in range(0, size * min(5, len(longest)), size)]
    return ", ".join(f"{statistics.median(getattr(sample, of) for sample in part):.4g}" for part in parts)


def draw(samples: list[Sample], to: Path) -> None:
    """Three panels over minutes; needs matplotlib. Nothing where nothing was measured."""
    if not any(sample.calls for sample in samples):
        return
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({"svg.hashsalt": "canwire", "font.size": 9})
    from matplotlib import pyplot

    figure, (memory, descriptors, times) = pyplot.subplots(3, 1, sharex=True, figsize=(8, 7))
    for life in sorted({sample.life for sample in samples}):
        own = [sample for sample in samples if sample.life == life]
        minutes = [sample.minute for sample in own]
        labels = ("its own", "rings shared with programs") if life == samples[0].life else (None, None)
        memory.plot(minutes, [sample.memory_mb for sample in own], color="tab:blue", label=labels[0])
        memory.plot(minutes, [sample.shared_mb for sample in own], color="tab:gray", label=labels[1])
        descriptors.plot(minutes, [sample.descriptors for sample in own], color="tab:green")
    minutes = [sample.minute for sample in samples]
    for field, label in (
        ("call_p50", "call, median"), ("call_p99", "call, p99"), ("lease_p50", "lease back, median"),
        ("lease_max", "lease back, longest"), ("sleep_p99", "a bare sleep's lateness, p99"),
    ):  # fmt: skip
        values = [getattr(sample, field) or math.nan for sample in samples]  # 0: none ended in this time
        times.plot(minutes, values, label=label, linewidth=0.9)
    memory.set_ylabel("hub's memory (MB)")
    memory.set_ylim(bottom=0)
    above = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "frameon": False}
    memory.legend(ncols=2, **above)
    descriptors.set_ylabel("its descriptors")
    descriptors.set_ylim(bottom=0)
    times.set_ylabel("ms, every 10 s")
    times.set_yscale("log")
    times.set_xlabel("minutes")
    times.legend(ncols=3, **above)
    figure.tight_layout()
    figure.savefig(to, metadata={"Date": None} if to.suffix == ".svg" else None)
    pyplot.close(figure)
