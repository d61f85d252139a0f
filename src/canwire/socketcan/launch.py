"""Starts a program so that it finds its server, which is not its child and ends after it.

The process of `canwire run` becomes the program: process id, signals, exit status, terminal and job control are the
program's. The server is a grandchild in a separate session.
"""

from __future__ import annotations

import ctypes
import os
import shutil
import signal
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from canwire import CanwireError, Unsupported
from canwire.socketcan.programs import is_for_musl
from canwire.socketcan.rings import has_room

DIRECTORY_VARIABLE = "CANWIRE_SOCKETCAN"
_ROOM = 8 << 20  # bytes: the table, and some sockets
_LONGEST_PATH = 90  # of a socket there, below what struct sockaddr_un holds

_IGNORED_BY_PYTHON = ("SIGPIPE", "SIGXFSZ")
_KIN_FROM = 200  # descriptors that programs and scripts use by number are below

Serving = Callable[[str, tuple[int, int], Callable[[], object]], object]
"""Called in the server's process: directory, what is readable at the end of the program and of everything that it has
started, and what to call when programs can come."""


def shim() -> str:
    """The path of the shared object to preload; raises Unsupported if it was not built."""
    found = sorted(Path(__file__).parent.glob("_shim*.so"))
    if sys.platform != "linux" or not found:
        raise Unsupported(
            "the SocketCAN shim is missing: it is built with canwire on Linux if a C compiler is found"
        )
    return str(found[0])


def environment(directory: str, *, preloads: bool = True) -> dict[str, str]:
    """The environment for the program."""
    variables = {**os.environ, DIRECTORY_VARIABLE: directory}
    if preloads:
        variables["LD_PRELOAD"] = ":".join([shim(), *filter(None, [os.environ.get("LD_PRELOAD")])])
    return variables


def launch(
    program: str,
    arguments: list[str],
    serving: Serving,
    complain: Callable[[str], object],
    *,
    supervised: bool,
) -> None:
    """Become the program, once its server is ready; does not return. Raises CanwireError, OSError before that.

    `supervised`: it preloads nothing, and the server answers its calls.
    """
    directory = tempfile.mkdtemp(prefix="canwire-run-", dir=_place())
    musl = is_for_musl(shutil.which(program) or program)
    variables = environment(directory, preloads=not musl)
    complaint = _start(directory, serving)
    if complaint:
        raise CanwireError(complaint)
    sys.stdout.flush()
    for name in _IGNORED_BY_PYTHON:  # a program that is started otherwise finds them as they are by default
        signal.signal(getattr(signal, name), signal.SIG_DFL)
    if supervised:
        os.environ[DIRECTORY_VARIABLE] = directory  # where canwire_supervise finds the server
        if error := ctypes.CDLL(shim()).canwire_supervise():
            complain(
                f"{program} preloads nothing, and seccomp is not allowed here ({os.strerror(error)}): it has no CAN"
            )
    os.execvpe(program, [program, *arguments], variables)


def _place() -> str:
    """The runtime directory if its name is short enough for sockets and it has room, else the temporary directory."""
    runtime, usual = os.environ.get("XDG_RUNTIME_DIR", ""), tempfile.gettempdir()
    places = [runtime] if os.path.isdir(runtime) and len(runtime) < _LONGEST_PATH - 30 else []
    for place in (*places, usual):
        if has_room(place, _ROOM):
            return place
    raise CanwireError(
        f"{' and '.join([*places, usual])}: less than {_ROOM >> 20} MB are free there; "
        "make room, or set TMPDIR to a directory that has some"
    )


def _start(directory: str, serving: Serving) -> str:
    """Start the server; returns the reason if that fails, else ""."""
    program = os.pidfd_open(os.getpid())
    kin, inherited = os.pipe()
    reading, writing = os.pipe()
    middle = os.fork()
    if middle == 0:
        os.close(reading)
        os.close(inherited)
        if os.fork() == 0:
            _serve(directory, serving, (program, kin), writing)
        os._exit(0)
    for descriptor in (writing, program, kin):
        os.close(descriptor)
    _leave_to_kin(inherited)
    os.waitpid(middle, 0)
    with os.fdopen(reading, "rb") as pipe:
        told = pipe.read().decode()
    return "" if told == _READY else told or "its server ended without a message"


_READY = "ready"


def _leave_to_kin(descriptor: int) -> None:
    """The program and what it starts have this open until they end."""
    import fcntl  # Linux' own, as `resource` is; `shim` says the same everywhere

    try:
        fcntl.fcntl(descriptor, fcntl.F_DUPFD, _KIN_FROM)
    except OSError:  # so few are allowed: where it is, then
        os.set_inheritable(descriptor, True)
    else:
        os.close(descriptor)


def _serve(directory: str, serving: Serving, program: tuple[int, int], writing: int) -> None:
    """The server's process from beginning to end."""
    status = 0
    telling = os.fdopen(writing, "wb", buffering=0)

    def ready() -> None:
        telling.write(_READY.encode())
        telling.close()

    # else numpy starts threads, which keep the other cores busy for a tenth of a second and have nothing to do
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        os.setsid()
        _allow_descriptors()
        _let_go_of_terminal()
        serving(directory, program, ready)
    except (CanwireError, OSError) as error:
        status = 2
        if telling.closed:
            print(f"canwire: {error}", file=sys.stderr)
        else:
            telling.write(str(error).encode())
    except KeyboardInterrupt:  # SIGTERM, as everything has at the end of a session
        status = 1
    except BaseException:
        status = 1
        sys.excepthook(*sys.exc_info())
    finally:
        shutil.rmtree(directory, ignore_errors=True)
        sys.stderr.flush()
        os._exit(status)


def _allow_descriptors() -> None:
    """Every socket of a program takes one here."""
    import resource

    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))


def _let_go_of_terminal() -> None:
    """A reader of the program's output does not wait for the server's end."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, 0)
    os.dup2(nowhere, 1)
    os.close(nowhere)
