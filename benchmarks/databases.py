"""Decoding by a description with 217 messages: columns beside cantools, frame by frame, in the same run.

    python benchmarks/databases.py [--frames 1000000] [--db FILE]

Two loads: a car's log under identifiers of the file (the car is another one), repeated; and random data under all
identifiers. Medians of five runs; what is measured is decoding alone, numbers without texts, and cantools' share is
measured on a part of the frames. The values of that part are compared before.
"""

from __future__ import annotations

import argparse
import random
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import cantools

import canwire
from canwire import Frame

ROOT = Path(__file__).resolve().parents[1]
RUNS = 5
PART = 50_000  # frames that cantools decodes


def car(messages: list[cantools.database.Message]) -> list[Frame]:
    """The log's data, each of its identifiers being one of the file's."""
    lines = (ROOT / "examples" / "car-candump.log").read_text(encoding="utf-8").splitlines()
    logged = [canwire.parse_log_line(line).content for line in lines]
    places = {id: place for place, id in enumerate(dict.fromkeys(frame.id for frame in logged))}
    return [under(messages[places[frame.id] % len(messages)], frame.data) for frame in logged]


def noise(messages: list[cantools.database.Message], count: int) -> list[Frame]:
    chance = random.Random(0)
    return [under(chance.choice(messages), chance.randbytes(8)) for _ in range(count)]


def under(message: cantools.database.Message, data: bytes) -> Frame:
    return Frame(message.frame_id, data, extended=message.is_extended_frame)


def rate(work: Callable[[], object], count: int) -> float:
    """Frames a second, the median of some runs."""
    spent = []
    for _ in range(RUNS):
        began = time.perf_counter()
        work()
        spent.append(time.perf_counter() - began)
    return count / statistics.median(spent)


def compare(path: Path, frames: list[Frame], count: int) -> str:
    database, reference = canwire.load_database(path), cantools.database.load_file(path)
    part = (frames * (PART // len(frames) + 1))[:PART]
    check(database, reference, part[:5000])
    import numpy

    records = canwire.frames_to_array(frames)
    records = numpy.tile(records, count // len(records) + 1)[:count]

    def slowly() -> None:
        for frame in part:
            reference.decode_message(frame.id, frame.data, decode_choices=False, allow_truncated=True)

    theirs, ours = rate(slowly, PART), rate(lambda: database.decode_arrays(records), count)
    single = rate(lambda: [database.decode(frame) for frame in part], PART)
    return f"{theirs:>14,.0f} {single:>14,.0f} {ours:>14,.0f} {ours / theirs:>9.1f} x"


def check(database: canwire.Database, reference: cantools.database.Database, frames: list[Frame]) -> None:
    """The same values, or the figures mean nothing."""
    for name, columns in database.decode_arrays(canwire.frames_to_array(frames)).items():
        message = reference.get_message_by_name(name)
        for number, row in enumerate(columns.rows.tolist()):
            values = message.decode(frames[row].data, decode_choices=False, allow_truncated=True)
            for signal, value in values.items():
                assert columns.signals[signal][number] == value, (name, signal)


def main() -> None:
    parser = argparse.ArgumentParser(description="decoding rates, in frames/s")
    parser.add_argument("--frames", type=int, default=1_000_000)
    parser.add_argument("--db", type=Path, default=ROOT / "tests" / "databases" / "data" / "vehicle.dbc")
    arguments = parser.parse_args()
    messages = cantools.database.load_file(arguments.db).messages
    print(f"{'':<8}{'cantools':>14} {'decode':>14} {'decode_arrays':>14} {'':>11}")
    for name, frames in (("car", car(messages)), ("random", noise(messages, 100_000))):
        print(f"{name:<8}{compare(arguments.db, frames, arguments.frames)}")


if __name__ == "__main__":
    main()
