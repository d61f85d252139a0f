"""The results of a campaign as a table: one row per run, in the order of their numbers."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path

from canwire.campaigns.parameters import Value
from canwire.campaigns.playing import CampaignRun
from canwire.campaigns.whole import whole
from canwire.errors import BadValue, ExtraMissing

_ENDINGS = (".parquet", ".csv")


def rows(runs: Iterable[CampaignRun]) -> list[dict[str, Value | None]]:
    """One row per run in the order of their numbers, all with the same columns."""
    ordered = sorted(runs, key=lambda run: run.number)
    parameters = list(dict.fromkeys(name for run in ordered for name in run.parameters))
    figures = list(dict.fromkeys(name for run in ordered for name in run.figures))
    return [
        {
            "run": run.number,
            "seed": run.seed,
            **{name: run.parameters.get(name) for name in parameters},
            "verdict": run.verdict,
            "reason": run.reason,
            **{name: run.figures.get(name) for name in figures},
            "frames": run.frames,
            "error_frames": run.error_frames,
            "bus_time_ns": run.bus_time_ns,
            "digest": run.digest,
        }
        for run in ordered
    ]


def check_table(path: str | Path) -> Path:
    """`path`, if `write` can write there. Raises BadValue for an unknown file extension, ExtraMissing, OSError."""
    path = Path(path)
    if path.suffix not in _ENDINGS:
        raise BadValue(f"{path}: results are written to a file whose name ends in {' or '.join(_ENDINGS)}")
    if path.suffix == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError:
            raise ExtraMissing("pyarrow", "parquet") from None
    if not path.parent.is_dir():
        raise FileNotFoundError(2, "there is no such folder", str(path.parent))
    return path


def write(path: str | Path, runs: Iterable[CampaignRun]) -> None:
    """Write the table to a Parquet or CSV file, completely or not at all. Raises the same errors as `check_table`."""
    path = check_table(path)
    table = rows(runs)
    with whole(path) as part:
        if path.suffix == ".csv":
            with part.open("w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, list(table[0]) if table else [])
                writer.writeheader()
                writer.writerows(table)
        else:
            import pyarrow
            import pyarrow.parquet

            pyarrow.parquet.write_table(pyarrow.table(_columns(table)), part)


def _columns(table: list[dict[str, Value | None]]) -> dict[str, list[Value | None]]:
    """The values by column. Integers and floats in one column become floats, other mixed types become text."""
    columns = {name: [row[name] for row in table] for name in (table[0] if table else ())}
    for name, values in columns.items():
        kinds = {type(one) for one in values if one is not None}
        if kinds == {int, float}:
            columns[name] = [None if one is None else float(one) for one in values]
        elif len(kinds) > 1:
            columns[name] = [None if one is None else str(one) for one in values]
    return columns
