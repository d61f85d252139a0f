"""Senders that wait until a line's transmit queue has room."""

from __future__ import annotations

from collections import deque
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import CanwireError
from canwire.socketcan.loop import READABLE
from canwire.socketcan.table import STUCK

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import RingEnd
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.loop import Timer
    from canwire.socketcan.setting import Setting

_ROOM = 256  # frames for which a sender that waits is woken
_STUCK_S = 0.25


class LineRoom:
    """`writing` is the queue's end, which all senders share; `ask` returns once the hub has answered something."""

    def __init__(
        self, setting: Setting, interface: Interface, writing: RingEnd, ask: Callable[[], object]
    ) -> None:
        self._setting = setting
        self._interface = interface
        self._writing = writing
        self._ask = ask
        self._waiting: deque[Callable[[], object]] = deque()
        self._stuck: Timer | None = None
        writing.threshold = _ROOM
        setting.loop.watch(writing.descriptor.fileno(), READABLE, self._has_room)

    def wait(self, call: Callable[[], object]) -> None:
        """Call this once there is room for more."""
        self._waiting.append(call)
        self._writing.ring.free()
        self._writing.ring.arm_free()
        if self._stuck is None:
            self._look_again()

    def end(self) -> list[Callable[[], object]]:
        """Before the channel is closed: who waits."""
        waiting, self._waiting = self._waiting, deque()
        self._setting.loop.forget(self._writing.descriptor.fileno())
        return list(waiting)

    def _has_room(self, _: int) -> None:
        self._writing.descriptor.clear()
        if self._interface.flags & STUCK:
            self._setting.interfaces.show(self._interface, self._interface.flags & ~STUCK)
        waiting, self._waiting = self._waiting, deque()
        for call in waiting:
            call()

    def _look_again(self, *, answered: bool = False) -> None:
        taken = self._writing.ring.taken
        self._stuck = self._setting.loop.call_in(_STUCK_S, lambda: self._look_for_progress(taken, answered))

    def _look_for_progress(self, taken: int, answered: bool) -> None:
        """A program that waits for room learns that there is none: ENOBUFS.

        A hub whose process gets no time takes nothing either, and would then be taken for a line that cannot send. So
        nothing may have been taken between two answers of the hub; `answered`: there was the first one.
        """
        self._stuck = None
        if not self._waiting:
            return
        nothing = self._takes_nothing(taken)
        stuck = STUCK if nothing and answered else 0
        self._setting.interfaces.show(self._interface, self._interface.flags & ~STUCK | stuck)
        self._look_again(answered=nothing)

    def _takes_nothing(self, taken: int) -> bool:
        """Whether that is so once the hub has answered. The port reports a hub that is gone."""
        if self._writing.ring.taken != taken:
            return False
        with suppress(CanwireError):
            self._ask()
        return self._writing.ring.taken == taken
