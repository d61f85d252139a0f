"""One client of a hub: its leases, and how they end. No I/O."""

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
    """Each lease of a client has a handle, a number that no other lease has; the client signals `doorbell`.

    A session knows only its leases. `answer` answers a request, `changed` is called when a channel was opened or
    closed; both come from entrance.py. In virtual time `halts` is called at signals to the client; with `bells`, an
    engine gives the signals.
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
        """The answer to a request; raises CanwireError."""
        with enough(type(request).__name__):
            return self._answer(request, self)

    def close(self) -> None:
        """End all leases, in the order of Turn."""
        for handle in sorted(self._held, key=lambda handle: self._held[handle].turn):
            self.release(handle)

    def board_gone(self, board: int, text: str) -> None:
        """Replace the objects of all handles on this board by Gone."""
        gone = [handle for handle, held in self._held.items() if held.is_on(board)]
        for handle in gone:
            self.release(handle)
            self._held[handle] = Gone(text)
            self._counts[Gone.limit] += 1
        if gone:
            self.notify(m.Gone(tuple(gone), text))

    def sending_lines(self) -> list[CanLine]:
        """The lines on which this client has active channels that send."""
        if self._sending is None:
            found: dict[int, CanLine] = {}
            for held in self.held(HeldChannel):
                if held.active and held.channel is not None and held.channel.sends:
                    found[id(held.slot)] = held.slot.can
            self._sending = list(found.values())
        return self._sending

    @property
    def listens(self) -> bool:
        """True if the client has a queue on a line, or waits for an answer that an event of the timeline gives."""
        return self._counts[HeldQueue.limit] > 0 or self._awaited > 0

    def await_answer(self, deferred: Deferred) -> None:
        """A request of this client is answered later."""
        self._awaited += 1
        deferred.on_done(self._answered)

    def _answered(self, _: object) -> None:
        self._awaited -= 1

    def channels_changed(self) -> None:
        """A channel was activated, deactivated or closed."""
        self._sending = None
        self._changed()

    def receive_rings(self) -> list[Ring]:
        """The receive queues of this client for frames, except very small ones."""
        return [
            held.channel.receive
            for held in self.held(HeldChannel)
            if held.active and held.channel is not None and held.channel.frames
            if held.channel.receive.capacity >= _WORTH_WAITING
        ]

    def held(self, kind: type[Kind]) -> list[Kind]:
        """The leases of this client of one kind."""
        return [held for held in self._held.values() if isinstance(held, kind)]

    def check_room(self, kind: type[Held]) -> None:
        """Raises LimitReached if this client has the largest permitted number of leases of this kind."""
        check_room(self.limits, kind.limit, self._counts[kind.limit], self.name)

    def hold(self, held: Held) -> int:
        """A new handle for this lease."""
        self._counts[held.limit] += 1
        self._last_handle += 1
        self._held[self._last_handle] = held
        return self._last_handle

    def look_up(self, handle: int, kind: type[Kind]) -> Kind:
        """The object of a handle; raises Unplugged, or NoSuchBoard if it does not exist or is of another kind."""
        held = self._held.get(handle)
        if isinstance(held, Gone) and kind is not object:
            raise Unplugged(held.text)
        if held is None or not isinstance(held, kind):
            raise NoSuchBoard(f"handle {handle} is no {kind.__name__} of {self.name}")
        return held

    def release(self, handle: int) -> None:
        """End the lease of this handle."""
        held = self._held.pop(handle)
        self._counts[held.limit] -= 1
        held.let_go()
