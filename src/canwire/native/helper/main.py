"""The helper program that ../core/start.c starts for process PID of this NAME, and ../win32/start.c with a PORT."""

from __future__ import annotations

import gc
import os
import sys


def main() -> None:
    """Answer until the program has ended; then this process ends, too."""
    program, name = int(sys.argv[1]), sys.argv[2]
    sys.argv[0] = name  # what others see who hold something of the hub
    status = 1
    try:
        gc.disable()  # a program's objects are few, and each is given back by hand
        _serve(program, name, "".join(sys.argv[3:]))
        status = 0
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        if sys.stderr is not None:
            sys.stderr.flush()
        os._exit(status)  # threads may still be answering; the system gives everything back


def _serve(program: int, name: str, where: str) -> None:
    """Serve the program; `where` is a port, the address at which this helper forks further ones, or ""."""
    if where.isdecimal():
        from canwire.native.helper.far import serve_far

        serve_far(int(where), program)
        return
    import socket

    from canwire.native.helper.near import serve_near
    from canwire.native.helper.warm import CHANNEL, Served, forked

    served = Served(program, name)
    if where:
        served = forked(served, where)
        sys.argv[0] = served.name
    serve_near(socket.socket(fileno=CHANNEL), served.process)
