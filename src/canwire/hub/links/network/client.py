"""A link to a hub on another machine: calls as messages or queries, and copies of the hub's rings in this process."""

from __future__ import annotations

import ctypes
import itertools
import os
import secrets
import socket
import sys
import threading
import time
import traceback
from typing import TYPE_CHECKING, Any

from canwire.errors import BadMessage, CanwireError, HubLost, LimitReached
from canwire.hub.links.network import keys, wire
from canwire.hub.links.network.access import Login, usual_login
from canwire.hub.links.network.asking import Asker
from canwire.hub.links.network.calls import Asked, Call, answered_in
from canwire.hub.links.network.cuts.broken import Broken
from canwire.hub.links.network.discovery import find
from canwire.hub.links.network.held_copies import HeldCopies
from canwire.hub.links.network.lifetimes import LIVING
from canwire.hub.links.network.lockstep import ring_states
from canwire.hub.links.network.lockstep.stirs import OutgoingStirs
from canwire.hub.links.network.notes import IncomingNotes
from canwire.hub.links.network.pump import Pump
from canwire.hub.links.network.session.callback import direct
from canwire.hub.links.network.session.ending import close as close_session
from canwire.hub.links.network.session.sending import sender
from canwire.hub.links.network.session.settings import Patience, for_client, load_zenoh, open_for_client
from canwire.hub.links.notices import Notices
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.failure import raised
from canwire.hub.protocol.link import Answer, Listener
from canwire.platform import EventDescriptor, close_descriptors

if TYPE_CHECKING:
    from collections.abc import Callable


