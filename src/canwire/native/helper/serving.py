"""Answers calls by the interface that begins a method's name (\"vci.open_socket\")."""

from __future__ import annotations

import importlib
import sys
import threading
from contextlib import nullcontext
from typing import TYPE_CHECKING

from canwire import BadMessage
from canwire.native.helper.answers import Reply

if TYPE_CHECKING:
    from collections.abc import Callable
    from contextlib import AbstractContextManager

    from canwire.native.helper.answers import Answers, Passing
    from canwire.native.helper.turns import Turns

INTERFACES = {
    "acan": "canwire.native.acan",
    "candrv": "canwire.native.candrv",
    "vci": "canwire.native.vci",
}
"""The module with `interface(states)`, by the part of a method's name before the dot."""

_UNEXPECTED = -1  # where not even the interface could be found


class Helper:
    """Answers all calls of one program."""

    def __init__(
        self, states: Passing, hello: Callable[[], Reply] = Reply, turns: Turns | None = None
    ) -> None:
        """`hello` answers the first call, with what the program needs first.

        `turns`: the program follows its hub's time, and each thread is answered at its turn.
        """
        self._states = states
        self._hello = hello
        self._turns = turns
        self._interfaces: dict[str, Answers] = {} if turns is None else {"time": turns}
        self._loading = threading.Lock()

    def thread(self) -> AbstractContextManager[None]:
        """A context in which the calling thread answers one thread of the program."""
        return nullcontext() if self._turns is None else self._turns.thread()

    def answer(self, method: str, number: int, data: bytes) -> Reply:
        """Answer a call; raises nothing. An unexpected exception is printed, for the user to report."""
        try:
            if method == "helper.hello":
                return self._hello()
            interface, _, name = method.partition(".")
            if self._turns is not None and interface != "time":
                self._turns.take_part()
            return self._interface(interface).answer(name, number, data)
        except Exception:
            print(f"canwire: the call {method} failed in an unexpected way:", file=sys.stderr)
            sys.excepthook(*sys.exc_info())
            return Reply(_UNEXPECTED)

    def _interface(self, name: str) -> Answers:
        with self._loading:
            found = self._interfaces.get(name)
            if found is None:
                if name not in INTERFACES:
                    raise BadMessage(f"there is no interface {name!r}")
                found = self._interfaces[name] = importlib.import_module(INTERFACES[name]).interface(
                    self._states
                )
            return found
