"""Forks Python programs that have all modules already: `python server.py LIVES LISTENER`, two sockets' descriptors.

It is asked in connections to the second, one for each request. That is its length, with the descriptors of stdin,
stdout, stderr, of others that the program is to have, and of a pipe; then, by marshal: Python's words, folder,
environment, whether it has a session of its own, and the numbers that those descriptors have there.
Into the pipe go the process's number and, once it has ended, its status; if nobody can read that any more, the process
is killed. The server has one thread, as forks need it, and ends with the other end of the first, which its maker has.
"""

from __future__ import annotations

import atexit
import ctypes
import fcntl
import gc
import importlib
import io
import itertools
import marshal
import os
import pkgutil
import runpy
import select
import signal
import socket
import sys
from contextlib import suppress
from types import ModuleType
from typing import Any, NamedTuple

import shared_pages  # beside this script

LENGTH = 8
MOST_DESCRIPTORS = 32
MEGABYTES = 44  # that the interpreter takes for all of the modules below
PACKAGES = (
    "canwire.commands",
    "canwire.hub",
    "canwire.boards",
    "canwire.acan",
    "canwire.candrv",
    "canwire.slcan",
    "canwire.socketcan",
    "canwire.threads",
    "canwire.python_can",
)
OTHERS = (
    "textual.app",
    "textual.widgets",
    "can",
    "can.interfaces.slcan",
    "serial",
    "argcomplete",
    "numpy",
    "resource",
)
NOT_LOADED = (
    "canwire.commands.plot.picture",  # much to load for few programs
    "canwire.socketcan._shim",  # what programs in C load: no module of Python
)
UNDERSTOOD = {"PYTHONPATH", "PYTHONUNBUFFERED"}  # of the variables that Python reads at its start


class Asked(NamedTuple):
    """A program to become."""

    words: list[str]
    folder: str
    environment: dict[str, str]
    own_session: bool
    numbers: list[int]
    descriptors: list[int]
    tell: int


def load() -> None:
    """What programs will need; nothing of it starts a thread."""
    before = set(sys.modules)
    shared_pages.in_one_piece(MEGABYTES)
    os.environ["OPENBLAS_NUM_THREADS"] = "1"  # else numpy starts some
    atexit.register(lambda: end(loaded))  # the first one, so it runs last
    sys.modules["asammdf"] = None  # type: ignore[assignment]  # python-can would load half of pandas for it
    names = list(OTHERS)
    for package in PACKAGES:
        folders = importlib.import_module(package).__path__
        names += [found.name for found in pkgutil.walk_packages(folders, f"{package}.")]
    for name in names:
        if name not in NOT_LOADED:
            with suppress(ImportError):  # of an extra that is not installed: programs that need it say so
                importlib.import_module(name)
    del sys.modules["asammdf"]
    loaded = set(sys.modules) - before
    assert _alone() or not os.path.exists("/proc/self/task")
    gc.collect()
    gc.freeze()
    shared_pages.join()


class Ended:
    """How a fork has ended, once its program has."""

    status: int | None = None  # None: by an exception, of which the interpreter is yet to speak


def end(loaded: set[str]) -> None:
    """The last thing before the interpreter takes itself apart.

    That would write into most of the pages that all forks share, 20 ms each time. Other threads may meet it, and what
    it says is to be seen; a program that has no other thread and an exit status shows nothing by it.
    """
    with suppress(OSError, ValueError):  # of a stream without a reader, which the interpreter itself reports
        if Ended.status is not None and _alone():
            for stream in (sys.stdout, sys.stderr):
                if stream is not None and not stream.closed:
                    stream.flush()
            os._exit(Ended.status)
    keep(set(sys.modules) & loaded)


def _alone() -> bool:
    return os.path.exists("/proc/self/task") and len(os.listdir("/proc/self/task")) == 1


def keep(names: set[str]) -> None:
    """At a program's end these modules stay: taking them apart would take longer than most programs do.

    Everything in them stands on pages that all forks share, each of which it would copy to write into it.
    """
    kept = [sys.modules.pop(name) for name in names]
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(kept))
    gc.freeze()


