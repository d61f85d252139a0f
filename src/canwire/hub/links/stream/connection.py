"""One client of the server: bytes in, requests to its session, replies and notices out."""

from __future__ import annotations

import contextlib
import socket
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.errors import BadMessage, CanwireError, HubError, LimitReached
from canwire.hub.links.stream.greetings import Greetings
from canwire.hub.links.stream.outbox import Outbox
from canwire.hub.owner.entrance import open_session, rung
from canwire.hub.owner.limits import check_room, enough, no_descriptors
from canwire.hub.protocol.failure import failed, serial_in
from canwire.hub.protocol.messages import (
    LARGEST_REQUEST,
    VERSION,
    Hello,
    Inbox,
    Message,
    Welcome,
    decode_request,
    encode_reply,
)
from canwire.platform import Descriptor, EventDescriptor, close_descriptors

if TYPE_CHECKING:
    from canwire.hub.owner.engine import Engine
    from canwire.hub.owner.session import Session
    from canwire.hub.protocol.link import Answer

_RECEIVED_AT_ONCE = 1 << 16
_REQUESTS_A_TURN = 16  # so that nobody's flood of requests holds up time and other clients ...
_TURN_S = 0.002  # ... and no more of them begin after so long
_LONGEST_NAME = 64


class Connection:
    """One client. Everything here runs in the engine's thread. An error ends only this connection.

    An invalid request is answered with Failed, and then the connection is closed. Subclasses define which callers are
    accepted, and how descriptors and the doorbell are passed.
    """

    process = 0  # the process at the other end, 0 if unknown

    def __init__(
        self, engine: Engine, connection: socket.socket, closed: Callable[[Connection], object]
    ) -> None:
        self._engine = engine
        self._connection = connection
        self._when_closed = closed
        self._inbox = Inbox(LARGEST_REQUEST)
        self._requests: deque[bytes] = deque()
        self._limits = engine.world.limits
        self._outbox = Outbox(connection, self._limits.waiting_bytes)
        self._greetings: Greetings | None = None
        self._session: Session | None = None
        self._doorbell: EventDescriptor | None = None
        self._closed = False
        self._flushing = False
        self._stuck = False
        connection.setblocking(False)

    # what a kind of stream adds

    def check_caller(self) -> None:
        """Raises HubError for a caller without access to the hub."""

    def _new_doorbell(self) -> tuple[EventDescriptor, tuple[Descriptor, ...]]:
        """The client's doorbell, and the descriptors for the client; `_rung` is called when the client signals it."""
        raise NotImplementedError

    def _forget_doorbell(self, doorbell: EventDescriptor) -> None:
        """The doorbell is not used any more."""
        raise NotImplementedError

    # for the server

    def open(self, greetings: Greetings, beside: int = 0) -> None:
        """Watch the client, unless it has too many connections `beside` this one, or belongs to another user."""
        self._greetings = greetings
        greetings.wait_for(self)
        self._engine.watch(self._connection, self._readable)
        try:
            check_room(self._limits, "connections", beside, f"process {self.process}")
            self.check_caller()
        except HubError as error:
            self._refuse(0, error)

    def let_go(self, why: str) -> None:
        """Close a connection without a greeting."""
        self._refuse(0, HubError(why))

    def close(self) -> None:
        """Release all leases of this client; a second call does nothing."""
        if self._closed:
            return
        self._closed = True
        if self._greetings is not None:
            self._greetings.over(self)
        self._engine.unwatch(self._connection)
        self._connection.close()
        self._outbox.close()
        if self._doorbell is not None:
            self._forget_doorbell(self._doorbell)
        if self._session is not None:
            session = self._session
            self._engine.attempt(lambda: self._engine.world.close_session(session))
        if self._doorbell is not None:
            self._doorbell.close()
        self._when_closed(self)

    def _readable(self) -> None:
        if not self._requests:  # else what came before is still being worked on
            self._guarded(self._receive)

    def _receive(self) -> None:
        try:
            data = self._connection.recv(_RECEIVED_AT_ONCE)
        except BlockingIOError:
            return
        except OSError:
            data = b""
        if not data:
            self.close()
            return
        try:
            for payload in self._inbox.feed(data):
                self._sort(payload)
        except BadMessage as error:
            self._refuse(0, error)
        self._work()

    def _sort(self, payload: bytes) -> None:
        """Here every payload is a request."""
        self._requests.append(payload)

    def _work(self) -> None:
        """Answer some of the waiting requests; other clients have their turn in between."""
        until = time.monotonic() + _TURN_S
        for _ in range(min(len(self._requests), _REQUESTS_A_TURN)):
            if not self._closed:
                self._answer(self._requests.popleft())
            if time.monotonic() > until:
                break
        if self._requests and not self._closed:
            self._engine.post(lambda: self._guarded(self._work))

    def _answer(self, payload: bytes) -> None:
        try:
            serial, request = decode_request(payload)
        except BadMessage as error:
            self._refuse(serial_in(payload), error)
            return
        try:
            if serial < 1:
                raise BadMessage(f"a request with serial {serial}: from 1 up")
            if isinstance(request, Hello):
                self._greet(serial, request)
            else:
                self._ask(serial, request)
        except BadMessage as error:
            self._refuse(max(0, serial), error)
        except CanwireError as error:
            self._send(serial, failed(error))
        except Exception as error:
            self._engine.report(error)
            self._refuse(serial, HubError(f"the hub failed at this request: {error!r}"))

    def _greet(self, serial: int, hello: Hello) -> None:
        if self._session is not None:
            raise BadMessage("a second Hello")
        if hello.version != VERSION:
            raise BadMessage(
                f"the client speaks version {hello.version}, this hub {VERSION}; install the same canwire for both"
            )
        who = hello.name[:_LONGEST_NAME]
        name = "".join(letter if letter.isprintable() else "?" for letter in who)
        doorbell, passed = self._doorbell_for(who)
        try:
            self._session = open_session(
                self._engine.world, name, self.process or hello.pid, self._notify, doorbell
            )
        except BaseException:
            self._forget_doorbell(doorbell)
            doorbell.close()
            close_descriptors(*passed)
            raise
        self._doorbell = doorbell
        self._send(serial, Welcome(VERSION, self._engine.time), passed)

    def _doorbell_for(self, who: str) -> tuple[EventDescriptor, tuple[Descriptor, ...]]:
        """A new doorbell; silent callers are closed if it needs the last descriptors."""
        assert self._greetings is not None, "it was opened"
        self._greetings.over(self)
        with enough(f"{who} cannot connect"):
            try:
                return self._new_doorbell()
            except OSError:
                if not self._greetings.make_room():
                    raise
            return self._new_doorbell()

    def _ask(self, serial: int, request: Message) -> None:
        if self._session is None:
            raise BadMessage(f"{type(request).__name__} before Hello")
        answer = self._session.handle(request)
        if isinstance(answer, tuple):
            self._send(serial, *answer)
        else:
            answer.on_done(lambda outcome: self._answer_late(serial, outcome))

    def _answer_late(self, serial: int, outcome: Answer | CanwireError) -> None:
        if isinstance(outcome, CanwireError):
            self._send(serial, failed(outcome))
        else:
            self._send(serial, *outcome)

    def _notify(self, notice: Message) -> None:
        self._send(0, notice)

    def _rung(self) -> None:
        """The client has something to send."""
        if self._session is None or self._doorbell is None:
            return
        try:
            rung(self._engine.world, self._session, self._doorbell)
        except Exception as error:
            self._engine.report(error)
            self.close()

    def _send(self, serial: int, reply: Message, descriptors: tuple[Descriptor, ...] = ()) -> None:
        """Queue a message. It is sent after the present callback, because the world may be in an intermediate state."""
        if self._closed:
            close_descriptors(*descriptors)
            return
        try:
            message = encode_reply(serial, reply, len(descriptors))
        except BadMessage as error:  # more than fits one reply: that ends nothing but this request
            message = encode_reply(serial, failed(HubError(f"the answer is too long: {error}")))
        otherwise = b""
        if descriptors:
            otherwise = encode_reply(serial, failed(LimitReached(no_descriptors(type(reply).__name__))))
        try:
            self._put(message, descriptors, otherwise)
        except LimitReached:  # it does not read
            self._engine.post(self.close)
            return
        self._flush_soon()

    def _put(self, message: bytes, descriptors: tuple[Descriptor, ...], otherwise: bytes) -> None:
        """Here descriptors are sent with the message."""
        self._outbox.put(message, descriptors, otherwise)

    def _flush_soon(self) -> None:
        if not self._flushing:
            self._flushing = True
            self._engine.post(lambda: self._guarded(self._flush))

    def _flush(self) -> None:
        self._flushing = False
        if self._closed:
            return
        try:
            self._outbox.flush()
        except OSError:
            self.close()
            return
        if bool(self._outbox) != self._stuck:
            self._stuck = not self._stuck
            self._engine.watch(self._connection, self._readable, self._flush if self._stuck else None)

    def _refuse(self, serial: int, error: CanwireError) -> None:
        """Send the error, if the client still receives, and close the connection."""
        self._requests.clear()
        with contextlib.suppress(HubError, OSError):  # it is closed anyway
            self._outbox.put(encode_reply(serial, failed(error)))
            self._outbox.flush()
        self.close()

    def _guarded(self, work: Callable[[], object]) -> None:
        if not self._engine.attempt(work):
            self.close()
