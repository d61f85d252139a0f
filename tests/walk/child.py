"""Attempts in a process of their own: a crash or a hang is a row with the attempt's name, and the next one goes on."""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import itertools
import mmap
import os
import resource
import signal
import struct
import sys
import time
from collections.abc import Callable, Iterator

from tests.walk.attempts import Attempt

_HANG_S = 10  # of processor time ...
_SLEEP_S = 60  # ... or of the clock, for one attempt
_HEAD = struct.Struct(
    "=QQQQ"
)  # attempt's number, how far it is, length of its name, of the wrong answers' text
_COLLECTING_S = 60
_DONE, _COLLECTING = 1, 2
_FAILED = 70
_NAME = 1024
_SIZE = 1 << 16
_MEMORY = 4 << 30
_FILE = 64 << 20
_SIGNALS = {
    signal.SIGPROF: f"takes over {_HANG_S} s of processor time",
    signal.SIGALRM: f"waits over {_SLEEP_S} s",
}


class Walked:
    """What came of one module: how many attempts there were, and rows of what went wrong."""

    def __init__(self) -> None:
        self.count = 0
        self.wrong: list[str] = []


def walked(attempts: Callable[[], Iterator[Attempt]], folder: str, until: float | None = None) -> Walked:
    """Do them in forked processes, one after another in each, until all are done, or the processor time is over.

    `attempts` is called in each of them, and gives the same attempts each time. Processes of their own start where the
    one before has ended.
    """
    told, result = mmap.mmap(-1, _SIZE), Walked()
    start = 0
    while True:
        told[: _HEAD.size] = _HEAD.pack(start, 0, 0, 0)
        child = os.fork()
        if child == 0:
            try:
                _in_child(attempts, folder, told, start, until)
            finally:
                os._exit(_FAILED)  # the walk's own failure, which is not to go on in two processes
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        number, done, length, wrong = _HEAD.unpack_from(told)
        texts = bytes(told[_HEAD.size + _NAME : _HEAD.size + _NAME + wrong]).decode(errors="replace")
        result.wrong += texts.splitlines()
        result.count += number - start + (not done)
        if done == _COLLECTING:
            result.wrong.append(f"the end, where everything is collected: {_ending(status)}")
        if done:
            return result
        if status == _FAILED:
            result.wrong.append(f"the walk itself failed after attempt {number}")
            return result
        name = bytes(told[_HEAD.size : _HEAD.size + length]).decode(errors="replace")
        result.wrong.append(f"{name}: {_ending(status)}")
        start = number + 1
        if until is not None and time.monotonic() > until:
            return result


def _ending(status: int) -> str:
    if status >= 0:
        return f"ends the process with status {status}"
    return _SIGNALS.get(signal.Signals(-status), signal.Signals(-status).name)


def _in_child(
    attempts: Callable[[], Iterator[Attempt]], folder: str, told: mmap.mmap, start: int, until: float | None
) -> None:
    """Ends the process."""
    _alone(folder)
    number = start
    for attempt in itertools.islice(attempts(), start, None):
        name = attempt.name.encode(errors="replace")[:_NAME]
        told[_HEAD.size : _HEAD.size + len(name)] = name
        wrong = _HEAD.unpack_from(told)[3]
        told[: _HEAD.size] = _HEAD.pack(number, 0, len(name), wrong)
        _limit(_HANG_S, _SLEEP_S)
        text = outcome(attempt)
        _limit(0, 0)
        if text:
            row = f"{attempt.name}: {text}\n".encode(errors="replace")
            begin = _HEAD.size + _NAME + wrong
            if begin + len(row) <= _SIZE:
                told[begin : begin + len(row)] = row
                wrong += len(row)
        number += 1
        told[: _HEAD.size] = _HEAD.pack(number, 0, len(name), wrong)
        if until is not None and time.monotonic() > until:
            break
    wrong = _HEAD.unpack_from(told)[3]
    told[: _HEAD.size] = _HEAD.pack(number, _COLLECTING, 0, wrong)
    _limit(_COLLECTING_S, _COLLECTING_S)
    gc.collect()
    told[: _HEAD.size] = _HEAD.pack(number, _DONE, 0, wrong)
    os._exit(0)


def outcome(attempt: Attempt) -> str:
    """What an attempt did that nothing may do; "" for any other exception."""
    try:
        attempt.call()
    except SystemError as error:
        return f"SystemError: {error}"[:300].replace("\n", " ")
    except BaseException:  # SystemExit, too: what is right is for tests/attacks/doors
        return ""
    return ""


def _limit(processor_s: int, clock_s: int) -> None:
    signal.setitimer(signal.ITIMER_PROF, processor_s)
    signal.setitimer(signal.ITIMER_REAL, clock_s)


def _alone(folder: str) -> None:
    """Nothing that is tried here comes out of this process."""
    faulthandler.disable()  # pytest has it write where tests' output goes
    os.chdir(folder)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(nowhere, stream)
    for each in (signal.SIGPROF, signal.SIGALRM, signal.SIGINT):
        signal.signal(each, signal.SIG_DFL)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_FSIZE, (_FILE, _FILE))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    if "libasan" not in os.environ.get("LD_PRELOAD", ""):  # which takes terabytes of addresses
        with contextlib.suppress(ValueError):
            resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
    sys.setswitchinterval(1e-6)
