"""What is measured beside the storm, each by a process of its own: `python beside.py leases|calls|sleeps ADDRESS`.

`leases`: a program that holds a line's control is killed, and again; a line for each: milliseconds until somebody
else has it. `calls`: milliseconds that a call took, every 20 ms. `sleeps`: how late a process woke that asked nobody
for anything but 20 ms of sleep, which is the machine's own doing. They end with their input or with the hub.
"""

from __future__ import annotations

import contextlib
import os
import select
import signal
import subprocess
import sys
import time

import canwire

_BOARD, _LINE = "HW00", 1
_PAUSE_S = 0.15
_CALL_EVERY_S = 0.02
_PATIENCE_S = 60.0


def zygote(address: str) -> None:
    """For each line of its input a child that takes the control and says its number; it has no connection itself."""
    import canwire.hub.connect

    signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    while sys.stdin.buffer.raw.readline():  # type: ignore[attr-defined]
        if os.fork() == 0:
            try:
                hub = canwire.connect(address, name="holder")
                kept = hub.open_control(hub.board(_BOARD).id, _LINE)
            except canwire.HubError:  # who waits for its number must not wait for ever
                print(0, flush=True)
                os._exit(1)
            print(os.getpid(), flush=True)
            time.sleep(3600)
            del kept


def leases(address: str) -> None:
    hub = canwire.connect(address, name="waits for leases")
    board = hub.board(_BOARD).id
    words = [sys.executable, __file__, "zygote", address]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as parent:
        assert parent.stdin is not None
        assert parent.stdout is not None
        while not _over(_PAUSE_S):
            parent.stdin.write("\n")
            parent.stdin.flush()
            holder = int(parent.stdout.readline())
            if not holder:
                hub.boards()  # raises if the hub is gone
                continue
            os.kill(holder, signal.SIGKILL)
            print(f"{_until_free(hub, board) * 1000:.3f}", flush=True)
        parent.stdin.close()


def _until_free(hub: canwire.Hub, board: int) -> float:
    began = time.perf_counter()
    while True:
        try:
            hub.open_control(board, _LINE).close()
        except canwire.InUse:
            if time.perf_counter() - began > _PATIENCE_S:
                raise
        else:
            return time.perf_counter() - began


def calls(address: str) -> None:
    hub = canwire.connect(address, name="calls")
    board = hub.board(_BOARD).id
    while not _over(_CALL_EVERY_S):
        began = time.perf_counter()
        hub.line_status(board, 0)
        print(f"{(time.perf_counter() - began) * 1000:.3f}", flush=True)


def sleeps(_: str) -> None:
    began = time.perf_counter()
    while not _over(_CALL_EVERY_S):
        woke = time.perf_counter()
        print(f"{(woke - began - _CALL_EVERY_S) * 1000:.3f}", flush=True)
        began = time.perf_counter()


def _over(pause_s: float) -> bool:
    """Its input has ended; else after the pause."""
    return bool(select.select([0], [], [], pause_s)[0])


if __name__ == "__main__":
    with contextlib.suppress(canwire.HubLost):
        {"zygote": zygote, "leases": leases, "calls": calls, "sleeps": sleeps}[sys.argv[1]](sys.argv[2])
