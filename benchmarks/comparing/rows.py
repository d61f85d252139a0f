"""What compare.py runs: each row is a rate, the higher the better, of what a commit's canwire does in one process.

`python benchmarks/comparing/rows.py NAME` reads lines, a number of frames each, and prints for each two rates as JSON:
by processor time and by the wall clock (`NAME --processor`: only the first). Several lines are several slices of the
same row, in a process that is warm.
"""

from __future__ import annotations

import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple


class Row(NamedTuple):
    """A rate by `time.perf_counter`. `touched`: folders and files of canwire whose changes could make a difference."""

    measure: Callable[[int], float]
    touched: tuple[str, ...]


_BUS = ("_mem", "values", "timeline", "ring", "holding", "bus", "chips", "drivers", "boards")
_LAB = (*_BUS, "held_time", "lab")
_HUB = (*_BUS, "hub", "platform")


def _saturated(count: int, **options: bool) -> float:
    from workloads import saturated

    return saturated(count, **options)[0]


def _bit_by_bit(count: int) -> float:
    from workloads import bit_by_bit

    return bit_by_bit(count // 20)


def _with_errors(count: int) -> float:
    from workloads import with_errors

    return with_errors(count // 10, 0.1)


def _objects(count: int, receivers: int) -> float:
    from workloads import lab_objects

    return lab_objects(count // 5, receivers)


def _records(count: int) -> float:
    from workloads import lab_arrays

    return lab_arrays(count)


def _candrv(count: int, way: int) -> float:
    from candrv import reading

    return reading(min(30_000, count // 5))[way]


def _lin(count: int) -> float:
    from lin import virtual

    return virtual(count / 2_000)


def _chips(count: int) -> float:
    from sja1000 import polling

    return polling(count / 200_000)[0]


def _slcan(count: int) -> float:
    from slcan import parsed

    return parsed(count, 4096)


def _log(count: int) -> float:
    from logs import candump_log, read_by_batches

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "drive.log")
        candump_log(path, count)
        began = time.perf_counter()
        return read_by_batches(path) / (time.perf_counter() - began)


ROWS = {
    "core, classic": Row(_saturated, _BUS),
    "core, CAN FD": Row(lambda count: _saturated(count // 2, fd=True), _BUS),
    "bit by bit": Row(_bit_by_bit, _BUS),
    "errors in 10 % of the frames": Row(_with_errors, _BUS),
    "Frame objects, 1 receiver": Row(lambda count: _objects(count, 1), _LAB),
    "Frame objects, 8 receivers": Row(lambda count: _objects(count // 4, 8), _LAB),
    "numpy records, 1 to 1": Row(_records, _LAB),
    "CANDRV, ReadFile": Row(lambda count: _candrv(count, 0), (*_HUB, "candrv")),
    "CANDRV, IOCTL_CAN_READ_EVENT_DATA": Row(lambda count: _candrv(count, 1), (*_HUB, "candrv")),
    "LIN, a schedule without end": Row(_lin, _LAB),
    "SJA1000, polled": Row(_chips, _BUS),
    "slcan, frames out of text": Row(_slcan, ("_mem", "values", "slcan")),
    "candump log, read": Row(_log, ("_mem", "values", "logs")),
}


def measured(name: str, count: int, clocks: int) -> list[float]:
    """By processor time, and with two clocks by the wall clock: the same once more."""
    row, wall = ROWS[name], time.perf_counter
    time.perf_counter = time.process_time
    try:
        processor = row.measure(count)
    finally:
        time.perf_counter = wall
    return [processor] if clocks == 1 else [processor, row.measure(count)]


if __name__ == "__main__":
    for line in sys.stdin:
        print(json.dumps(measured(sys.argv[1], int(line), 1 if "--processor" in sys.argv else 2)), flush=True)
