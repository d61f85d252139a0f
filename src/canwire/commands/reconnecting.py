"""`--reconnect`: a verb that only watches or forwards continues by itself once its hub is back.

Verbs that watch do so by default when the hub is gone; with `--reconnect` itself, also when a board is gone.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import closing

import canwire
from canwire import Absence, BadValue, HubError, HubLost, NoSuchBoard
from canwire.commands.console import complain


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

    def __init__(self) -> None:
        self.absence = Absence()
        self.known = False
        self.lines: dict[str, tuple[str, frozenset[str]]] = {}  # same_lines.py

    def found(self) -> None:
        """Record that the hub is connected; print how long it was not."""
        away_s = self.absence.end()
        if away_s is not None:
            complain(
                f"connected again; the {away_s:.1f} s before were missed, and what other programs sent in them"
            )
        self.known = True

    @property
    def there(self) -> bool:
        """True while the hub is connected."""
        return self.known and not self.absence.lasts

    def lost(self, error: HubError | NoSuchBoard) -> None:
        """Record that the hub is lost, or not back yet; print the reason if it differs from the previous one."""
        if self.absence.failed(error):
            complain(f"{error}; trying again")


def going_on(arguments: argparse.Namespace, work: Callable[[argparse.Namespace], int]) -> int:
    """Run `work` until it ends; run it again whenever its hub is lost, if the hub was connected before.

    With --reconnect, also after NoSuchBoard or another HubError; with --no-reconnect (False), never.
    """
    if arguments.reconnect is False:
        return work(arguments)
    watch = arguments.watch = Watch()
    with closing(canwire.Event()) as never:
        while True:
            try:
                return work(arguments)
            except (HubError, NoSuchBoard) as error:
                usual = arguments.reconnect is None and watch.there
                if not watch.known or (usual and not isinstance(error, HubLost)):
                    raise
                watch.lost(error)
            never.wait(watch.absence.pause_s)
