"""One program of any interface, as the matrix plays it: a few verbs, answered in the interface's own words."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from types import ModuleType
from typing import Any, ClassVar

import canwire

DONE = "done"
NO_CALL = "no such call"  # the interface has nothing of that kind
RATE, OTHER_RATE = 250_000, 500_000  # bit/s; the first is what all lines of the matrix run at


class Player:
    """Each verb returns DONE, NO_CALL or the error in the interface's own terms; anything else is a fault.

    `hub` is this program's own connection. `join` opens the line as a program does that wants to take part, without
    asking for anything; `set_up` has it running at RATE as whoever comes first.
    """

    kind: ClassVar[str]
    shows: ClassVar[type[Exception]] = canwire.CanwireError  # what the interface raises

    def __init__(self, hub: canwire.Hub, board: canwire.BoardInfo) -> None:
        self.hub = hub
        self.board = board

    def tell(self, call: Callable[[], object]) -> str:
        """What came of it."""
        try:
            found = call()
        except self.shows as error:
            return self.name_of(error)
        return found if isinstance(found, str) else DONE

    def name_of(self, error: Any) -> str:
        """The error as programs of this kind know it."""
        return type(error).__name__

    def join(self) -> str:
        raise NotImplementedError

    def set_up(self) -> str:
        raise NotImplementedError

    def set_rate(self, rate: int) -> str:
        raise NotImplementedError

    def take_control(self) -> str:
        return NO_CALL

    def stop(self) -> str:
        return NO_CALL

    def reset(self) -> str:
        return NO_CALL

    def recover(self) -> str:
        raise NotImplementedError

    def send(self, identifier: int) -> str:
        """A frame of eleven bits without data."""
        raise NotImplementedError

    def received(self) -> list[int]:
        """Identifiers of the frames that have come since, its own among them perhaps."""
        raise NotImplementedError

    def told(self) -> set[str]:
        """What has come since that is no frame, in the interface's own words."""
        raise NotImplementedError

    def narrow(self) -> str:
        """It set the line up: from now on it wants identifiers from 0x200 to 0x2FF alone, by its interface's filter."""
        return NO_CALL

    def state(self) -> str:
        """The line as this program sees it."""
        raise NotImplementedError

    def end(self) -> None:
        """The program ends as it should; a second time does nothing."""
        raise NotImplementedError


def fresh(name: str) -> ModuleType:
    """A module of its own: a library that keeps what its process has open, in a process that plays several."""
    found = importlib.util.find_spec(name)
    assert found is not None
    assert found.loader is not None
    made = importlib.util.module_from_spec(found)
    found.loader.exec_module(made)
    return made
