"""Python programs that start in milliseconds: forked from a process of each worker that has imported canwire already.

What starts is a process of its own with its own arguments, environment, directory and descriptors, and it ends as any
Python program does; only the interpreter's start and the imports, a third of a second of a processor, are not repeated.
A test of how a program starts uses `subprocess.Popen` itself. Where this is not Linux, so does this.
"""

from __future__ import annotations

import atexit
import gc
import importlib
import importlib.util
import json
import os
import runpy
import select
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
HUBS_AND_VERBS = (
    "canwire.boards.wiring",
    "canwire.commands.dump.verb",
    "canwire.commands.send",
    "canwire.commands.serve",
    "canwire.commands.socketcan.run",
    "canwire.hub.handles.hub",
    "canwire.hub.links.answering",
    "canwire.hub.links.calling",
    "canwire.hub.links.unix_socket.server",
    "canwire.hub.usual",
    "canwire.socketcan.launch",
    "canwire.socketcan.programs",
    "canwire.socketcan.server",
    "numpy",
)
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}  # numpy's own threads would not be in what is forked
_STATUS = struct.Struct("i")
_LARGEST = 1 << 20  # bytes of one request


class Template:
    """The process that has imported these modules. Programs have no more of its environment than they are given."""

    def __init__(self, modules: Sequence[str], environment: Mapping[str, str] | None = None) -> None:
        self._modules, self._environment = modules, environment
        self._socket: socket.socket | None = None

    def start(self, words: Sequence[str], **options: Any) -> subprocess.Popen[str]:
        """`python WORDS`: `-m module ...` or `-c text ...`, with the options of `subprocess.Popen`."""
        if sys.platform != "linux":
            return cold(words, **options)
        return _Forked(self, list(words), text=True, **options)

    def ask(self, request: dict[str, Any], descriptors: Sequence[int]) -> None:
        """Have it fork; `descriptors` are the program's first three, and where its status is told."""
        if self._socket is None:
            self._socket = self._started()
        socket.send_fds(self._socket, [json.dumps(request).encode()], descriptors)

    def _started(self) -> socket.socket:
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        for end in (ours, theirs):
            end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 2 * _LARGEST)
        with theirs:
            command = [sys.executable, "-m", "tests.warm", str(theirs.fileno()), *self._modules]
            process = subprocess.Popen(
                command,
                cwd=ROOT,
                env={**(self._environment or os.environ), **_ONE_THREAD},
                pass_fds=[theirs.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
            )
        atexit.register(self._end, process)
        return ours

    def _end(self, process: subprocess.Popen[bytes]) -> None:
        assert self._socket is not None
        self._socket.close()
        process.wait()


class _Forked(subprocess.Popen[str]):
    """Popen of a process that is not this one's child: its keeper tells how it ended."""

    def __init__(self, template: Template, words: list[str], **options: Any) -> None:
        self._template = template
        self._session = options.get("start_new_session", False)
        self._told = -1
        super().__init__(words, **options)

    def _execute_child(self, args: list[str], *given: Any) -> None:  # type: ignore[override]
        cwd, env = given[4], given[5]
        pipes = given[9:15]
        own = (pipes[0], pipes[3], pipes[5])  # what the program reads and writes
        self._told, telling = os.pipe()
        request = {
            "words": args,
            "cwd": str(cwd or os.getcwd()),
            "environment": dict(os.environ if env is None else env),
            "session": self._session,
        }
        try:
            self._template.ask(request, [*(one if one != -1 else at for at, one in enumerate(own)), telling])
        finally:
            os.close(telling)
            self._close_pipe_fds(*pipes)
        self.pid = self._read()
        self._child_created = True

    def _read(self) -> int:
        told = os.read(self._told, _STATUS.size)
        if len(told) < _STATUS.size:
            raise AssertionError("the template of tests/warm.py has ended, or a program's keeper was killed")
        return int(_STATUS.unpack(told)[0])

    def _internal_poll(self, *_: Any, **__: Any) -> int | None:
        return self._look(0)

    def _wait(self, timeout: float | None) -> int:
        found = self._look(timeout)
        if found is None:
            assert timeout is not None
            raise subprocess.TimeoutExpired(self.args, timeout)
        return found

    def _look(self, timeout: float | None) -> int | None:
        """Its status, once it has ended."""
        if self.returncode is None and self._told >= 0:
            poll = select.poll()
            poll.register(self._told, select.POLLIN)
            if poll.poll(None if timeout is None else timeout * 1000):
                self.returncode = os.waitstatus_to_exitcode(self._read())
                os.close(self._told)
                self._told = -1
        return self.returncode


WARM = Template(HUBS_AND_VERBS)


def cold(words: Sequence[str], **options: Any) -> subprocess.Popen[str]:
    """`python WORDS` in an interpreter that has imported nothing."""
    return subprocess.Popen([sys.executable, *words], text=True, **options)


def canwire_verb(*words: str, **options: Any) -> subprocess.Popen[str]:
    """`python -m canwire WORDS`, warm."""
    return WARM.start(["-m", "canwire", *words], **options)


def cold_verb(*words: str, **options: Any) -> subprocess.Popen[str]:
    """The same, cold."""
    return cold(["-m", "canwire", *words], **options)


# In the template's process


def _next_program(listening: socket.socket) -> dict[str, Any]:
    """Returns in each program's process, whose descriptors, session and directory are its own by then."""
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # keepers end unheard
    while True:
        said, descriptors, _, _ = socket.recv_fds(listening, _LARGEST, 4)
        if not said:
            os._exit(0)
        if os.fork() == 0:
            break
        for descriptor in descriptors:
            os.close(descriptor)
    listening.close()
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    telling = descriptors.pop()
    if child := os.fork():
        _keep(child, telling, descriptors)
    os.close(telling)
    for wanted, descriptor in enumerate(descriptors):
        os.dup2(descriptor, wanted)
    for descriptor in descriptors:
        os.close(descriptor)
    request: dict[str, Any] = json.loads(said)
    if request["session"]:
        os.setsid()
    os.chdir(request["cwd"])
    return request


def _keep(child: int, telling: int, descriptors: Sequence[int]) -> None:
    """Tell the program's process id, and once it has ended how."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    for descriptor in (
        *range(3),
        *descriptors,
    ):  # whoever reads what the program writes waits for its end alone
        os.close(descriptor)
    os.write(telling, _STATUS.pack(child))
    _, status = os.waitpid(child, 0)
    os.write(telling, _STATUS.pack(status))
    os._exit(0)


def _become(request: dict[str, Any]) -> None:
    """Run what was asked for, as `python` would."""
    os.environ.clear()
    os.environ.update(request["environment"])
    sys.stdout.reconfigure(line_buffering=os.isatty(1))  # type: ignore[union-attr]
    kind, what, *words = request["words"]
    if kind == "-m":
        sys.path[0] = os.getcwd()
        sys.argv = [what, *words]
        runpy.run_module(what, run_name="__main__", alter_sys=True)
    else:
        assert kind == "-c", kind
        sys.path[0] = ""
        sys.argv = ["-c", *words]
        exec(compile(what, "<string>", "exec"), sys.modules["__main__"].__dict__)


if __name__ == "__main__":
    for module in sys.argv[2:]:
        if importlib.util.find_spec(module) is not None:  # numpy is an extra
            importlib.import_module(module)
    gc.collect()
    gc.freeze()  # what is there by now stays, and is not copied page by page
    _become(_next_program(socket.socket(fileno=int(sys.argv[1]))))
