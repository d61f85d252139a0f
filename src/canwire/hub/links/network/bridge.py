"""The hub's end of the network: it offers the hub, and admits clients, each with a separate link to the hub."""

from __future__ import annotations

import contextlib
import socket
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from canwire.errors import BadMessage, CanwireError, HubError, HubLost
from canwire.hub.links.network import keys, wire
from canwire.hub.links.network.access import right_of
from canwire.hub.links.network.calls import Answered, asked_in, encode, refused
from canwire.hub.links.network.cuts.absent import Absent
from canwire.hub.links.network.discovery import offers_in
from canwire.hub.links.network.guest import Guest
from canwire.hub.links.network.offered import Offered
from canwire.hub.links.network.relay.at_hub import RelaysAtHub
from canwire.hub.links.network.session.callback import direct
from canwire.hub.links.network.session.ending import close as close_session
from canwire.hub.links.network.session.sending import sender
from canwire.hub.links.network.session.settings import (
    check_reach,
    for_hub,
    load_zenoh,
    open_for_hub,
    target_of,
)
from canwire.hub.protocol import messages as m
from canwire.platform import EventDescriptor

if TYPE_CHECKING:
    from canwire.hub.protocol.link import Link

HEALTHY_S = 0.3  # between two looks whether the hub answers ...
_UNHEALTHY_S = 0.8  # ... and the silence after which no sign of life is given for it


