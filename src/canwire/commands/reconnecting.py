"""`--reconnect`: a verb that only watches or forwards continues by itself once its hub is back.

Verbs that watch do so by default when the hub is gone; with `--reconnect` itself, also when a board is gone.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from contextlib import closing

import canwire
from canwire import BadValue, HubError, HubLost, NoSuchBoard
from canwire.commands.console import complain

_FIRST_S, _LONGEST_S = 0.1, 2.0  # before it tries again


def add_reconnect_argument(parser: argparse._ActionsContainer, *, usual: bool = False) -> None:
    """Add --reconnect, for verbs whose `run` is `going_on`; with `usual` it is the default and has --no-reconnect."""
    if usual:
        parser.add_argument(
            "--reconnect",
            action=argparse.BooleanOptionalAction,
            help="when the hub is gone, wait for it and continue (the default, except for output that would start "
            "again from the beginning); --reconnect also waits for a board that is gone",
        )
    else:
        parser.add_argument(
            "--reconnect", action="store_true", help="when the hub is gone, wait for it and continue"
        )


def not_if(arguments: argparse.Namespace, starts_again: bool, what: str) -> None:
    """Turn --reconnect off if `what` would start again from the beginning; raises BadValue if it was given."""
    if starts_again and arguments.reconnect:
        raise BadValue(f"--reconnect: not together with {what}, which would start again from the beginning")
    if starts_again:
        arguments.reconnect = False


class Watch:
    """Records when the hub was connected. A verb's arguments contain it as `watch`; `connected` notifies it."""

    def __init__(self, clock_s: Callable[[], float] = time.monotonic) -> None:
        self._clock_s = clock_s
        self._lost_s: float | None = None
        self._told = ""
        self.known = False
        self.lines: dict[str, tuple[str, frozenset[str]]] = {}  # same_lines.py

    def found(self) -> None:
        """Record that the hub is connected; print how long it was not."""
        if self._lost_s is not None:
            away_s = self._clock_s() - self._lost_s
            complain(
                f"connected again; the {away_s:.1f} s before were missed, and what other programs sent in them"
            )
        self._lost_s, self._told, self.known = None, "", True

    @property
    def there(self) -> bool:
        """True while the hub is connected."""
        return self.known and self._lost_s is None

    def lost(self, error: HubError | NoSuchBoard) -> None:
        """Record that the hub is lost, or not back yet; print the reason if it differs from the previous one."""
        if self._lost_s is None:
            self._lost_s = self._clock_s()
        if str(error) != self._told:
            self._told = str(error)
            complain(f"{error}; trying again")


def going_on(arguments: argparse.Namespace, work: Callable[[argparse.Namespace], int]) -> int:
    """Run `work` until it ends; run it again whenever its hub is lost, if the hub was connected before.

    With --reconnect, also after NoSuchBoard or another HubError; with --no-reconnect (False), never.
    """
    if arguments.reconnect is False:
        return work(arguments)
    watch = arguments.watch = Watch()
    pause_s = _FIRST_S
    with closing(canwire.Event()) as never:
        while True:
            try:
                return work(arguments)
            except (HubError, NoSuchBoard) as error:
                usual = arguments.reconnect is None and watch.there
                if not watch.known or (usual and not isinstance(error, HubLost)):
                    raise
                pause_s = (
                    _FIRST_S if isinstance(error, HubLost) and watch.there else min(2 * pause_s, _LONGEST_S)
                )
                watch.lost(error)
            never.wait(pause_s)
