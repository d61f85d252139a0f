"""The server of warm programs as the tests' process has it: asked for forks, told of their ends."""

from __future__ import annotations

import atexit
import json
import os
import socket
import subprocess
import sys
import tempfile
import threading
from functools import cache
from pathlib import Path
from typing import IO

SCRIPT = Path(__file__).with_name("server.py")
LENGTH = 8  # bytes that say how long a request is; the descriptors come with them


class Server:
    """A process that forks; it ends with this one."""

    def __init__(self) -> None:
        self._link, theirs = socket.socketpair()
        self._asking = threading.Lock()
        self._home = tempfile.TemporaryDirectory()
        self.address = str(Path(self._home.name) / "warm.sock")
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(self.address)
        listener.listen()
        numbers = [theirs.fileno(), listener.fileno()]
        self._process = subprocess.Popen(
            [sys.executable, str(SCRIPT), *map(str, numbers)],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            pass_fds=numbers,
        )
        theirs.close()
        listener.close()
        atexit.register(self.close)

    @staticmethod
    @cache
    def of_this_run() -> Server:
        return Server()

    def start(
        self,
        words: list[str],
        *,
        folder: str,
        environment: dict[str, str],
        own_session: bool,
        streams: list[int],
    ) -> tuple[IO[str], int]:
        """Python with these words: where its exit status will stand (as `os.waitpid` has it), and its number."""
        request = json.dumps([words, folder, environment, own_session]).encode()
        told, tell = os.pipe()
        try:
            with self._asking:
                socket.send_fds(self._link, [len(request).to_bytes(LENGTH)], [*streams, tell])
                self._link.sendall(request)
        finally:
            os.close(tell)
        answers = open(told, buffering=1)  # noqa: SIM115
        return answers, int(answers.readline())

    def close(self) -> None:
        self._link.close()
        self._process.wait()
        self._home.cleanup()