class NetworkLink:
    """The Link of hub/protocol/link.py over Zenoh. Threads of Zenoh receive, a separate thread sends.

    A call raises HubLost if nothing arrived from the hub for `patience.call_s` (in lockstep `timed_s`), but leases stay
    open: once the network is back, everything continues from the same position. The link is `lost` when the hub reports
    its end, or when the connection is broken and not restored in time. A fork of this process cannot use it.

    Raises BadValue for an invalid address, HubLost if no such hub is found, HubError if it refuses this user,
    BadMessage if it uses another version.
    """

    copies = True

    def __init__(
        self, address: str, name: str, login: Login | None = None, patience: Patience | None = None
    ) -> None:
        place = keys.parse(address)
        self.address = address
        self._patience = patience or Patience()
        login = login or usual_login()
        self._user = login.user
        self._pid = os.getpid()
        self._lock = threading.Lock()
        self._serials = itertools.count(1)
        self._calls: dict[int, Call] = {}
        self._notices = Notices()
        self._lost = self._closed = False
        self._last_words = ""
        self._timed = False
        self._host = socket.gethostname()
        self._stirs = OutgoingStirs()
        self._zenoh = load_zenoh()
        self._session = open_for_client(
            for_client(place.endpoint, login, self._patience.lease_s, self._patience.connect_s)
        )
        try:
            self._offer = find(self._session, place, address)
        except BaseException:
            close_session(self._session)
            raise
        self.time = self._offer.time
        self._doorbell = EventDescriptor(shared=True)
        own = (keys.RELAYED if place.relayed else "") + secrets.token_hex(8)
        self._keys = keys.client(self._offer.realm, self._offer.instance, self._user, own)
        self._pump = Pump(self._send, self._doorbell, relayed=place.relayed)
        self._pump.add(IncomingNotes(self._note))
        self._pump.add(self._stirs)
        self._broken = Broken(
            self._patience, lambda: self._pump.heard_ns, lambda: self._pump.silent_ns, self._lose
        )
        self._copies = HeldCopies(self._pump, self._doorbell)
        self._asker = Asker(
            self._session,
            f"{self._keys}/call",
            self._answered,
            self._send,
            self._pump,
            address,
        )
        LIVING.add(self)
        try:
            self._open(name)
        except BaseException:
            self.close()
            raise

    def call(self, request: m.Message) -> Answer:
        self._check()
        self._pump.flush()
        with self._lock:
            if self.lost:
                raise self._why()
            serial = next(self._serials)  # within the lock: no other thread's `oldest` leaves it out
            payload = m.encode_request(serial, request)[m.LENGTH.size :]
            call = self._calls[serial] = Call(request, payload)
            oldest = min(self._calls)
        rings = ring_states.left(self._pump.mirrors()) if self._timed else ()
        timed = self._timed or isinstance(request, m.JoinTime)
        silence_s = self._patience.timed_s if timed else self._patience.call_s
        asked = Asked(serial, oldest, self._host, self._pump.written(), payload, rings)
        try:
            answer, said = self._asker.insist(call, asked, silence_s)
        finally:
            with self._lock:
                self._calls.pop(serial, None)
        if timed:
            self._timed = True
        self._asker.await_arrival(said, silence_s)
        ring_states.acknowledged(said.taken, self._pump.mirror)
        return answer

    def listen(self, listener: Listener) -> None:
        self._notices.listen(listener)
        if self._lost and not self._closed:
            listener(None)

    @property
    def lost(self) -> bool:
        return self._lost or self._closed or self._pid != os.getpid()

    @property
    def doorbell(self) -> EventDescriptor:
        return self._doorbell

    def stir(self) -> None:
        self._stirs.stir()
        self._doorbell.signal()

    def close(self) -> None:
        """Release all leases; a second call does nothing."""
        if self._pid != os.getpid():
            return
        with self._lock:
            closed, self._closed = self._closed, True
        if closed:
            return
        LIVING.discard(self)
        self._notices.close()
        self._broken.close()
        self._fail_calls()
        if not self._lost:
            self._pump.flush()
            if self._timed:  # others wait for this program
                self._send(wire.farewell("it was closed"))
        self._pump.close()
        close_session(self._session)  # the token goes with it, and tells the hub
        self._copies.close()
        self._doorbell.close()

    def leave_to_parent(self) -> None:
        """In a fork: Zenoh's threads are not here, so its session must never be closed, not even at the end."""
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self._session))

    # opening

    def _open(self, name: str) -> None:
        self._session.declare_subscriber(f"{self._keys}/down", direct(self._came))
        named = keys.tokens(self._offer.realm, self._offer.name)
        self._session.liveliness().declare_subscriber(named, direct(self._hub_came_or_went))
        self._session.info.declare_transport_events_listener(direct(self._connected_or_not))
        self._here = self._session.liveliness().declare_token(f"{self._keys}/here")
        self._sender = sender(self._session, f"{self._keys}/up")
        self._pump.start()
        self.call(m.Hello(m.VERSION, self._pid, name))

    # calls

    def _send(self, payload: bytes) -> None:
        self._sender(payload)

    def _check(self) -> None:
        if self._pid != os.getpid():
            raise CanwireError(
                "this connection belongs to the process that was forked; connect again in this one"
            )
        if sys.is_finalizing():
            raise HubLost("the interpreter is ending: close connections before that, or by atexit")
        if self.lost:
            raise self._why()

    def _why(self) -> HubLost:
        if self._closed:
            return HubLost(f"the connection to {self.address} was closed")
        said = f": {self._last_words}" if self._last_words else ""
        return HubLost(f"{self.address} is gone{said}; connect again and reopen boards by hardware id")

    # what comes, in Zenoh's threads: nothing may wait here

    def _answered(self, reply: Any) -> None:
        if reply.ok is None:
            return  # timed out, or nobody there at the moment: it is asked again
        self._guarded(lambda: self._take_answer(reply.ok.payload.to_bytes()))

    def _take_answer(self, payload: bytes) -> None:
        answer = answered_in(payload)
        serial, _, reply = m.decode_reply(answer.reply)
        self._pump.heard_ns = time.monotonic_ns()
        if answer.clock_ns:
            self._pump.clock.heard(answer.clock_ns, self._pump.heard_ns)
        with self._lock:
            call = self._calls.get(serial)
        if call is None or call.answered.settled:
            return  # answered before, or given up
        if isinstance(reply, m.Failed):
            error = raised(reply)
            call.answered.fail(error)
            if isinstance(error, HubLost):
                self._lose(reply.text)
            return
        try:
            descriptors = self._copies.adopt(call.request, reply, answer.rings)
        except LimitReached as error:
            call.answered.fail(error)
            return
        if not call.answered.settle(((reply, descriptors), answer)):
            close_descriptors(*descriptors)

    def _came(self, sample: Any) -> None:
        payload = sample.payload.to_bytes()
        kind = payload[0] if payload else 0
        if kind == wire.FAREWELL:
            self._lose(wire.farewell_in(payload))
        elif kind == wire.ANSWER:
            self._guarded(lambda: self._take_answer(payload[1:]))
        else:
            self._guarded(lambda: self._pump.take(payload))

    def _note(self, payload: bytes) -> None:
        _, _, notice = m.decode_reply(payload)
        self._notices.tell(notice)

    def _hub_came_or_went(self, sample: Any) -> None:
        """Note that the hub's token came or went: the hub or its way to a router did, or another hub of its name."""
        offer = keys.offer_of(str(sample.key_expr))
        if offer is None:
            return
        own = offer.instance == self._offer.instance
        if own and sample.kind == self._zenoh.SampleKind.DELETE:
            self._broken.gone()
        elif not own and sample.kind == self._zenoh.SampleKind.PUT:
            self._broken.replaced("it was started again")

    def _connected_or_not(self, event: Any) -> None:
        """The connection to the hub or a router changed; without it, changes of tokens are not reported."""
        if event.kind == self._zenoh.SampleKind.DELETE:
            self._broken.gone()
        else:
            self._broken.back()
            self._pump.wake()

    def _guarded(self, work: Callable[[], object]) -> None:
        try:
            work()
        except BadMessage as error:
            traceback.print_exc(file=sys.stderr)
            self._lose(str(error))

    def _lose(self, why: str) -> None:
        """End the link: wake waiting threads immediately, and notify listeners unless the link was closed."""
        with self._lock:
            if self._lost or self._closed:
                return
            self._lost = True
            self._last_words = why
        self._fail_calls()
        self._notices.tell(None)

    def _fail_calls(self) -> None:
        with self._lock:
            calls = list(self._calls.values())
        for call in calls:
            call.answered.fail(self._why())
