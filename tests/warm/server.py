"""Forks Python programs that have all modules already: `python server.py DESCRIPTOR`, on whose socket it is asked.

A request is its length, with the descriptors of stdin, stdout, stderr and of a pipe; then JSON: Python's words, folder,
environment, and whether it has a session of its own. Into the pipe go the process's number and, once it has ended, its
status. The server has one thread, as forks need it, and ends when nobody can ask it any more.
"""

from __future__ import annotations

import atexit
import ctypes
import gc
import importlib
import io
import json
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

LENGTH = 8
PACKAGES = (
    "canwire.commands",
    "canwire.hub",
    "canwire.boards",
    "canwire.acan",
    "canwire.candrv",
    "canwire.slcan",
)
OTHERS = ("textual.app", "textual.widgets", "can", "can.interfaces.slcan", "serial", "argcomplete")
HEAVY = ("canwire.commands.plot.picture",)
UNDERSTOOD = {"PYTHONPATH", "PYTHONUNBUFFERED"}  # of the variables that Python reads at its start


class Asked(NamedTuple):
    """A program to become."""

    words: list[str]
    folder: str
    environment: dict[str, str]
    own_session: bool
    streams: list[int]
    tell: int


def load() -> None:
    """What programs will need; nothing of it starts a thread."""
    before = set(sys.modules)
    atexit.register(lambda: keep(set(sys.modules) & loaded))  # the first one, so it runs last
    sys.modules["asammdf"] = None  # type: ignore[assignment]  # python-can would load half of pandas for it
    for package in PACKAGES:
        folders = importlib.import_module(package).__path__
        for found in pkgutil.walk_packages(folders, f"{package}."):
            if found.name not in HEAVY:
                importlib.import_module(found.name)
    for name in OTHERS:
        with suppress(ImportError):
            importlib.import_module(name)
    del sys.modules["asammdf"]
    loaded = set(sys.modules) - before
    if os.path.exists("/proc/self/task"):
        assert len(os.listdir("/proc/self/task")) == 1
    gc.collect()
    gc.freeze()


def keep(names: set[str]) -> None:
    """At a program's end these modules stay: taking them apart would take longer than most programs do.

    Everything in them stands on pages that all forks share, each of which it would copy to write into it.
    """
    kept = [sys.modules.pop(name) for name in names]
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(kept))
    gc.freeze()


def serve(link: socket.socket) -> Asked | None:
    """In the server this lasts until nobody can ask any more; in each fork it returns what to become."""
    woken, wake = os.pipe()
    os.set_blocking(wake, False)
    signal.set_wakeup_fd(wake)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    tell: dict[int, int] = {}
    while True:
        readable, _, _ = select.select([link, woken], [], [])
        if woken in readable:
            os.read(woken, 4096)
            tell_ends(tell)
        if link in readable:
            asked = receive(link)
            if asked is None:
                return None
            # until the fork has its own handlers
            signal.pthread_sigmask(signal.SIG_BLOCK, signal.valid_signals())
            number = os.fork()
            if number == 0:
                return asked
            signal.pthread_sigmask(signal.SIG_SETMASK, ())
            for stream in asked.streams:
                os.close(stream)
            tell[number] = asked.tell
            with suppress(BrokenPipeError):  # whoever asked has gone
                os.write(asked.tell, b"%d\n" % number)


def tell_ends(tell: dict[int, int]) -> None:
    """To whoever asked for the programs that have ended."""
    while tell:
        number, status = os.waitpid(-1, os.WNOHANG)
        if number == 0:
            return
        with suppress(BrokenPipeError):  # nobody wants to know
            os.write(tell[number], b"%d\n" % status)
        os.close(tell.pop(number))


def receive(link: socket.socket) -> Asked | None:
    length, descriptors, _, _ = socket.recv_fds(link, LENGTH, 4)
    if not length:
        return None
    request = b""
    while len(request) < int.from_bytes(length):
        request += link.recv(int.from_bytes(length) - len(request))
    return Asked(*json.loads(request), descriptors[:3], descriptors[3])


def become(asked: Asked, interrupted: Any) -> None:
    """This fork is now as a Python that has just started."""
    signal.set_wakeup_fd(-1)
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    signal.signal(signal.SIGINT, interrupted)
    if asked.own_session:
        os.setsid()
    for number, stream in enumerate(asked.streams):
        os.dup2(stream, number)
    os.closerange(3, 1024)
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
    """As `python WORDS`."""
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
    link = socket.socket(fileno=int(sys.argv[1]))
    del sys.path[0]  # this folder
    load()
    asked = serve(link)
    if asked is not None:
        link.detach()
        become(asked, interrupted)
        run(asked.words)


if __name__ == "__main__":
    main()