class Forks:
    """Asked on a socket, told of ends by SIGCHLD."""

    def __init__(self, lives: socket.socket, listener: socket.socket) -> None:
        self._lives = lives
        self._listener = listener
        self._poll = select.poll()
        self._tell: dict[int, int] = {}  # the pipe for each process's end
        self._woken, wake = os.pipe()
        os.set_blocking(wake, False)
        signal.set_wakeup_fd(wake)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        for source in (lives.fileno(), listener.fileno(), self._woken):
            self._poll.register(source, select.POLLIN)

    def serve(self) -> Asked | None:
        """In the server this lasts until its maker has ended; in each fork it returns what to become."""
        while True:
            ready = [number for number, _ in self._poll.poll()]
            if self._woken in ready:
                os.read(self._woken, 4096)
                self._tell_ends()
            for number in [process for process, tell in self._tell.items() if tell in ready]:
                os.kill(number, signal.SIGKILL)  # whoever asked has gone
                self._poll.unregister(self._tell[number])
            if self._listener.fileno() in ready:
                with self._listener.accept()[0] as asking:
                    asked = receive(asking)
                if asked is not None and not self._forked(asked):
                    return asked
            if self._lives.fileno() in ready:
                return None

    def _forked(self, asked: Asked) -> bool:
        """False in the fork."""
        # until the fork has its own handlers
        signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
        number = os.fork()
        if number == 0:
            return False
        signal.pthread_sigmask(signal.SIG_SETMASK, ())
        for descriptor in asked.descriptors:
            os.close(descriptor)
        self._tell[number] = asked.tell
        self._poll.register(asked.tell, 0)
        with suppress(BrokenPipeError):  # the poll tells that whoever asked has gone
            os.write(asked.tell, b"%d\n" % number)
        return True

    def _tell_ends(self) -> None:
        """To whoever asked for the programs that have ended."""
        while self._tell:
            number, status = os.waitpid(-1, os.WNOHANG)
            if number == 0:
                return
            tell = self._tell.pop(number)
            with suppress(KeyError):  # it was killed since nobody wants to know
                self._poll.unregister(tell)
            with suppress(BrokenPipeError):
                os.write(tell, b"%d\n" % status)
            os.close(tell)


def receive(link: socket.socket) -> Asked | None:
    """A request; None where nobody can ask any more."""
    length, descriptors, _, _ = socket.recv_fds(link, LENGTH, MOST_DESCRIPTORS)
    if not length:
        return None
    request = b""
    while len(request) < int.from_bytes(length):
        request += link.recv(int.from_bytes(length) - len(request))
    return Asked(*marshal.loads(request), descriptors[:-1], descriptors[-1])


def become(asked: Asked, interrupted: Any) -> None:
    """This fork is now as a Python that has just started."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.signal(signal.SIGINT, interrupted)
    if asked.own_session:
        os.setsid()
    arrange(asked.descriptors, asked.numbers)
    os.chdir(asked.folder)
    strange = {
        name
        for name in {*os.environ, *asked.environment}
        if name.startswith("PYTHON") and os.environ.get(name) != asked.environment.get(name)
    }
    assert strange <= UNDERSTOOD, f"Python reads {strange} at its start, and has started"
    os.environ.clear()
    os.environ.update(asked.environment)
    new_streams(bool(asked.environment.get("PYTHONUNBUFFERED")))
    for place in reversed(asked.environment.get("PYTHONPATH", "").split(os.pathsep)):
        if place and place not in sys.path:
            sys.path.insert(0, place)
    signal.pthread_sigmask(signal.SIG_SETMASK, ())


def arrange(descriptors: list[int], numbers: list[int]) -> None:
    """These descriptors at these numbers, and no other is open."""
    above = 1 + max(numbers)
    for descriptor, number in zip(
        [fcntl.fcntl(each, fcntl.F_DUPFD, above) for each in descriptors], numbers, strict=True
    ):
        os.dup2(descriptor, number)
    for last, number in itertools.pairwise([*sorted(numbers), above + 1024]):
        os.closerange(last + 1, number)


def new_streams(unbuffered: bool) -> None:
    """As the interpreter makes them."""
    for number, (name, mode) in enumerate((("stdin", "rb"), ("stdout", "wb"), ("stderr", "wb"))):
        own = getattr(sys, name)
        below = open(number, mode, buffering=0 if unbuffered and number else -1, closefd=False)  # noqa: SIM115
        by_lines = not unbuffered and (number == 2 or below.isatty())
        stream = io.TextIOWrapper(
            below,
            own.encoding,
            own.errors,
            newline="\n" if number else None,
            line_buffering=by_lines,
            write_through=unbuffered,
        )
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)


def run(words: list[str]) -> None:
    """As `python WORDS`, whose exit status is kept."""
    try:
        run_program(words)
        Ended.status = 0
    except SystemExit as ended:
        if ended.code is None or isinstance(ended.code, int):
            Ended.status = int(ended.code or 0) & 0xFF
        raise


def run_program(words: list[str]) -> None:
    """As the interpreter does: a module, a text or a file."""
    if words[0] == "-m":
        sys.path.insert(0, os.getcwd())
        sys.argv = words[1:]
        runpy.run_module(words[1], run_name="__main__", alter_sys=True)
    elif words[0] == "-c":
        sys.path.insert(0, "")
        sys.argv = ["-c", *words[2:]]
        sys.modules["__main__"] = ModuleType("__main__")
        exec(compile(words[1], "<string>", "exec"), vars(sys.modules["__main__"]))
    else:
        sys.path.insert(0, os.path.dirname(words[0]))
        sys.argv = words
        runpy.run_path(words[0], run_name="__main__")


def main() -> None:
    interrupted = signal.getsignal(signal.SIGINT)
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C ends the tests, and these the server
    lives, listener = (socket.socket(fileno=int(number)) for number in sys.argv[1:])
    sys.path = [place for place in sys.path if place != os.path.dirname(os.path.abspath(__file__))]
    load()
    asked = Forks(lives, listener).serve()
    if asked is not None:
        lives.detach()
        listener.detach()
        become(asked, interrupted)
        run(asked.words)


if __name__ == "__main__":
    main()
