"""`canwire` as a page's commands call it, in processes that are forked from one that has loaded it already.

A start of an interpreter that loads canwire takes half a second of processor time, and a page has up to forty. `Warm`
keeps one process that has; the script that it writes asks that one for a copy of itself, hands it its arguments,
environment, directory and streams, passes signals on, and ends as the copy does. That each verb can be started on its
own is shown by tests/commands.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import gc
import importlib
import json
import os
import select
import signal
import socket
import subprocess
import sys
import tempfile
from pathlib import Path

import canwire.__main__

_ASKS = """#!{python} -ISB
import json, os, signal, socket, sys
if "CANWIRE_PLATFORM" in os.environ:  # which is looked at while canwire is loaded
    os.execv(sys.executable, [sys.executable, "-m", "canwire", *sys.argv[1:]])
asking = socket.socket(socket.AF_UNIX)
asking.connect({address!r})
told = json.dumps([sys.argv[1:], dict(os.environ), os.getcwd()]).encode()
socket.send_fds(asking, [len(told).to_bytes(4, "big")], [0, 1, 2])
asking.sendall(told)
answers = asking.makefile()
pid = int(answers.readline())
for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
    signal.signal(number, lambda number, frame: os.kill(pid, number))
status = int(answers.readline() or 1)
if status < 0:
    signal.signal(-status, signal.SIG_DFL)
    os.kill(os.getpid(), -status)
sys.exit(status)
"""


class Warm:
    """The process that is copied; ends with `close`, or with its maker."""

    def __init__(self) -> None:
        self._home = tempfile.TemporaryDirectory()
        self._address = str(Path(self._home.name) / "warm.sock")
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(self._address)
        listener.listen()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.docs.warm", str(listener.fileno())],
            stdin=subprocess.PIPE,
            pass_fds=[listener.fileno()],
            cwd=Path(__file__).parents[2],
        )
        listener.close()

    def write_script(self, path: Path) -> None:
        """What a page finds as `canwire`."""
        path.write_text(_ASKS.format(python=sys.executable, address=self._address))
        path.chmod(0o755)

    def close(self) -> None:
        self._process.communicate()
        self._home.cleanup()


@functools.cache
def warm() -> Warm:
    """The one of this process."""
    made = Warm()
    atexit.register(made.close)
    return made


def _serve(listener: socket.socket) -> None:
    from canwire.commands import VERBS

    for verb in VERBS.values():
        importlib.import_module(verb.module)
    gc.freeze()
    while True:
        ready, _, _ = select.select([listener, 0], [], [])
        if 0 in ready:  # its maker has ended
            return
        asked, _ = listener.accept()
        if os.fork() == 0:
            listener.close()
            _attend(asked)
        asked.close()
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _attend(asked: socket.socket) -> None:
    """A copy with what was handed over; its number and its end are told. It is killed if nobody asks any more."""
    head, streams, _, _ = socket.recv_fds(asked, 4, 3)
    words, environment, folder = json.loads(_read(asked, int.from_bytes(head, "big")))
    pid = os.fork()
    if pid == 0:
        asked.close()
        _become(words, environment, folder, streams)
    for stream in (0, 1, 2, *streams):
        os.close(stream)
    with contextlib.suppress(BrokenPipeError):
        asked.sendall(f"{pid}\n".encode())
        ended = os.pidfd_open(pid)
        ready, _, _ = select.select([ended, asked], [], [])
        if ended not in ready:
            os.kill(pid, signal.SIGKILL)
        _, status = os.waitpid(pid, 0)
        asked.sendall(f"{os.waitstatus_to_exitcode(status)}\n".encode())
    os._exit(0)


def _read(asked: socket.socket, length: int) -> bytes:
    text = b""
    while len(text) < length:
        text += asked.recv(length - len(text))
    return text


def _become(words: list[str], environment: dict[str, str], folder: str, streams: list[int]) -> None:
    """`canwire` with these words: raises SystemExit."""
    for number, stream in enumerate(streams):
        os.dup2(stream, number)
        os.close(stream)
    os.environ.clear()
    os.environ.update(environment)
    os.chdir(folder)
    sys.argv = [canwire.__main__.__file__, *words]
    sys.exit(canwire.__main__.main())


if __name__ == "__main__":
    _serve(socket.socket(fileno=int(sys.argv[1])))
