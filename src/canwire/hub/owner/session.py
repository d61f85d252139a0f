"""One client of a hub: what it holds, and how all of it is given back. No I/O."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import TypeVar

from canwire.boards.can.connector import CanLine
from canwire.boards.config.limits import LimitsConfig
from canwire.errors import NoSuchBoard, Unplugged
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.held.bells import Bells
from canwire.hub.owner.held.channel import HeldChannel
from canwire.hub.owner.held.held import Gone, Halts, Held
from canwire.hub.owner.held.line import HeldQueue
from canwire.hub.owner.limits import check_room, enough
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.platform import EventDescriptor
from canwire.ring import Ring

Kind = TypeVar("Kind")
_WORTH_WAITING = 16  # a receive queue for less than that overflows however patient the bus is


class Session:
    """Everything a client holds has a handle, a number that is only its own; `doorbell` is how it calls the hub.

    It knows only what it holds. `answer` finds out what a request is answered with, `changed` is called when a channel
    came or went; both come from entrance.py. `halts` is called at its signals where time is virtual,
    `bells` give them where an engine rings those.
    """

    def __init__(
        self,
        name: str,
        notify: Callable[[m.Message], None],
        doorbell: EventDescriptor | None,
        *,
        halts: Halts | None,
        limits: LimitsConfig,
        answer: Callable[[m.Message, Session], Answer | Deferred],
        changed: Callable[[], object],
        bells: Bells | None = None,
    ) -> None:
        self.name = name
        self.notify = notify
        self.doorbell = doorbell
        self.halts = halts
        self.bells = bells
        self.shares_memory = True  # a link that carries no descriptors says no
        self.watching = False
        self.limits = limits
        self.plugged: dict[
            str, bool
        ] = {}  # hardware ids of boards this client plugged in; True: they go with it
        self._counts: Counter[str] = Counter()
        self._answer = answer
        self._changed = changed
        self._held: dict[int, Held] = {}
        self._last_handle = 0
        self._awaited = 0
        self._sending: list[CanLine] | None = None  # looked up at every ring of the doorbell

    def handle(self, request: m.Message) -> Answer | Deferred:
        """What the request is answered with; raises CanwireError."""
        with enough(type(request).__name__):
            return self._answer(request, self)

    def close(self) -> None:
        """Give everything back, each kind in its turn."""
        for handle in sorted(self._held, key=lambda handle: self._held[handle].turn):
            self.release(handle)

    def board_gone(self, board: int, text: str) -> None:
        """Handles on this board are dead from now on."""
        gone = [handle for handle, held in self._held.items() if held.is_on(board)]
        for handle in gone:
            self.release(handle)
            self._held[handle] = Gone(text)
            self._counts[Gone.limit] += 1
        if gone:
            self.notify(m.Gone(tuple(gone), text))

    def sending_lines(self) -> list[CanLine]:
        """Lines on which this client has active channels that send."""
        if self._sending is None:
            found: dict[int, CanLine] = {}
            for held in self.held(HeldChannel):
                if held.active and held.channel is not None and held.channel.sends:
                    found[id(held.slot)] = held.slot.can
            self._sending = list(found.values())
        return self._sending

    @property
    def listens(self) -> bool:
        """It has a queue on a line, or waits for an answer that comes with a happening."""
        return self._counts[HeldQueue.limit] > 0 or self._awaited > 0

    def await_answer(self, deferred: Deferred) -> None:
        """One of its requests is answered later."""
        self._awaited += 1
        deferred.on_done(self._answered)

    def _answered(self, _: object) -> None:
        self._awaited -= 1

    def channels_changed(self) -> None:
        """One was activated, deactivated or given back."""
        self._sending = None
        self._changed()

    def receive_rings(self) -> list[Ring]:
        """Receive queues of this client that frames go into, and that could take a few."""
        return [
            held.channel.receive
            for held in self.held(HeldChannel)
            if held.active and held.channel is not None and held.channel.frames
            if held.channel.receive.capacity >= _WORTH_WAITING
        ]

    def held(self, kind: type[Kind]) -> list[Kind]:
        """What this client holds of a kind."""
        return [held for held in self._held.values() if isinstance(held, kind)]

    def check_room(self, kind: type[Held]) -> None:
        """Raises LimitReached where this client has as many of a kind as one may have."""
        check_room(self.limits, kind.limit, self._counts[kind.limit], self.name)

    def hold(self, held: Held) -> int:
        """A new handle for it."""
        self._counts[held.limit] += 1
        self._last_handle += 1
        self._held[self._last_handle] = held
        return self._last_handle

    def look_up(self, handle: int, kind: type[Kind]) -> Kind:
        """The object of a handle; raises Unplugged, or NoSuchBoard for none or one of another kind."""
        held = self._held.get(handle)
        if isinstance(held, Gone) and kind is not object:
            raise Unplugged(held.text)
        if held is None or not isinstance(held, kind):
            raise NoSuchBoard(f"handle {handle} is no {kind.__name__} of {self.name}")
        return held

    def release(self, handle: int) -> None:
        """Give it back."""
        held = self._held.pop(handle)
        self._counts[held.limit] -= 1
        held.let_go()
