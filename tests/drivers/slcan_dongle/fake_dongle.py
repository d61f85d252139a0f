"""A scripted adapter on a pseudo terminal that a link in a temporary directory names; used by tests alone."""

from __future__ import annotations

import contextlib
import os
import pty
import socket
import threading
import tty
from collections.abc import Callable
from pathlib import Path

from canwire.platform import wait_readable

AGES_S = 60.0
Answers = Callable[[bytes], bytes | None]


def usual(line: bytes) -> bytes:
    """What a CANBUS dongle answers, whatever state it is in."""
    replies = {b"V": b"V1013\r", b"N": b"NA123\r", b"F": b"F00\r"}
    if line in replies:
        return replies[line]
    if line[:1] in (b"t", b"r"):
        return b"z\r"
    return b"Z\r" if line[:1] in (b"T", b"R") else b"\r"


class FakeDongle:
    """`answer` may be changed at any time; `lines` are the commands so far, `wait_for` waits for one."""

    def __init__(self, link: Path, answer: Answers = usual) -> None:
        self.link = link
        self.answer = answer
        self.lines: list[bytes] = []
        self._news = threading.Condition()
        self._writing = threading.Lock()
        self._master = -1
        self.appear()

    def appear(self) -> None:
        """It is plugged in, on a new terminal."""
        self._master, slave = pty.openpty()
        tty.setraw(slave)
        name = os.ttyname(slave)
        os.close(slave)
        self._keep = os.open(
            name, os.O_RDWR | os.O_NOCTTY
        )  # else the master reads errors until somebody opens it
        self.link.unlink(missing_ok=True)
        self.link.symlink_to(name)
        self._end, end = os.pipe()
        self._thread = threading.Thread(target=self._serve, args=(self._master, end), daemon=True)
        self._thread.start()

    def vanish(self) -> None:
        """It is pulled out."""
        self.link.unlink(missing_ok=True)
        master, self._master = self._master, -1
        if master >= 0:
            os.close(self._end)
            self._thread.join(AGES_S)
            os.close(self._keep)

    close = vanish

    def say(self, data: bytes) -> None:
        """Line by line, so that answers do not get into the middle of one."""
        for line in data.splitlines(keepends=True):
            self._write(self._master, line)

    def _write(self, master: int, data: bytes) -> None:
        with self._writing:
            view = memoryview(data)
            while view:
                view = view[os.write(master, view) :]

    def wait_for(self, line: bytes, count: int = 1) -> None:
        """Until that command has come so many times."""
        with self._news:
            assert self._news.wait_for(lambda: self.lines.count(line) >= count, AGES_S), (line, self.lines)

    def _serve(self, master: int, end: int) -> None:
        """Until the other end of `end` is closed; a terminal that is being read cannot be closed."""
        rest = b""
        while wait_readable([master, end], None) and not wait_readable([end], 0):
            data = os.read(master, 4096)
            *lines, rest = (rest + data).split(b"\r")
            for line in lines:
                with self._news:
                    self.lines.append(line)
                    self._news.notify_all()
                reply = self.answer(line)
                if reply:
                    with contextlib.suppress(OSError):
                        self._write(master, reply)
        os.close(master)
        os.close(end)


class FakeServer:
    """The same behind a TCP port of this machine."""

    def __init__(self, answer: Answers = usual) -> None:
        self.lines: list[bytes] = []
        self._answer = answer
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"
        threading.Thread(target=self._serve, daemon=True).start()

    def close(self) -> None:
        self._listener.close()

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                connection, _ = self._listener.accept()
                rest = b""
                with connection:
                    while data := connection.recv(4096):
                        *lines, rest = (rest + data).split(b"\r")
                        self.lines += lines
                        for line in lines:
                            connection.sendall(self._answer(line) or b"")
