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


@contextlib.contextmanager
def offering(arguments: argparse.Namespace, hub: str) -> Iterator[str]:
    """Run `offer` in a process; yield its first line once clients can connect. Raises HubError if it fails."""
    command = [sys.executable, "-m", "canwire", "offer", "--beside", "--hub", hub, *words_of(arguments)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline().strip()
        if not line:
            raise HubError("the hub cannot be offered to other machines; see above")
        ending = threading.Event()
        watching = threading.Thread(target=_watch, args=(process, ending), daemon=True)
        watching.start()
        try:
            yield line
        finally:
            ending.set()
            process.terminate()
            watching.join()


def _watch(process: subprocess.Popen[str], ending: threading.Event) -> None:
    """Report the end of the process if it ends by itself."""
    status = process.wait()
    if not ending.is_set():
        complain(f"this hub is not offered to other machines any more: that process ended with {status}")


def usual_hub(address: str | None) -> str:
    """Return the socket on which the hub listens: the given address, or the default one."""
    return address or canwire.default_address()
