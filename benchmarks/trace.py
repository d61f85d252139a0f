"""Traces bigger than memory: frames a second written and read, bytes a frame, seconds a query, peak memory.

python benchmarks/trace.py [--frames 30000000] [--random]

The traffic is a bus with 120 identifiers at 10 ms to 1 s, some 3,500 frames a second, with counters, a checksum, slow
and noisy signals, and an error in a thousand frames; with --random all data are random, the worst case for size. What
is measured runs in processes of its own, whose peak memory is theirs alone. Everything is in a temporary folder
(TMPDIR), some 8 bytes a frame, and is gone afterwards.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy

import canwire
from canwire import BusEvent, ErrorKind, ErrorState, EventKind, LogBatch, LogKind

DBC = Path(__file__).parents[1] / "examples" / "engine.dbc"
START_NS = 1_790_000_000 * 10**9
DAY = 300_000_000
BATCH = 1 << 18
IDS = 120
SIGNAL = "signal = 'EngineSpeed'"
HOUR = f"time_ns between {START_NS + 600 * 10**9} and {START_NS + 4200 * 10**9}"
MINUTE = f"time_ns between {START_NS + 600 * 10**9} and {START_NS + 660 * 10**9}"
DAILY = ("count by identifier", "errors by kind", "one signal over all of it", "its values, as CSV")
QUERIES = {
    "count by identifier": "select id, count(*) from frames group by id order by 2 desc",
    "errors by kind": "select error, count(*), max(tec) from errors group by error",
    "one signal over an hour": f"select count(*), min(value), avg(value), max(value) from signals where {SIGNAL} "
    f"and {HOUR}",
    "one signal over all of it": f"select count(*), min(value), avg(value), max(value) from signals where {SIGNAL}",
    "its values, as CSV": f"select time, value from signals where {SIGNAL} order by time_ns",
    "one identifier's longest gap": "select max(d) from (select time_ns - lag(time_ns) over (order by time_ns) as d "
    "from frames where id = 256)",
    "a minute of everything, in order, as CSV": f"select * from entries where {MINUTE} order by time_ns, row",
    "everything in order, as Parquet": "select * from entries order by time_ns, row",
}


def schedule() -> numpy.ndarray:
    """The identifiers of a second's 3,500 frames, by number, in their order."""
    numbers = numpy.random.default_rng(1)
    periods_ms = numpy.resize([10, 20, 50, 100, 100, 200, 500, 1000], IDS)
    due = [numpy.arange(numbers.integers(0, period), 1000, period) for period in periods_ms]
    times = numpy.concatenate(due)
    who = numpy.concatenate([numpy.full(len(one), number) for number, one in enumerate(due)])
    return who[numpy.argsort(times, kind="stable")]


