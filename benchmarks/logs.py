"""Logs: how many frames a second are read and written, beside python-can in the same run; and `canwire play`'s senders.

python benchmarks/logs.py [--short]
"""

from __future__ import annotations

import contextlib
import io
import json
import random
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import can

import canwire
from canwire.commands import main

SUFFIXES = (".log", ".csv", ".asc", ".blf", ".trc", ".mf4", ".parquet", ".pcapng", ".db")
THEIRS = (".log", ".csv", ".asc", ".blf", ".trc")


def seconds(work: Callable[[], object]) -> float:
    """Processor time, which neighbours on the machine do not change."""
    began = time.process_time()
    work()
    return time.process_time() - began


def candump_log(path: Path, count: int) -> None:
    """Classic frames of 200 identifiers, half a millisecond apart."""
    numbers = random.Random(1)
    with path.open("w") as file:
        for k in range(count):
            at = 1_700_000_000_000_000 + 500 * k
            data = numbers.randbytes(8).hex().upper()
            file.write(f"({at // 10**6}.{at % 10**6:06d}) can0 {100 + k % 200:03X}#{data} R\n")


def read_by_batches(path: Path) -> int:
    with canwire.open_log(path) as log:
        return sum(len(batch) for batch in log.batches())


def written(path: Path, batches: list[canwire.LogBatch]) -> None:
    with canwire.create_log(path) as writer:
        for batch in batches:
            writer.write_batch(batch)


def read_by_python_can(path: Path) -> int:
    with can.LogReader(path) as reader:
        return sum(1 for _ in reader)


def written_by_python_can(path: Path, messages: list[can.Message]) -> None:
    with can.Logger(path) as writer:
        for message in messages:
            writer.on_message_received(message)


def formats(folder: Path, count: int) -> None:
    source = folder / "source.log"
    candump_log(source, count)
    with canwire.open_log(source) as log:
        batches = list(log.batches())
    few = count // 10
    with can.LogReader(source) as reader:
        messages = [message for message, _ in zip(reader, range(few), strict=False)]
    print(f"{'':10}{'write':>12}{'read':>12}   k frames/s of processor    python-can: write, read")
    for suffix in (".mf4", ".parquet"):  # their libraries are loaded once
        written(folder / f"ours{suffix}", batches[:1])
    for suffix in SUFFIXES:
        path = folder / f"ours{suffix}"
        write_s = seconds(lambda path=path: written(path, batches))  # type: ignore[misc]
        read_s = seconds(lambda path=path: read_by_batches(path))  # type: ignore[misc]
        line = f"{suffix:10}{count / write_s / 1e3:12.0f}{count / read_s / 1e3:12.0f}"
        if suffix in THEIRS:
            other = folder / f"theirs{suffix}"
            write_s = seconds(lambda other=other: written_by_python_can(other, messages))  # type: ignore[misc]
            read_s = seconds(lambda other=other: read_by_python_can(other))  # type: ignore[misc]
            line += f"{few / write_s / 1e3:32.0f}{few / read_s / 1e3:8.0f}"
        print(line)
    for suffix in (".parquet", ".trace", ".blf", ".pcapng"):
        spent = seconds(lambda suffix=suffix: canwire.convert_log(source, folder / f"c{suffix}"))  # type: ignore[misc]
        print(f"candump to {suffix[1:]}: {count / spent / 1e3:.0f} k frames/s")


def statistics(folder: Path, count: int) -> None:
    """`log_statistics` of batches that are there already, and of a BLF file."""
    from canwire.logs.statistics.collecting import Collector

    with canwire.open_log(folder / "source.log") as log:
        batches = list(log.batches())
    collector = Collector({"": 500_000}, {})
    spent = seconds(lambda: [collector.add(batch) for batch in batches])
    print(f"statistics of batches: {count / spent / 1e3:.0f} k frames/s")
    spent = seconds(lambda: canwire.log_statistics(folder / "ours.blf", bit_rate=500_000))
    print(f"statistics of a BLF file: {count / spent / 1e3:.0f} k frames/s")


def senders(folder: Path) -> None:
    """Thousands of identifiers: how many times faster than real time one sender and many are."""
    numbers = random.Random(1)
    path = folder / "many.log"
    with path.open("w") as file:
        at = 0.0
        for _ in range(20_000):
            at += numbers.choice((0.0, 0.0005, 0.001))
            file.write(f"({at:.6f}) can0 {numbers.randrange(5000) * 7:08X}#{numbers.randbytes(8).hex()}\n")
    for choice in ("one", "each"):
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(io.StringIO()):
            main(["play", str(path), "--senders", choice, "--json"])
        found = json.loads(output.getvalue())
        print(
            f"play, 5,000 identifiers, --senders {choice}: {found['bus_time_s'] / found['wall_time_s']:.1f} x real time"
        )


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    with tempfile.TemporaryDirectory() as home:
        many = 100_000 if "--short" in sys.argv else 1_000_000
        formats(Path(home), many)
        statistics(Path(home), many)
        senders(Path(home))
