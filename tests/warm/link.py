"""The server of warm programs as the tests' process has it: asked for forks, told of their ends."""

from __future__ import annotations

import atexit
import json
import marshal
import os
import select
import socket
import subprocess
import sys
import tempfile
import threading
from functools import cache
from pathlib import Path
from typing import IO

import canwire

SCRIPT = Path(__file__).with_name("server.py")
LENGTH = 8  # bytes that say how long a request is; the descriptors come with them
SHARED = "CANWIRE_TESTS_WARM"  # in the environment of a run's workers: what their server has loaded, and its address


class Server:
    """Somebody who forks, at an address."""

    def __init__(self, address: str) -> None:
        self.address = address

    @staticmethod
    @cache
    def of_this_run() -> Server:
        *loaded, address = json.loads(os.environ.get(SHARED, "[null]"))
        return Server(address) if loaded == _to_load() else OwnServer()

    def start(
        self,
        words: list[str],
        *,
        folder: str,
        environment: dict[str, str],
        own_session: bool,
        descriptors: dict[int, int],
    ) -> tuple[IO[str], int]:
        """Python with these words: where its exit status will stand (as `os.waitpid` has it), and its number.

        It has these descriptors, each with a number of its own there: 0 to 2 are the streams.
        """
        request = marshal.dumps([words, folder, environment, own_session, [*descriptors]])
        told, tell = os.pipe()
        try:
            with socket.socket(socket.AF_UNIX) as asking:
                asking.connect(self.address)
                socket.send_fds(asking, [len(request).to_bytes(LENGTH)], [*descriptors.values(), tell])
                asking.sendall(request)
        finally:
            os.close(tell)
        answers = open(told, buffering=1)  # noqa: SIM115
        return answers, int(answers.readline())


class OwnServer(Server):
    """A process that forks, from now on or from when somebody asks; it ends with this one."""

    def __init__(self, *, when_asked: bool = False) -> None:
        self._home = tempfile.TemporaryDirectory()
        super().__init__(str(Path(self._home.name) / "warm.sock"))
        self._listener = socket.socket(socket.AF_UNIX)
        self._listener.bind(self.address)
        self._listener.listen()
        self._lives, self._theirs = socket.socketpair()
        self._process: subprocess.Popen[bytes] | None = None
        atexit.register(self.close)
        if when_asked:
            threading.Thread(target=self._start_when_asked, daemon=True).start()
        else:
            self._start()

    def close(self) -> None:
        self._lives.close()
        if self._process is not None:
            self._process.wait()
        self._home.cleanup()

    def _start_when_asked(self) -> None:
        select.select([self._listener], [], [])
        self._start()

    def _start(self) -> None:
        numbers = [self._theirs.fileno(), self._listener.fileno()]
        self._process = subprocess.Popen(
            [sys.executable, str(SCRIPT), *map(str, numbers)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=numbers,
        )
        self._theirs.close()
        self._listener.close()


def share() -> None:
    """Let the workers that this process starts have one server; it starts when the first of them asks for a program."""
    os.environ[SHARED] = json.dumps([*_to_load(), OwnServer(when_asked=True).address])


def _to_load() -> list[str]:
    """What makes one server another: whose Python, which canwire, and in which variant it is loaded."""
    return [sys.executable, str(canwire.__file__), os.environ.get("CANWIRE_PLATFORM", "")]
