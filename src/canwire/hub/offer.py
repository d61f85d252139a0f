"""Offers a hub to other machines, runs a router between them, and lists the offered hubs."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from canwire.errors import BadValue, HubLost
from canwire.hub.links.calling import RemoteLink
from canwire.hub.usual import default_address
from canwire.platform import raise_descriptor_limit
from canwire.values.checks import finite

if TYPE_CHECKING:
    from canwire.hub.handles.event import Event
    from canwire.hub.links.network.keys import Offer

_LOOK_AGAIN_S = 1.0  # see serve.py


def offer(
    address: str | None = None,
    *,
    realm: str = "canwire",
    name: str | None = None,
    listen: Sequence[str] = (),
    via: Sequence[str] = (),
    relay: Sequence[str] = (),
    access: str | None = None,
    insecure: bool = False,
    age_s: float = 2.0,
    silence_s: float = 30.0,
    ready: Callable[[str], object],
    stop: Event,
    warn: Callable[[str], object] | None = None,
) -> None:
    """Offer the hub on a socket (None: the user's default socket) to other machines until `stop` is set.

    `listen` names endpoints ("tcp/192.168.1.5:7449"; none: port 7449 of this machine's loopback), `via` Zenoh routers
    to connect to, `relay` endpoints for relays ("tcp/192.168.1.5:7450"), `access` the file of users. Without `access`,
    routers and endpoints that other machines reach are refused unless `insecure`. `name` is by default that of the
    machine. `ready` gets the address for programs. Frames and calls that were in transit for longer than `age_s` (0:
    no limit) are not carried out: frames are counted as refused, calls raise HubError, and `warn` gets a line. A
    program in lockstep is removed after `silence_s` without a sign of life.

    Raises HubLost if the hub does not run or ends, HubError if another hub has this name in the realm or the endpoint
    is in use, BadConfig for a bad file, BadValue, ExtraMissing without canwire[network].
    """
    from canwire.hub.links.network.access import Access, load
    from canwire.hub.links.network.bridge import Bridge
    from canwire.hub.links.network.offered import LOOPBACK, Offered

    raise_descriptor_limit()
    socket = default_address() if address is None else os.path.abspath(address)
    offered = Offered(
        realm=realm,
        name=name or "",
        listen=tuple(listen) or (() if via else (LOOPBACK,)),
        via=tuple(via),
        relay=tuple(relay),
        access=None if access is None else load(Access, access),
        insecure=insecure,
        age_s=finite("age_s", age_s, 0, 3600),
        timed_silence_s=finite("silence_s", silence_s, 1, 3600),
    )
    lost: list[bool] = []

    def gone() -> None:
        lost.append(True)
        stop.set()

    bridge = Bridge(lambda program: RemoteLink(socket, program), offered, gone, warn or (lambda text: None))
    with contextlib.closing(bridge):
        ready(bridge.address)
        while not stop.wait(_LOOK_AGAIN_S):
            pass
    if lost:
        raise HubLost(f"the hub on {socket} is gone; it is no longer offered")


def route(
    listen: Sequence[str], access: str, *, ready: Callable[[], object] | None = None, stop: Event
) -> None:
    """Run a router for hubs (`offer` with `via`) and programs, until `stop` is set.

    It listens at these endpoints ("tcp/192.168.1.5:7447"). `access` is the file of users that the hubs also have: the
    router admits only these, and each only by its own name. `ready` is called once it listens.
    Raises HubError if it cannot listen there, BadConfig for a bad file, BadValue without an endpoint, ExtraMissing.
    """
    from canwire.hub.links.network.access import Access, load
    from canwire.hub.links.network.session.ending import closing
    from canwire.hub.links.network.session.settings import for_router, open_for_hub

    if isinstance(listen, str) or not listen:
        raise BadValue(f"listen {listen!r}: one endpoint or more, such as ['tcp/192.168.1.5:7447']")
    users = load(Access, access)
    with closing(open_for_hub(for_router(tuple(listen), users), users)):
        if ready is not None:
            ready()
        while not stop.wait(_LOOK_AGAIN_S):
            pass


def relay(
    endpoint: str,
    *,
    listen: str = "tcp/127.0.0.1:7448",
    ready: Callable[[str], object] | None = None,
    stop: Event,
    warn: Callable[[str], object] | None = None,
) -> None:
    """Carry the connections of this machine's programs to a hub in one connection, until `stop` is set.

    Frames that several of the programs receive cross the network once. A hub listens for relays at `endpoint` (`offer`
    with `relay`), and programs of this machine connect to `listen`; `ready` gets the address for them. Each program
    identifies itself to the hub as it does without a relay. `warn` gets a line when the connection breaks, and another
    when it is back.

    Raises HubLost if no program answers at `endpoint`, HubError if no hub for relays answers there or `listen` is in
    use, and BadValue.
    """
    from canwire.hub.links.network.relay.at_programs import RelayAtPrograms

    with contextlib.closing(RelayAtPrograms(endpoint, listen, warn or (lambda text: None))) as made:
        if ready is not None:
            ready(made.address)
        while not stop.wait(_LOOK_AGAIN_S):
            pass


def offered_hubs(endpoint: str = "tcp/localhost:7449", realm: str = "*") -> list[Offer]:
    """The hubs that are offered at an endpoint of a hub or a router; raises HubLost if none answers.

    Each has `realm`, `name`, `instance`, `version` and `time`.
    """
    from canwire.hub.links.network.access import usual_login
    from canwire.hub.links.network.discovery import offers_in
    from canwire.hub.links.network.session.ending import closing
    from canwire.hub.links.network.session.settings import for_client, open_for_client

    with closing(open_for_client(for_client(endpoint, usual_login()))) as session:
        return offers_in(session, realm)
