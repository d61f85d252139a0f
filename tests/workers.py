"""What several workers of pytest-xdist share: the work of compiling, and of what a folder's tests need.

Each worker collects all tests. In a fresh clone each would also compile all of them, 15 s of the processor for each
worker. Here each begins at another part of the files, and finds the rest compiled by the others. Neighbours run in one
worker as long as it has some (`worksteal`), so that a browser, a hub or a compiled program is made for few of them.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

# options that also show when a test began, and how its fixtures ended
_ALL_REPORTS = ("xmlpath", "durations")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """`worksteal` in place of `load`, which `-n` alone means."""
    if config.getvalue("dist") != "load":
        return None
    from xdist.scheduler import WorkStealingScheduling

    return WorkStealingScheduling(config, log)


def pytest_sessionstart(session: pytest.Session) -> None:
    """In a worker: import what it will collect, from another place on than the other workers."""
    worker = getattr(session.config, "workerinput", None)
    if worker is None or session.config.option.markexpr == "smoke":
        return
    atexit.register(_end)
    if not any(getattr(session.config.option, name) for name in _ALL_REPORTS):
        tell_only_results(session.config)
    files = list(_files(session.config))
    begin = len(files) * int(worker["workerid"].removeprefix("gw")) // worker["workercount"]
    gc.disable()  # until all is collected: tests/conftest.py
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # as in a collection
        for file in files[begin:] + files[:begin]:
            name = ".".join(file.relative_to(session.config.rootpath).with_suffix("").parts)
            with suppress(
                Exception, pytest.skip.Exception
            ):  # the collection imports it anew, and reports that
                importlib.import_module(name)


def tell_only_results(config: pytest.Config) -> None:
    """Send two messages about a test that passes, not six: the process that gets them spends a millisecond on each."""
    interactor: Any = next(one for one in config.pluginmanager.get_plugins() if hasattr(one, "sendevent"))
    send = interactor.sendevent

    def send_news(name: str, **words: Any) -> None:
        if name in ("logstart", "logfinish"):
            return
        report = words.get("data", {}) if name == "testreport" else {}
        if report.get("outcome") == "passed" and report["when"] != "call" and not report["user_properties"]:
            return
        send(name, **words)

    interactor.sendevent = send_news


def _end() -> None:
    """End before the interpreter takes all tests apart, which takes a worker two seconds and shows nothing."""
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(0)


def _files(config: pytest.Config) -> Iterator[Path]:
    for word in config.args:
        path = config.invocation_params.dir / word.partition("::")[0]
        yield from sorted(path.rglob("test_*.py")) if path.is_dir() else [path]
