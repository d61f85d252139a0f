"""`canwire offer` in a separate process, so that network clients take no time from the buses."""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
import threading
from collections.abc import Iterator

import canwire
from canwire import HubError
from canwire.commands.console import complain
from canwire.commands.network.options import words_of

WATCHING = "watching the offer"
_SIGNAL_S = 0.5  # Ctrl-C in a terminal reaches both processes: the hub's may hear of it later


@contextlib.contextmanager
def offering(arguments: argparse.Namespace, hub: str, stop: canwire.Event) -> Iterator[str]:
    """Run `offer` in a process; yield its first line once clients can connect. Raises HubError if it fails.

    It ends with the hub, which is no news once `stop`, the hub's, is set: that is set on leaving, too.
    """
    command = [sys.executable, "-m", "canwire", "offer", "--beside", "--hub", hub, *words_of(arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline().strip()
        if not line:
            raise HubError("the hub cannot be offered to other machines; see above")
        watching = threading.Thread(target=_watch, args=(process, stop), name=WATCHING, daemon=True)
        watching.start()
        try:
            yield line
        finally:
            stop.set()
            process.terminate()
            watching.join()


def _watch(process: subprocess.Popen[str], stop: canwire.Event) -> None:
    """Report the end of the process if it ends before the hub."""
    status = process.wait()
    if not stop.wait(_SIGNAL_S):
        complain(f"this hub is not offered to other machines any more: that process ended with {status}")


def usual_hub(address: str | None) -> str:
    """Return the socket on which the hub listens: the given address, or the default one."""
    return address or canwire.default_address()
