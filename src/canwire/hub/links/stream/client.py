"""A link to a hub in another process: requests over a stream of bytes, replies and notices back."""

from __future__ import annotations

import contextlib
import itertools
import os
import socket
import sys
import threading
import traceback
import weakref
from collections import deque

from canwire.errors import BadMessage, CanwireError, HubLost, LimitReached
from canwire.hub.links.notices import Notices
from canwire.hub.protocol.failure import failed, raised
from canwire.hub.protocol.link import Answer, Listener
from canwire.hub.protocol.messages import (
    LARGEST_REPLY,
    VERSION,
    Failed,
    Hello,
    Inbox,
    Message,
    decode_reply,
    encode_request,
)
from canwire.hub.protocol.pending import Pending
from canwire.platform import Descriptor, EventDescriptor, close_descriptors, descriptor_limit

HELLO_S = 10.0  # a hub on a machine with thirty other programs took more than two


class StreamLink:
    """The Link of hub/protocol/link.py over a socket. A separate thread receives replies and notices.

    Raises HubLost if no hub listens at `address` or none answers within `hello_s`, BadMessage if it uses
    another version. A fork of this process cannot use it. Subclasses receive descriptors: they put each of them into
    `_descriptors` before the reply that counts it.
    """

    copies = False

    def __init__(self, address: str, name: str, hello_s: float = HELLO_S) -> None:
        self.address = os.path.abspath(address)
        self.time = ""
        self._pid = os.getpid()
        self._lock = threading.Lock()
        self._sending = threading.Lock()
        self._serials = itertools.count(1)
        self._calls: dict[int, Pending[Answer]] = {}
        self._notices = Notices()
        self._descriptors: deque[Descriptor] = deque()
        self._truncated = False  # some came that this process has no room for
        self._doorbell: EventDescriptor | None = None
        self._last_words = ""
        self._lost = False
        self._closed = False
        self._socket = self._dial(self.address)
        self._thread = threading.Thread(target=self._receive, name="canwire-client", daemon=True)
        self._thread.start()
        _OPEN.add(self)
        try:
            self._greet(name, hello_s)
        except BaseException:
            self.close()
            raise

    def call(self, request: Message) -> Answer:
        return self.begin(request).result()

    def begin(self, request: Message) -> Pending[Answer]:
        """`call` without waiting: the receiving thread settles the answer."""
        self._check()
        serial = next(self._serials)
        message = encode_request(serial, request)
        call: Pending[Answer] = Pending()
        with self._lock:
            if self._lost:
                raise self._why()
            self._calls[serial] = call
        try:
            with self._sending:
                self._socket.sendall(message)
        except OSError:
            self._hang_up()  # the receiving thread finds out what else the hub said, and ends this call
        return call

    def listen(self, listener: Listener) -> None:
        self._notices.listen(listener)
        if self._lost and not self._closed:
            listener(None)

    @property
    def lost(self) -> bool:
        return self._lost

    @property
    def doorbell(self) -> EventDescriptor:
        assert self._doorbell is not None, "it came with the greeting"
        return self._doorbell

    def stir(self) -> None:
        self.doorbell.signal()

    def close(self) -> None:
        """Close the connection; the hub then takes back all leases. A second call does nothing."""
        if self._pid != os.getpid():
            self.leave_to_parent()
            return
        with self._lock:
            closed, self._closed = self._closed, True
        if closed:
            return
        self._notices.close()
        _OPEN.discard(self)
        self._hang_up()
        if sys.is_finalizing():
            return  # the thread does not run any more, and the process takes its descriptors along
        self._thread.join()
        if self._doorbell is not None:
            self._doorbell.close()

    def leave_to_parent(self) -> None:
        """In a fork, close this copy of the connection, so that it ends with the process that made it."""
        self._socket.close()

    # what a kind of stream adds

    @staticmethod
    def _dial(address: str) -> socket.socket:
        """A connection to the hub there; raises HubLost."""
        raise NotImplementedError

    def _receive_some(self) -> bytes:
        """Bytes, b"" at the end; descriptors that came with them join the queue."""
        raise NotImplementedError

    def _doorbell_of(self, descriptors: tuple[Descriptor, ...]) -> EventDescriptor:
        """The doorbell, from what came with the greeting."""
        raise NotImplementedError

    # calls

    def _greet(self, name: str, hello_s: float) -> None:
        try:
            welcome, descriptors = self.begin(Hello(VERSION, self._pid, name)).result(hello_s)
        except TimeoutError:
            raise HubLost(f"{self.address}: a program listens but does not answer; is it a hub?") from None
        self.time = welcome.time
        self._doorbell = self._doorbell_of(descriptors)

    def _hang_up(self) -> None:
        """Both ways: the receiving thread sees the end, too."""
        with contextlib.suppress(OSError):  # the hub was quicker
            self._socket.shutdown(socket.SHUT_RDWR)

    def _check(self) -> None:
        if self._pid != os.getpid():
            raise CanwireError(
                "this connection belongs to the process that was forked; connect again in this one"
            )
        if sys.is_finalizing():  # nobody takes in the answer any more
            raise HubLost("the interpreter is ending: close connections before that, or by atexit")

    def _why(self) -> HubLost:
        if self._closed:
            return HubLost(f"the connection to the hub on {self.address} was closed")
        said = f": {self._last_words}" if self._last_words else ""
        return HubLost(
            f"the hub on {self.address} is gone{said}; connect again and reopen boards by hardware id"
        )

    # the receiving thread

    def _receive(self) -> None:
        inbox = Inbox(LARGEST_REPLY)
        try:
            while data := self._receive_some():
                for payload in inbox.feed(data):
                    self._take(payload)
        except OSError:
            pass  # reset: the hub is gone just as well
        except BadMessage:
            traceback.print_exc(file=sys.stderr)
        finally:
            self._lose()
            self._hang_up()
            with self._sending:
                self._socket.close()
            close_descriptors(*self._descriptors)

    def _take(self, payload: bytes) -> None:
        serial, count, reply = decode_reply(payload)
        if not 0 <= count <= len(self._descriptors):
            if not self._truncated:
                raise BadMessage(f"a reply with {count} descriptors, {len(self._descriptors)} of them came")
            self._truncated = False
            reply, count = failed(self._too_few(count)), 0
            close_descriptors(*self._descriptors)
            self._descriptors.clear()
        descriptors = tuple(self._descriptors.popleft() for _ in range(count))
        with self._lock:
            call = self._calls.pop(serial, None)
        if call is None:
            close_descriptors(*descriptors)
            if isinstance(reply, Failed):
                self._last_words = reply.text
            elif serial == 0:
                self._notices.tell(reply)
        elif isinstance(reply, Failed):
            call.fail(raised(reply))
        elif not call.settle((reply, descriptors)):
            close_descriptors(*descriptors)

    def _too_few(self, count: int) -> LimitReached:
        """The system drops descriptors that this process has no room for."""
        return LimitReached(
            f"{count} descriptors came from the hub, {len(self._descriptors)} fit: this program has used all of its "
            f"{descriptor_limit()}; close channels or FIFOs, or start it with more (ulimit -n)"
        )

    def _lose(self) -> None:
        """End the link: wake waiting threads immediately, and notify listeners unless the link was closed."""
        with self._lock:
            before, self._lost = self._lost, True
            calls, self._calls = list(self._calls.values()), {}
        for call in calls:
            call.fail(self._why())
        if not before:
            self._notices.tell(None)


_OPEN: weakref.WeakSet[StreamLink] = weakref.WeakSet()


def _after_fork() -> None:
    for link in list(_OPEN):
        link.leave_to_parent()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
