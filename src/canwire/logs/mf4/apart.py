"""Runs another library's reader in a separate process: a crash, a hang or full memory ends only that process."""

from __future__ import annotations

import faulthandler
import json
import os
import select
import signal
import sys
import tempfile
import warnings
from collections.abc import Callable
from typing import IO, TYPE_CHECKING

from canwire.errors import BadLog
from canwire.logs.batch import log_dtype
from canwire.logs.source import LogFault, Source
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

FORKS = hasattr(os, "fork") and sys.platform != "darwin"  # where libraries of the system do not bear it


def read_apart(source: Source, read: Callable[[Source], numpy.ndarray]) -> numpy.ndarray:
    """Return the records and properties that `read` finds in the source; without fork, read in this process.

    Raises BadLog: that of `read`, for a reader that crashed, and for one that exceeds the source's limits.
    """
    if not FORKS:
        return read(source)
    told, tell = os.pipe()
    with tempfile.TemporaryFile() as records, open(told, "rb") as answer:
        with warnings.catch_warnings():
            warnings.simplefilter(
                "ignore", DeprecationWarning
            )  # threads: none of theirs is needed in the child
            child = os.fork()
        if not child:
            _read_here(source, read, records, tell)
        try:
            os.close(tell)
            text = answer.read() if select.select([answer], [], [], source.limits.seconds)[0] else None
            if text is None:
                os.kill(child, signal.SIGKILL)
        finally:
            status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        if text is None:
            raise source.beyond("seconds", "to read it takes longer")
        if not text:
            raise BadLog(f"{source.path}: a damaged file: reading it ended its process (status {status})")
        return _taken(source, json.loads(text), records)


def _taken(source: Source, told: dict[str, object], records: IO[bytes]) -> numpy.ndarray:
    """Copy the child's results to this process's source; returns the records. Raises BadLog."""
    if told["error"] == "memory":
        raise source.beyond("memory_bytes", "to read it takes more memory")
    if told["error"]:
        raise BadLog(str(told["error"]))
    for name in ("channels", "dated", "start_ns", "fault_count"):
        setattr(source, name, told[name])
    source.faults = [LogFault(*fault) for fault in told["faults"]]  # type: ignore[attr-defined]
    records.seek(0)
    return load_numpy().fromfile(records, log_dtype())


def _read_here(
    source: Source, read: Callable[[Source], numpy.ndarray], records: IO[bytes], tell: int
) -> None:
    """Run the reader in the child process, and always end that process here, without returning to the program."""
    faulthandler.disable()  # the parent reports a crash
    try:
        _limit_memory(source.limits.memory_bytes)
        error = ""
        try:
            read(source).tofile(records)
            records.flush()
        except BadLog as refused:
            error = str(refused)
        except MemoryError:
            error = "memory"
        told = {"error": error, "channels": source.channels, "dated": source.dated, "start_ns": source.start_ns,
                "faults": source.faults, "fault_count": source.fault_count}  # fmt: skip
        with open(tell, "w", encoding="utf-8", newline="\n") as answer:
            json.dump(told, answer)
    finally:
        os._exit(0)


def _limit_memory(size: int) -> None:
    """Limit the memory of this process to its present size plus this number of bytes."""
    import resource

    with open("/proc/self/statm", encoding="ascii") as file:
        now = int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    wanted = now + size
    resource.setrlimit(resource.RLIMIT_AS, (wanted if hard < 0 else min(wanted, hard), hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
