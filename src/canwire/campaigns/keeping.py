"""The keeper: a worker's process that loads the campaign and keeps a separate process, the player, for the runs.

If a run ends the player, by a crash or because nothing else ends the run, a new player is one fork of the keeper.
"""

from __future__ import annotations

import contextlib
import gc
import multiprocessing
import signal
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from multiprocessing.connection import Connection, wait
from typing import Any

from canwire.campaigns.batches import Batch, Rules, loaded
from canwire.campaigns.loading import Script
from canwire.campaigns.output import Output
from canwire.campaigns.player import play_all
from canwire.campaigns.playing import CampaignRun, Order, crashed, late
from canwire.lab.bench import Lab
from canwire.values.frame import Frame


class _Left(Exception):
    """The campaign's process has closed its connection, or has ended."""


def keep(orders: Connection, script: Script, rules: Rules) -> None:
    """Receive batches from `orders` and send each finished run, until the other end closes `orders`."""
    signal.signal(
        signal.SIGINT, signal.SIG_IGN
    )  # Ctrl-C is the campaign's; one inside of a run is the run's own
    loaded(script)
    _warm()
    keeper = _Keeper(orders, script, rules)
    with contextlib.suppress(_Left, EOFError, OSError), contextlib.closing(keeper):
        orders.send(None)
        while True:
            keeper.play(orders.recv())


def _warm() -> None:
    """Load the modules that runs load on first use: players are forks, and share the memory of what is loaded."""
    with Lab() as lab:
        bus = lab.can_bus()
        sender, receiver = bus.node("sender"), bus.node("receiver")
        sender.send(Frame(1))
        lab.run_until_idle()
        receiver.receive()
    gc.collect()
    gc.freeze()


class _Keeper:
    """Has one player at a time. If a run ends it, the next player takes its place."""

    def __init__(self, orders: Connection, script: Script, rules: Rules) -> None:
        self._orders = orders
        self._script = script
        self._rules = rules
        self._player: _Player | None = None
        self._spare: _Player | None = None
        self._wants_spare = False

    def play(self, batch: Batch) -> None:
        """Play these runs, and send each when it is done."""
        rest: list[Order] = list(batch)
        suspect: Order | None = None
        while rest:
            for run in self._until_broken(rest):
                del rest[0]
                self._orders.send(run)
            if not rest:
                return
            output = self._end_player()
            if rest[0] == suspect:  # in a process that had played nothing else, too
                lost = crashed(loaded(self._script), rest.pop(0), self._rules.seed, output)
                self._orders.send(lost)
            else:
                suspect = rest[0]

    def _until_broken(self, rest: list[Order]) -> Iterator[CampaignRun]:
        """Yield runs until all are done or the player is lost; it was then playing the first run that is not done."""
        if self._player is None:
            self._player, self._spare = self._spare or self._made(), None
        with contextlib.suppress(EOFError, OSError):
            self._player.pipe.send(tuple(rest))
            if self._wants_spare and self._spare is None:
                self._spare = self._made()
            for order in tuple(rest):
                run = self._next(self._player)
                if run is None:
                    output = self._end_player()
                    gone = late(loaded(self._script), order, self._rules.seed, self._rules.limit_s, output)
                    yield replace(gone, output=output)
                    yield from self._until_broken(rest)
                    return
                yield run

    def _next(self, player: _Player) -> CampaignRun | None:
        """The next finished run, None if it takes too long. Raises EOFError, OSError if the player has ended."""
        player.begin()
        limit_s = self._rules.limit_s
        end = None if limit_s is None else time.monotonic() + limit_s + self._rules.grace_s
        ready = wait([player.pipe, self._orders], None if end is None else max(0.0, end - time.monotonic()))
        if player.pipe in ready:
            run: CampaignRun = player.pipe.recv()
            return run
        if ready:  # nothing is ordered while a batch is played
            raise _Left
        return None

    def _made(self) -> _Player:
        others = [player.pipe for player in (self._player, self._spare) if player is not None]
        return _Player(self._script, self._rules, (self._orders, *others))

    def _end_player(self) -> str:
        """End the player, and return what it printed since its last run."""
        player, self._player = self._player, None
        self._wants_spare = True
        return player.end() if player else ""

    def close(self) -> None:
        """End the player and the spare player."""
        self._end_player()
        if self._spare is not None:
            self._spare.end()
            self._spare = None


class _Player:
    """The process that plays. Where forking is safe it is a fork, so that the campaign is already loaded.

    It closes the connections `of_keeper`, which a fork inherits.
    """

    def __init__(self, script: Script, rules: Rules, of_keeper: tuple[Connection, ...]) -> None:
        methods = multiprocessing.get_all_start_methods()
        forked = "fork" in methods and threading.active_count() == 1
        context: Any = multiprocessing.get_context("fork" if forked else "spawn")
        self.pipe, theirs = context.Pipe()
        self._output = Output() if forked else None
        inherited = (*of_keeper, self.pipe) if forked else ()
        self._process = context.Process(
            target=play_all, args=(theirs, script, rules, self._output, inherited)
        )
        self._process.start()
        theirs.close()
        self._begun = False

    def begin(self) -> None:
        """Wait until it can play. Raises EOFError, OSError if it never will."""
        if not self._begun:
            self.pipe.recv()
            self._begun = True

    def end(self) -> str:
        self._process.kill()
        self._process.join()
        self.pipe.close()
        if self._output is None:
            return ""
        text = self._output.taken()
        self._output.close()
        return text
