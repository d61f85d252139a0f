"""One client of a hub: what it holds, and how all of it is given back. No I/O."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from canwire.boards.can.connector import CanLine
from canwire.errors import NoSuchBoard, Unplugged
from canwire.hub.owner import board_requests, lin_requests  # noqa: F401  they add their answers
from canwire.hub.owner.deferred import Deferred
from canwire.hub.owner.held import HeldControl, HeldLayer, HeldPipe, HeldScheduler, HeldShare
from canwire.hub.owner.held_channel import HeldChannel
from canwire.hub.owner.held_lin import HeldMonitor
from canwire.hub.owner.requests import answer
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.link import Answer
from canwire.platform import EventDescriptor
from canwire.ring import Ring

if TYPE_CHECKING:
    from canwire.hub.owner.world import World

Kind = TypeVar("Kind")
_WORTH_WAITING = 16  # a receive queue for less than that overflows however patient the bus is


class Gone:
    """What a handle stands for whose board was pulled out."""

    def __init__(self, text: str) -> None:
        self.text = text


class Session:
    """Everything a client holds has a handle, a number that is only its own; `doorbell` is how it calls the hub."""

    def __init__(
        self,
        world: World,
        name: str,
        notify: Callable[[m.Message], None],
        doorbell: EventDescriptor | None,
    ) -> None:
        self.world = world
        self.name = name
        self.notify = notify
        self.doorbell = doorbell
        self.watching = False
        self._held: dict[int, object] = {}
        self._last_handle = 0
        self._sending: list[CanLine] | None = None  # looked up at every ring of the doorbell

    @property
    def virtual(self) -> bool:
        return self.world.virtual

    def handle(self, request: m.Message) -> Answer | Deferred:
        """What the request is answered with; raises CanwireError."""
        return answer(request, self)

    def close(self) -> None:
        """Give everything back: cyclic lists first, so that nothing new is sent."""
        for kind in (HeldScheduler, HeldChannel, HeldMonitor, HeldControl, HeldShare, HeldPipe, HeldLayer):
            for handle in [handle for handle, held in self._held.items() if isinstance(held, kind)]:
                self.release(handle)

    def board_gone(self, board: int, text: str) -> None:
        """Handles on this board are dead from now on."""
        gone = [handle for handle, held in self._held.items() if getattr(held, "board", None) == board]
        for handle in gone:
            self.release(handle)
            self._held[handle] = Gone(text)
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

    def channels_changed(self) -> None:
        """One was activated, deactivated or given back."""
        self._sending = None
        self.world.clear_until_ns = 0

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

    def hold(self, held: object) -> int:
        """A new handle for it."""
        self._last_handle += 1
        self._held[self._last_handle] = held
        return self._last_handle

    def look_up(self, handle: int, kind: type[Kind]) -> Kind:
        """What a handle stands for; raises Unplugged, or NoSuchBoard for none or one of another kind."""
        held = self._held.get(handle)
        if isinstance(held, Gone) and kind is not object:
            raise Unplugged(held.text)
        if held is None or not isinstance(held, kind):
            raise NoSuchBoard(f"handle {handle} is no {kind.__name__} of {self.name}")
        return held

    def release(self, handle: int) -> None:
        """Give it back."""
        held = self._held.pop(handle)
        if isinstance(held, HeldPipe):
            self.world.pipes.close(held.pipe, held.role)
        elif isinstance(held, (HeldScheduler, HeldChannel, HeldMonitor, HeldControl, HeldShare)):
            held.let_go()
            held.slot.settle()
