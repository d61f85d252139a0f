"""What the native core starts for process PID of this NAME; the socket is descriptor 3 (../core/start.c)."""

from __future__ import annotations

import os
import socket
import sys

from canwire.native.helper.serving import serve

CHANNEL = 3  # ../core/start.c


def main() -> None:
    """Answer until the program has ended; then nothing of this process is left either."""
    program, name = int(sys.argv[1]), sys.argv[2]
    sys.argv[0] = name  # what others see who hold something of the hub
    status = 1
    try:
        serve(socket.socket(fileno=CHANNEL), program)
        status = 0
    except BaseException:
        sys.excepthook(*sys.exc_info())
    finally:
        sys.stderr.flush()
        os._exit(status)  # threads may still be answering; the system gives everything back
