"""The player: the process in which runs are played, one after the other."""

from __future__ import annotations

import ctypes
import faulthandler
import os
import signal
import sys
from dataclasses import replace
from multiprocessing.connection import Connection

from canwire.campaigns.batches import Batch, Rules, loaded
from canwire.campaigns.loading import Script
from canwire.campaigns.output import Output
from canwire.campaigns.playing import play


def play_all(
    pipe: Connection,
    script: Script,
    rules: Rules,
    output: Output | None,
    inherited: tuple[Connection, ...],
) -> None:
    """Send None, then each run of the batches received over `pipe`, until the pipe is closed.

    `inherited` are the keeper's connections: while they are open here, the end of the keeper cannot be detected.
    """
    for connection in inherited:
        connection.close()
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _end_with_parent()
    if output is not None:
        output.take_over()
        faulthandler.enable()  # says in the output where a crash was
    campaign, here = loaded(script), os.getpid()
    pipe.send(None)
    while True:
        try:
            batch: Batch = pipe.recv()
        except EOFError:
            return
        for order in batch:
            run = play(campaign, order, rules.seed, limit_s=rules.limit_s)
            if os.getpid() != here:  # a run has forked, and its child returned here: it is not a player
                os._exit(0)
            pipe.send(run if output is None else replace(run, output=output.taken()))


def _end_with_parent() -> None:
    """End with the keeper if it is killed, even while a run hangs (on Linux only)."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


_PR_SET_PDEATHSIG = 1  # linux/prctl.h
