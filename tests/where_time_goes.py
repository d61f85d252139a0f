"""Where the suite's time goes: `python -m pytest -n 2 -p tests.where_time_goes --time-table=FILE.jsonl`.

Each test becomes a line of FILE: seconds of setup, call and teardown, and what was counted meanwhile in its process
(processes started, seconds in time.sleep, hubs made, browsers). `python -m tests.where_time_goes FILE.jsonl` prints
the table that docs/tests.md holds.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

COUNTS = "counts of where_time_goes"


class Counting:
    """Counts calls of what is slow, and the seconds spent in them."""

    def __init__(self) -> None:
        self.seen: Counter[str] = Counter()

    def watch(self, owner: Any, name: str, kind: str) -> None:
        """From now on each call of `owner.name` counts as `kind`, its seconds as `kind`_s."""
        original: Callable[..., Any] = getattr(owner, name)

        def counted(*args: Any, **options: Any) -> Any:
            began = time.perf_counter()
            try:
                return original(*args, **options)
            finally:
                self.seen[kind] += 1
                self.seen[f"{kind}_ms"] += int((time.perf_counter() - began) * 1000)

        setattr(owner, name, counted)


def processor_s() -> float:
    """Of this process, and of those it has started and waited for."""
    return sum(os.times()[:4])


class Measured:
    """In each worker: what a test caused goes along with its last report."""

    def __init__(self) -> None:
        self.counting = Counting()
        self.counting.watch(subprocess.Popen, "__init__", "process")
        self.counting.watch(subprocess.Popen, "wait", "wait for process")
        self.counting.watch(time, "sleep", "sleep")
        self.processor_s = processor_s()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Iterator[None]:
        report: Any = yield
        before, self.processor_s = self.processor_s, processor_s()
        self.counting.seen["processor_ms"] = int((self.processor_s - before) * 1000)
        report.user_properties = [*report.user_properties, (COUNTS, dict(self.counting.seen))]
        self.counting.seen.clear()
        return report


class Written:
    """In the process that collects reports: a line for each phase of a test."""

    def __init__(self, path: Path) -> None:
        self.file = path.open("w")

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        counts = next((found for name, found in report.user_properties if name == COUNTS), {})
        line = {"test": report.nodeid, "when": report.when, "s": round(report.duration, 4), **counts}
        self.file.write(json.dumps(line) + "\n")

    def pytest_unconfigure(self) -> None:
        self.file.close()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--time-table", metavar="FILE", help="a line of JSON for each phase of each test")


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Measured())
    path = config.getoption("--time-table")
    if path and not hasattr(config, "workerinput"):
        config.pluginmanager.register(Written(Path(path)))


def table(lines: list[dict[str, Any]]) -> str:
    """Markdown: a row for each folder, slowest first."""
    tests: dict[str, set[str]] = defaultdict(set)
    sums: dict[str, Counter[str]] = defaultdict(Counter)
    for line in lines:
        folder = "/".join(line["test"].split("::")[0].split("/")[:2])
        tests[folder].add(line["test"])
        for name, value in line.items():
            if name not in ("test", "when"):
                sums[folder][name] += value
        sums[folder][str(line["when"])] += line["s"]
    heads = ("folder", "tests", "s", "of that in fixtures", "processor s", "processes started")
    heads += ("waiting for their end, s", "`sleep`, s")
    rows = [f"| {' | '.join(heads)} |", "|---|" + "--:|" * (len(heads) - 1)]
    for folder, sum_ in sorted(sums.items(), key=lambda item: -item[1]["s"]):
        cells = [
            folder,
            str(len(tests[folder])),
            f"{sum_['s']:.0f}",
            f"{sum_['setup'] + sum_['teardown']:.0f}",
        ]
        cells += [f"{sum_['processor_ms'] / 1000:.0f}", str(sum_["process"])]
        cells += [f"{sum_['wait for process_ms'] / 1000:.0f}", f"{sum_['sleep_ms'] / 1000:.1f}"]
        rows.append(f"| {' | '.join(cells)} |")
    return "\n".join(rows)


if __name__ == "__main__":
    print(table([json.loads(line) for line in Path(sys.argv[1]).read_text().splitlines()]))
