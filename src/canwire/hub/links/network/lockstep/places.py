"""The place of a remote program in the hub's time, held at the hub's end of the network.

The hub shares a page with the holder of the place, which is the guest. So data that arrive early are considered only
when the program begins to wait, and a turn is given as quickly as to a local program.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from canwire.errors import CanwireError, HubLost
from canwire.hub.links.network.calls import Asked, Positions
from canwire.hub.links.network.lockstep import ring_states
from canwire.hub.links.network.lockstep.held_place import HeldPlace
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.failure import failed
from canwire.hub.protocol.turn_wait import TurnWait

if TYPE_CHECKING:
    from canwire.hub.protocol.link import Answer, Link


_LOST = failed(HubLost("the hub is gone, or this thread waits for another turn already"))


class Places:
    """The places of one connection; `mirror` returns a ring by its number. Any thread may call."""

    def __init__(self, link: Link, mirror: Callable[[int], object]) -> None:
        self.timed = False  # once it has asked to take part
        self._link = link
        self._mirror = mirror
        self._lock = threading.Lock()  # over looking at rings as they were left
        self._signalled = False  # somebody at the other end of a FIFO waits for what the program did there
        self._pages: dict[int, HeldPlace] = {}  # by thread: there is one at most

    def call(self, asked: Asked, request: m.Message) -> Answer:
        """Link.call, after the records that the program has left in its rings."""
        self._find(asked)
        self._tell_others()
        if isinstance(request, m.JoinTime):
            return self._join(request, asked.host)
        return self._link.call(request)

    def begins(
        self, asked: Asked, request: m.Message, answer: Callable[[m.Message], object], *, may_wait: bool
    ) -> bool:
        """Begin a wait for a turn by the hub's page; `answer` is called when it is over.

        False for any other request, and if the hub has to be called before and the caller may not wait (`may_wait`).
        """
        page = self._pages.get(request.thread) if isinstance(request, m.AwaitTurn) else None
        if page is None or not isinstance(request, m.AwaitTurn):
            return False
        self._find(asked)
        if self._signalled and not may_wait:
            return False
        self._tell_others()
        page.begin(request.until_ns, lambda now_ns: answer(_LOST if now_ns is None else m.Number(now_ns)))
        return True

    def _find(self, asked: Asked) -> None:
        if asked.rings:
            with self._lock:
                if ring_states.found(asked.rings, self._mirror):
                    self.stir()

    def signalled(self) -> None:
        """The program has used a FIFO whose other end may wait for that."""
        self._signalled = True

    def _tell_others(self) -> None:
        """Their turns come when this program's is over."""
        if self._signalled:
            self._signalled = False
            self._link.call(m.Stir())

    def taken(self, mirrors: Iterable[object]) -> Positions:
        """The hub's positions in the rings, for an answer."""
        return ring_states.taken(mirrors) if self.timed else ()

    def stir(self) -> None:
        """Make the program's threads check again."""
        for page in list(self._pages.values()):
            page.stir()
        self._link.doorbell.signal()

    def lost(self) -> None:
        """The link has ended: end all waits."""
        for page in list(self._pages.values()):
            page.end()

    def _join(self, request: m.JoinTime, host: str) -> Answer:
        before, self.timed = self.timed, True
        number = request.program.partition("-")[0]
        named = m.JoinTime(request.program, request.thread, request.name, f"{number} on {host}")
        try:
            joined, descriptors = self._link.call(named)
        except CanwireError:
            self.timed = before
            raise
        if descriptors:
            page = TurnWait(self._link.doorbell.signal, *descriptors)
            self._pages[request.thread] = HeldPlace(page)
        return joined, ()