def batches(count: int, random: bool) -> Iterator[LogBatch]:
    """So many entries; every thousandth is an error."""
    numbers = numpy.random.default_rng(2)
    order = schedule()
    error = BusEvent(EventKind.ERROR, error=ErrorKind.STUFF, state=ErrorState.ERROR_ACTIVE, bit=12, tec=8)
    template = numpy.frombuffer(error.to_record(), canwire.record_dtype())[0]
    sent = numpy.zeros(IDS, "i8")
    for first in range(0, count, BATCH):
        places = numpy.arange(first, min(first + BATCH, count))
        records = numpy.zeros(len(places), canwire.log_dtype())
        time_ns = START_NS + places * (10**9 // len(order)) + numbers.integers(0, 20_000, len(places))
        who = order[places % len(order)]
        records["time_ns"], records["id"] = time_ns, 0x100 + 5 * who
        records["info"] = 8 << 16
        records["direction"] = 1
        data = records["data"]
        if random:
            data[:, :8] = numbers.integers(0, 256, (len(places), 8))
        else:
            fill(data, who, time_ns, sent, numbers)
        at = numpy.flatnonzero(places % 1000 == 999)
        for name in ("id", "info", "data"):
            records[name][at] = template[name]
        records["kind"][at] = LogKind.CAN_EVENT
        records["direction"][at] = 0
        yield LogBatch(records, ["can0"])


def fill(
    data: numpy.ndarray, who: numpy.ndarray, time_ns: numpy.ndarray, sent: numpy.ndarray,
    numbers: numpy.random.Generator,
) -> None:  # fmt: skip
    """A slow signal with noise, a temperature, states, a counter of 4 bits, a checksum."""
    seconds = (time_ns - START_NS) / 1e9
    speed = (4000 + 2000 * numpy.sin(seconds / 20 + who) + numbers.normal(0, 4, len(who))).astype("<u2")
    data[:, 0:2] = speed.view("u1").reshape(-1, 2)
    data[:, 2] = 80 + 40 * numpy.sin(seconds / 600 + who)
    data[:, 3] = (seconds.astype("i8") // 300 + who) % 3
    data[:, 4] = who
    for number in range(IDS):
        mine = numpy.flatnonzero(who == number)
        data[mine, 6] = (sent[number] + numpy.arange(len(mine))) & 15
        sent[number] += len(mine)
    data[:, 7] = numpy.bitwise_xor.reduce(data[:, :7], axis=1) * 29


class Spent:
    """Seconds on the clock, and of the processor: what neighbours on the machine do not change."""

    def __init__(self) -> None:
        self._clock = self._processor = 0.0

    def __enter__(self) -> Spent:
        self._clock -= time.perf_counter()
        self._processor -= time.process_time()
        return self

    def __exit__(self, *_: object) -> None:
        self._clock += time.perf_counter()
        self._processor += time.process_time()

    def told(self) -> dict[str, float]:
        return {"clock": self._clock, "processor": self._processor}


def written(folder: str, count: int, random: bool) -> dict[str, float]:
    """Making the frames is not counted."""
    spent = Spent()
    writer = canwire.create_log(folder)
    for batch in batches(count, random):
        with spent:
            writer.write_batch(batch)
    with spent:
        writer.close()
    return spent.told()


def read(folder: str) -> dict[str, float]:
    with Spent() as spent, canwire.open_log(folder) as log:
        for _ in log.batches():
            pass
    return spent.told()


def asked(folder: str, name: str) -> dict[str, float]:
    """As `canwire query` does it, without the time that Python and its modules take to load (1 s; cantools 2 s)."""
    from canwire.commands import main

    database = canwire.load_database(DBC)
    canwire.open_trace(DBC.parent / "car-candump.log", database=database).close()
    with Spent() as spent:
        out = f"{folder}.{'parquet' if 'Parquet' in name else 'csv'}"
        status = main(["query", folder, QUERIES[name], "--db", str(DBC), "-o", out])
    assert status == 0
    return spent.told()


def measured(*words: str) -> dict[str, float]:
    """One of the above in a process of its own, and its peak memory in MiB."""
    ended = subprocess.run(
        [sys.executable, __file__, "--work", *words], check=True, stdout=subprocess.PIPE, text=True
    )
    return json.loads(ended.stdout.splitlines()[-1])  # type: ignore[no-any-return]


def work(words: list[str]) -> None:
    import resource

    what, folder, *rest = words
    if what == "write":
        found = written(folder, int(rest[0]), rest[1] == "True")
    else:
        found = read(folder) if what == "read" else asked(folder, rest[0])
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(json.dumps({**found, "peak": peak}))


def line(what: str, found: dict[str, float], scale: float, more: str = "") -> None:
    processor = found["processor"]
    print(
        f"{what:42}{found['clock']:9.2f}{processor:11.2f}{processor * scale:9.1f}{found['peak']:7.0f}  {more}"
    )


def report(count: int, random: bool) -> None:
    day = DAY / count
    with tempfile.TemporaryDirectory() as home:
        folder = os.path.join(home, "some.trace")
        found = measured("write", folder, str(count), str(random))
        size = sum(path.stat().st_size for path in Path(folder).iterdir()) / count
        files = len(os.listdir(folder))
        print(f"{count} entries in {files} files, {size:.2f} bytes each: a day {size * DAY / 1e9:.1f} GB")
        print(f"{'':42}{'clock s':>9}{'processor s':>11}{'a day s':>9}{'MiB':>7}")
        line("written", found, day, f"{count / found['processor'] / 1e6:.2f} M frames/s of processor")
        found = measured("read", folder)
        line(
            "read by open_log", found, day, f"{count / found['processor'] / 1e6:.2f} M frames/s of processor"
        )
        for name in QUERIES:
            part = "hour" in name or "minute" in name
            line(name, measured("ask", folder, name), 1 if part else day)
        whole_day(folder, count)


def whole_day(folder: str, count: int) -> None:
    """As many entries as a day has, the same files again and again: hard links, which take no room."""
    day, files = Path(f"{folder}.day"), sorted(Path(folder).iterdir())
    day.mkdir()
    copies = math.ceil(DAY / count)
    for copy in range(copies):
        for file in files:
            os.link(file, day / f"{copy:04d}-{file.name}")
    print(f"{copies * count} entries in {copies * len(files)} files")
    for name in DAILY:
        line(name, measured("ask", str(day), name), 1)


if __name__ == "__main__":
    if sys.argv[1:2] == ["--work"]:
        work(sys.argv[2:])
    else:
        parser = argparse.ArgumentParser()
        parser.add_argument("--frames", type=int, default=30_000_000)
        parser.add_argument("--random", action="store_true")
        options = parser.parse_args()
        report(options.frames, options.random)
