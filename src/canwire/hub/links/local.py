"""A link to a hub in the same process: the same calls, without a socket."""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.errors import CanwireError, HubError, HubLost
from canwire.hub.links.notices import Notices
from canwire.hub.owner.engine import VIRTUAL
from canwire.hub.owner.entrance import open_session, rung
from canwire.hub.protocol.link import Answer, Listener
from canwire.hub.protocol.messages import encode_request
from canwire.hub.protocol.pending import Pending
from canwire.platform import EventDescriptor, close_descriptors
from canwire.timeline import NEVER

if TYPE_CHECKING:
    from canwire.hub.owner.engine import Engine
    from canwire.hub.owner.session import Session
    from canwire.hub.protocol.messages import Message

_SILENCE_NS = 3_600_000_000_000  # no request takes so long: boards' clocks tick without end


class LocalLink:
    """The Link of hub/protocol/link.py to an engine of this process, which outlives the link.

    `released` is called when the link is closed. In virtual time, a call that takes time advances the time in the
    calling thread.
    """

    address = ""

    copies = False

    def __init__(self, engine: Engine, name: str, released: Callable[[], object] | None = None) -> None:
        self.time = engine.time
        self._engine = engine
        self._released = released
        self._lock = threading.Lock()
        self._notices = Notices()
        self._calls: set[Pending[Answer]] = set()
        self._closed = False
        self._expelled = False
        self._doorbell = EventDescriptor()
        self._session = engine.call(lambda: self._open(name))

    def call(self, request: Message) -> Answer:
        if self._closed or self._expelled:
            raise self._why()
        encode_request(1, request)  # what no hub in another process would take, this one refuses alike
        call: Pending[Answer] = Pending()
        self._engine.call(lambda: self._ask(request, call))
        if self.time == VIRTUAL:
            last_ns = self._engine.world.timeline.now_ns + _SILENCE_NS
            while self._engine.call(lambda: self._let_time_pass(request, call, last_ns)):
                self._engine.world.held.rest()
            self._engine.world.held.rest()
        return call.result()

    def listen(self, listener: Listener) -> None:
        self._notices.listen(listener)
        if self.lost and not self._closed:
            listener(None)

    @property
    def lost(self) -> bool:
        return self._closed or self._expelled or self._engine.closed

    @property
    def doorbell(self) -> EventDescriptor:
        return self._doorbell

    def stir(self) -> None:
        self.doorbell.signal()

    def close(self) -> None:
        """Release all leases; a second call does nothing."""
        with self._lock:
            closed, self._closed = self._closed, True
        if closed:
            return
        self._notices.close()
        if not self._engine.closed:
            with contextlib.suppress(HubLost):  # closed this very moment: then it is given back already
                self._engine.call(self._leave)
        self._doorbell.close()
        if self._released is not None:
            self._released()

    # in the engine's thread

    def _open(self, name: str) -> Session:
        session = open_session(self._engine.world, name, os.getpid(), self._notify, self._doorbell)
        self._engine.watch(self._doorbell, self._rung)
        self._engine.when_closed(self._lose)
        return session

    def _ask(self, request: Message, call: Pending[Answer]) -> None:
        answer = self._session.handle(request)
        if isinstance(answer, tuple):
            self._settle(call, answer)
        else:
            self._calls.add(call)
            answer.on_done(lambda outcome: self._settle(call, outcome))

    def _settle(self, call: Pending[Answer], outcome: Answer | CanwireError) -> None:
        self._calls.discard(call)
        if isinstance(outcome, CanwireError):
            call.fail(outcome)
        else:
            if not call.settle(outcome):
                close_descriptors(*outcome[1])
        self._engine.world.timeline.halt()  # in virtual time no more of it passes than the answer took

    def _let_time_pass(self, request: Message, call: Pending[Answer], last_ns: int) -> bool:
        """Let time pass until the call is answered. True: time may not pass any further at this moment."""
        world = self._engine.world
        world.kick_all()
        while not call.settled:
            due_ns = world.timeline.next_ns()
            if due_ns >= NEVER or due_ns > last_ns:
                raise HubError(
                    f"{type(request).__name__} would never end: no further event on the buses of this hub can end it"
                )
            if not world.held.run(world.timeline, due_ns) and world.held.resting:
                return True
        return False

    def _rung(self) -> None:
        if not self._engine.attempt(lambda: rung(self._engine.world, self._session, self._doorbell)):
            self._expelled = True
            self._leave()
            self._notices.tell(None)

    def _notify(self, notice: Message) -> None:
        if self.time == VIRTUAL:  # after what is being done now, and not at some time in another thread
            self._engine.post(lambda: self._notices.tell_here(notice))
        else:
            self._notices.tell(notice)

    def _leave(self) -> None:
        self._engine.unwatch(self._doorbell)
        self._engine.forget(self._lose)
        self._fail_calls()
        self._engine.attempt(lambda: self._engine.world.close_session(self._session))

    def _lose(self) -> None:
        """The engine ends: wake waiting threads and notify listeners."""
        self._fail_calls()
        self._notices.tell(None)

    def _fail_calls(self) -> None:
        while self._calls:
            self._calls.pop().fail(self._why())

    def _why(self) -> HubLost:
        what = "the connection to the hub" if self._closed else "the hub"
        return HubLost(f"{what} in this process was closed")
