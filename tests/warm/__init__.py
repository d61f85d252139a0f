"""Python programs in processes of their own that start warm: `subprocess.Popen` and `run` for `[sys.executable, ...]`.

Half a second of a program's start goes into importing modules, always the same ones. A server of this run has imported
them once; each program is a fork of it, which gets its words, folder, environment and streams, runs them as `python`
would, and ends as any interpreter ends. It is a process as others are, with signals, streams, threads and an exit
status of its own. `write_script` writes one that shells can start. Only what an interpreter does before its first
module is missing: tests of streams that are closed from the beginning, of signals during imports and of what is
imported at all start a cold one by `subprocess`.
"""

from __future__ import annotations

import inspect
import os
import select
import subprocess
import sys
from pathlib import Path
from typing import Any

from tests.warm.link import Server, share

__all__ = ["Popen", "ready", "run", "share", "write_script"]

# _socket and _signal are what socket and signal are built on: loading these takes longer than all the rest
_ASKS = """#!{python} -ISB
import _signal, _socket, marshal, os, sys
words = ["-m", "canwire", *sys.argv[1:]]
if "CANWIRE_PLATFORM" in os.environ:  # which is looked at while canwire is loaded
    os.execv(sys.executable, [sys.executable, *words])
asking = _socket.socket(_socket.AF_UNIX, _socket.SOCK_STREAM)
asking.connect({address!r})
request = marshal.dumps([words, os.getcwd(), dict(os.environ), False, [0, 1, 2]])
told, tell = os.pipe()
given = b"".join(number.to_bytes(4, sys.byteorder) for number in (0, 1, 2, tell))
asking.sendmsg([len(request).to_bytes(8, "big")], [(_socket.SOL_SOCKET, _socket.SCM_RIGHTS, given)])
asking.sendall(request)
asking.close()
os.close(tell)
answers = open(told, buffering=1)
number = int(answers.readline())
for each in (_signal.SIGINT, _signal.SIGTERM, _signal.SIGHUP):
    _signal.signal(each, lambda each, frame: os.kill(number, each))
status = os.waitstatus_to_exitcode(int(answers.readline()))
if status < 0:
    _signal.signal(-status, _signal.SIG_DFL)
    os.kill(os.getpid(), -status)
sys.exit(status)
"""

if hasattr(os, "fork"):

    class Popen(subprocess.Popen[Any]):
        """A warm program; as `subprocess.Popen`, whose pipes, `communicate` and signals these are."""

        def _execute_child(self, *given: Any) -> None:
            """Instead of fork and exec, ask the server for a fork."""
            asked = inspect.signature(subprocess.Popen._execute_child).bind(self, *given).arguments
            strange = [name for name in ("preexec_fn", "shell") if asked[name]]
            assert not strange, f"a warm program has no {strange}: start a cold one by subprocess"
            assert asked["args"][0] == sys.executable, f"{asked['args'][0]} is not this Python"
            inherited = (asked["p2cread"], asked["c2pwrite"], asked["errwrite"])
            self._told, self.pid = Server.of_this_run().start(
                [str(word) for word in asked["args"][1:]],
                folder=os.fspath(asked["cwd"] or os.getcwd()),
                environment=dict(asked["env"] or os.environ),
                own_session=bool(asked["start_new_session"]),
                descriptors={
                    **{number: number if given == -1 else given for number, given in enumerate(inherited)},
                    **{number: number for number in asked["pass_fds"]},
                },
            )
            self._child_created = True
            self._close_pipe_fds(*(asked[name] for name in ("p2cread", "p2cwrite", "c2pread", "c2pwrite",
                                                            "errread", "errwrite")))  # fmt: skip

        def _internal_poll(self, _deadstate: int | None = None, *_: Any) -> int | None:
            return self._ended(0)

        def _wait(self, timeout: float | None) -> int:
            if self._ended(timeout) is None:
                raise subprocess.TimeoutExpired(self.args, timeout or 0)
            return self.returncode

        def _ended(self, timeout: float | None) -> int | None:
            """The exit status, as soon as the server tells it."""
            if self.returncode is None and select.select([self._told], [], [], timeout)[0]:
                with self._waitpid_lock:
                    if self.returncode is None:  # no other thread has heard it meanwhile
                        self._handle_exitstatus(int(self._told.readline()))
                        self._told.close()
            return self.returncode

    def ready() -> None:
        """The server runs from now on: for those who count what this process has open."""
        Server.of_this_run()

    def write_script(path: Path) -> None:
        """`canwire` for a shell: asks for a fork, passes signals on to it, and ends as it does."""
        path.write_text(_ASKS.format(python=sys.executable, address=Server.of_this_run().address))
        path.chmod(0o755)

else:
    Popen = subprocess.Popen  # type: ignore[misc,assignment]

    def ready() -> None:
        """Nothing to start where there is no fork."""

    def write_script(path: Path) -> None:
        """`canwire` for a shell."""
        path.write_text(f"#!{sys.executable}\nfrom canwire.__main__ import main\nraise SystemExit(main())\n")
        path.chmod(0o755)


def run(
    command: list[str],
    *,
    input: str | None = None,
    capture_output: bool = False,
    timeout: float | None = None,
    check: bool = False,
    **options: Any,
) -> subprocess.CompletedProcess[Any]:
    """`subprocess.run` of a warm program."""
    if input is not None:
        options["stdin"] = subprocess.PIPE
    if capture_output:
        options["stdout"] = options["stderr"] = subprocess.PIPE
    with Popen(command, **options) as process:
        try:
            out, err = process.communicate(input, timeout)
        except BaseException:
            process.kill()
            raise
    done = subprocess.CompletedProcess(command, process.returncode, out, err)
    if check:
        done.check_returncode()
    return done
