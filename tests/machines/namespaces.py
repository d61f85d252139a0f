"""Machines for tests, in network namespaces of this one, joined by a spoiler. Needs user namespaces, `ip` and TUN."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from tests.machines.spoiler import Spoiler

_TOOLS = ("unshare", "nsenter", "ip")
_HOLDER = Path(__file__).with_name("holder.py")


class Machine(NamedTuple):
    """One of them, by the process that keeps its network."""

    address: str
    pid: int

    def words(self, words: Sequence[str]) -> list[str]:
        """The same command, on this machine."""
        return ["nsenter", "-t", str(self.pid), "-U", "--preserve-credentials", "-n", "--", *words]


class Machines(NamedTuple):
    """All of them; they are numbered from 0, as `spoiler.ways` numbers them."""

    all: tuple[Machine, ...]
    spoiler: Spoiler


def why_not() -> str:
    """Why there can be no machines here; "" where there can."""
    missing = [tool for tool in _TOOLS if shutil.which(tool) is None]
    if missing or sys.platform != "linux":
        return f"{', '.join(missing)} not installed" if missing else "not Linux"
    if not os.access("/dev/net/tun", os.R_OK | os.W_OK):
        return "no /dev/net/tun"
    tried = subprocess.run(["unshare", "-Urn", "true"], capture_output=True, text=True)
    return tried.stderr.strip() if tried.returncode else ""


@contextlib.contextmanager
def machines(count: int, seed: int = 0) -> Iterator[Machines]:
    """So many, with the addresses 10.77.0.1, .2 ... They end with the block, and all programs on them should before."""
    addresses = [f"10.77.0.{number + 1}" for number in range(count)]
    with contextlib.ExitStack() as stack:
        found = [_held(address, stack) for address in addresses]
        spoiler = stack.enter_context(contextlib.closing(Spoiler([end for _, end in found], addresses, seed)))
        yield Machines(tuple(machine for machine, _ in found), spoiler)


def _held(address: str, stack: contextlib.ExitStack) -> tuple[Machine, int]:
    """A machine, and the other end of its interface."""
    here, there = socket.socketpair()
    with there:
        words = ["unshare", "-Urn", sys.executable, "-S", str(_HOLDER), str(there.fileno()), address]
        process = stack.enter_context(subprocess.Popen(words, pass_fds=[there.fileno()]))
    stack.enter_context(here)
    _, ends, _, _ = socket.recv_fds(here, 16, 1)
    if not ends:
        raise OSError(f"{address}: no namespace for it, see above")
    stack.callback(os.close, ends[0])
    return Machine(address, process.pid), ends[0]
