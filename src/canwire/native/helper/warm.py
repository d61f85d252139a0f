"""Warm helpers: forks of a process with all modules loaded, for programs that request one (../core/warm.c).

The first helper starts that process. It has no data of any program, no thread and no connection, and ends after a
while without requests; the helpers that it has forked keep running.
"""

from __future__ import annotations

import gc
import importlib
import os
import select
import signal
import socket
import struct
from typing import NamedTuple

import canwire
from canwire.native.helper.serving import INTERFACES

CHANNEL = 3  # the socket of the program that a helper serves: ../core/start.c
_STANDARD_ERROR = 2
_WAITING = 64  # programs that may ask at the same time
_PATIENCE_S = 2  # for one who asks: the same as its own
_LARGEST = 1 << 18
_DESCRIPTORS = 3
_CREDENTIALS = struct.Struct("3i")


class Served(NamedTuple):
    """A program that a helper serves: its process and its name."""

    process: int
    name: str


def forked(first: Served, address: str) -> Served:
    """Returns in each helper, with the program that it serves; the program of `first` already has its channel.

    `address` is the name of an abstract socket; it ends with the seconds that the process waits for requests.
    """
    listening = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    try:
        listening.bind(f"\0{address}")
    except OSError:  # another program's helper stays already
        listening.close()
        return first
    _load()
    listening.listen(_WAITING)
    gc.freeze()
    if os.fork() == 0:
        listening.close()
        return first
    _let_go()
    return _stay(listening, float(address.rpartition("-")[2]))


def _load() -> None:
    """Load the modules of the interface that most programs use."""
    importlib.import_module(INTERFACES["vci"])
    _ = canwire.connect  # the door loads what reaches a hub


def _let_go() -> None:
    """Close the channel and standard error, so that a reader of the first program's output does not wait for them."""
    os.close(CHANNEL)
    nowhere = os.open(os.devnull, os.O_RDWR)
    os.dup2(nowhere, _STANDARD_ERROR)
    os.close(nowhere)
    os.chdir("/")
    signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody asks how helpers end


def _stay(listening: socket.socket, seconds: float) -> Served:
    while select.select([listening], [], [], seconds)[0]:
        asking, _ = listening.accept()
        with asking:
            served = _fork_for(asking, listening)
        if served is not None:
            return served
    os._exit(0)


def _fork_for(asking: socket.socket, listening: socket.socket) -> Served | None:
    """Fork a helper for the caller; in the new helper, return the program that it serves."""
    _, user, _ = _CREDENTIALS.unpack(
        asking.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, _CREDENTIALS.size)
    )
    if user != os.getuid():
        return None
    asking.settimeout(_PATIENCE_S)
    try:
        data, descriptors, flags, _ = socket.recv_fds(asking, _LARGEST, _DESCRIPTORS)
    except OSError:  # it says nothing, or has gone
        return None
    whole = len(descriptors) == _DESCRIPTORS and not flags & (socket.MSG_TRUNC | socket.MSG_CTRUNC)
    if whole and os.fork() == 0:
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        listening.close()
        if not _is_wanted(asking):
            os._exit(0)
        return _become(data, descriptors)
    for descriptor in descriptors:
        os.close(descriptor)
    return None


def _is_wanted(asking: socket.socket) -> bool:
    """Return whether the program still wants this helper; it starts another one if this one takes too long."""
    with asking:
        try:
            asking.send(b"1")
            return asking.recv(1) == b"1"
        except OSError:
            return False


def _become(data: bytes, descriptors: list[int]) -> Served:
    """Adopt the program's variables, channel, standard error and folder; return its process and its name."""
    process, name, *variables = data.rstrip(b"\0").split(b"\0")
    channel, errors, folder = descriptors
    os.fchdir(folder)
    os.dup2(errors, _STANDARD_ERROR)
    os.dup2(channel, CHANNEL)
    for descriptor in descriptors:
        if descriptor != CHANNEL:
            os.close(descriptor)
    os.environ.clear()
    for name_of, equals, value in (one.partition(b"=") for one in variables):
        if name_of and equals:
            os.environb[name_of] = value
    return Served(int(process), os.fsdecode(name))