class Bridge:
    """Offers the hub that `dial` makes links to, until `close`. If that hub ends, `lost` is called.

    `warn` is called with a line about each client whose commands arrived too late.

    Raises BadValue, HubError if it cannot listen there or another hub has this name, HubLost if no hub runs.
    """

    def __init__(
        self,
        dial: Callable[[str], Link],
        offered: Offered,
        lost: Callable[[], object],
        warn: Callable[[str], object] = lambda text: None,
    ) -> None:
        self._warn = warn
        check_reach(
            offered.listen, offered.access, via=offered.via, insecure=offered.insecure, relay=offered.relay
        )
        zenoh = load_zenoh()
        self._dial = dial
        self._offered = offered
        self._lost = lost
        self._lock = threading.Lock()  # held for moments only
        self._greeting = threading.Lock()
        self._guests: dict[str, Guest] = {}
        self._heard: dict[str, Any] = {}  # subscribers
        self._absent = Absent(offered.lease_s, offered.grace_s, offered.cut_s)
        self._closed = False
        self._relays: RelaysAtHub | None = None
        self._stopping = EventDescriptor()
        self._healthy_s = time.monotonic()
        realm = keys.word("realm", offered.realm)
        name = keys.word("name", offered.name or socket.gethostname())
        self._own = dial("network")
        self._zenoh = zenoh
        try:
            self._session = open_for_hub(
                for_hub(offered.listen, offered.via, offered.access, offered.lease_s), offered.access
            )
        except BaseException:
            self._own.close()
            raise
        instance = str(self._session.zid())
        self.offer = keys.Offer(realm, name, instance, m.VERSION, self._own.time)
        try:
            self._open()
        except BaseException:
            self.close()
            raise

    def _open(self) -> None:
        self._refuse_second()
        realm, _, instance, *_ = self.offer
        session = self._session
        session.declare_queryable(keys.clients(realm, instance, "call"), direct(self._asked), complete=True)
        session.liveliness().declare_subscriber(
            keys.clients(realm, instance, "here"), direct(self._came_or_went)
        )
        self._token = session.liveliness().declare_token(keys.token(self.offer))
        self._own.listen(self._notice)
        self._thread = threading.Thread(target=self._watch, name="canwire-bridge", daemon=True)
        self._thread.start()
        if self._offered.relay:
            hub = f"{realm}/{self.offer.name}"
            self._relays = RelaysAtHub(self._offered.relay, target_of(self._offered.listen), hub)

    @property
    def address(self) -> str:
        """The address for programs to connect to."""
        return keys.address_of(self.offer, self._offered.listen, self._offered.via, socket.gethostname())

    def close(self) -> None:
        """Send a farewell and close all connections; a second call does nothing."""
        if self._closed:
            return
        self._closed = True
        self._stopping.signal()
        for client in list(self._guests):
            self._say_farewell(client, "it was ended")
        if hasattr(self, "_token"):
            self._token.undeclare()
            self._thread.join()
        for client in list(self._guests):
            self._leave(client)
        if self._relays is not None:
            self._relays.close()
        close_session(self._session)
        self._own.close()
        self._stopping.close()

    def _refuse_second(self) -> None:
        """Refuse a second hub of the same name: a program could not choose between them."""
        for other in offers_in(self._session, self.offer.realm, self.offer.name):
            raise HubError(
                f"another hub is offered as {keys.SCHEME}{other.realm}/{other.name} already ({other.instance}); "
                "give --name another one"
            )

    def _notice(self, notice: m.Message | None) -> None:
        if notice is None:
            self._lost()

    # what comes, in Zenoh's threads: nothing may wait here

    def _asked(self, query: Any) -> None:
        user, client = keys.client_of(str(query.key_expr))
        payload = b"" if query.payload is None else query.payload.to_bytes()

        def reply(answer: bytes) -> None:
            with contextlib.suppress(self._zenoh.ZError):  # the session is closed, or the asker is gone
                query.reply(query.key_expr, answer)  # as the query is: dropped rather than waited for
            query.drop()

        try:
            guest = self._guests.get(client)
            if guest is not None and guest.user == user:
                guest.ask(payload, reply)
            else:
                threading.Thread(target=self._greet, args=(user, client, payload, reply), daemon=True).start()
        except BadMessage as error:
            reply(refused(payload, error))

    def _came(self, sample: Any) -> None:
        user, client = keys.client_of(str(sample.key_expr))
        guest = self._guests.get(client)
        if guest is None or guest.user != user:
            return
        payload = sample.payload.to_bytes()
        if payload[:1] == bytes((wire.FAREWELL,)):
            threading.Thread(target=self._leave, args=(client,), daemon=True).start()
        else:
            self._guarded(client, lambda: guest.take(payload))

    def _came_or_went(self, sample: Any) -> None:
        _, client = keys.client_of(str(sample.key_expr))
        with self._lock:
            if sample.kind == self._zenoh.SampleKind.PUT:
                self._absent.came(client)
            elif client in self._guests:
                self._absent.went(client, time.monotonic(), self._guests[client].pump.silent_ns)
                self._stopping.signal()  # the thread looks when

    def _guarded(self, client: str, work: Callable[[], object]) -> None:
        """Drop a client that sends invalid data."""
        try:
            work()
        except BadMessage as error:
            self._say_farewell(client, str(error))
            threading.Thread(target=self._leave, args=(client,), daemon=True).start()

    # who comes

    def _greet(self, user: str, client: str, payload: bytes, reply: Callable[[bytes], object]) -> None:
        """Answer the first call of a client, which must be Hello."""
        try:
            reply(self._let_in(user, client, payload))
        except CanwireError as error:
            reply(refused(payload, error))

    def _let_in(self, user: str, client: str, payload: bytes) -> bytes:
        asked = asked_in(payload)
        serial, hello = m.decode_request(asked.request)
        if not isinstance(hello, m.Hello):
            raise HubLost(
                "the hub does not know this connection any more: it was cut for too long; connect again"
            )
        if hello.version != m.VERSION:
            raise BadMessage(
                f"the client speaks version {hello.version}, this hub {m.VERSION}; install the same canwire for both"
            )
        may = right_of(self._offered.access, user)
        if may is None:
            raise HubError(f"{user} is no user of this hub")
        with self._greeting:
            if client not in self._guests and not self._closed:
                name = hello.name
                if asked.host != socket.gethostname():
                    name += f", {hello.pid} on {asked.host}"
                link = self._dial(name)
                # by its own key: an access list lets nobody know of subscribers to everybody's
                key = keys.client(self.offer.realm, self.offer.instance, user, client)
                self._guests[client] = Guest(
                    link,
                    user,
                    may,
                    sender(self._session, key + "/down"),
                    self._is_healthy,
                    self._offered.age_s,
                    lambda text: self._warn(f"{name}: {text}"),
                    relayed=client.startswith(keys.RELAYED),
                )
                self._heard[client] = self._session.declare_subscriber(key + "/up", direct(self._came))
                self._share_out()
        welcome = m.encode_reply(serial, m.Welcome(m.VERSION, self.offer.time))[m.LENGTH.size :]
        return encode(Answered(welcome, (), (), clock_ns=time.monotonic_ns()))

    def _say_farewell(self, client: str, text: str) -> None:
        guest = self._guests.get(client)
        if guest is not None:
            key = keys.client(self.offer.realm, self.offer.instance, guest.user, client) + "/down"
            with contextlib.suppress(self._zenoh.ZError):
                self._session.put(
                    key, wire.farewell(text), congestion_control=self._zenoh.CongestionControl.DROP
                )

    def _leave(self, client: str) -> None:
        with self._lock:
            self._absent.came(client)
            guest = self._guests.pop(client, None)
            heard = self._heard.pop(client, None)
        if heard is not None:
            heard.undeclare()
        self._share_out()
        if guest is not None:
            guest.close()

    def _share_out(self) -> None:
        """Each reader of a frame costs this process a wake-up: the more there are, the more frames go together."""
        guests = list(self._guests.values())
        for guest in guests:
            guest.pump.way.shared_with(len(guests))

    # its thread

    def _watch(self) -> None:
        """Check whether the hub answers, and drop clients that did not return."""
        while not self._closed:
            try:
                self._own.call(m.Advance(0))
            except HubLost:
                return  # the link has told
            self._healthy_s = now_s = time.monotonic()
            with self._lock:
                gone = self._absent.over(now_s)
                wait_s = self._absent.wait_s(now_s, HEALTHY_S)
                silent = [
                    client
                    for client, guest in self._guests.items()
                    if guest.timed and guest.silent_s > self._offered.timed_silence_s
                ]
                guests = list(self._guests.values())
            for guest in guests:
                guest.late.tell()
            for client in silent:
                self._say_farewell(client, "this program takes part in lockstep, and sent no sign of life")
            for client in {*gone, *silent}:
                self._leave(client)
            self._stopping.wait(wait_s)

    def _is_healthy(self) -> bool:
        return time.monotonic() - self._healthy_s < _UNHEALTHY_S
