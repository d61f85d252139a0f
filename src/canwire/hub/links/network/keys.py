"""Names on the network: the address of a hub as programs write it, and the keys of Zenoh.

canwire/REALM/hub/NAME/INSTANCE/VERSION/TIME      a liveliness token for each hub that is offered
canwire/REALM/to/INSTANCE/USER/CLIENT/...         one client's own: `call`, `up`, `down`, and `here`, its token

CLIENT begins with "relayed-" where the client connects through a relay (relay/). A program that may use the keys of a
user acts as that user; an access list of the hub's session enforces this.
"""

from __future__ import annotations

import re
from typing import NamedTuple
from urllib.parse import urlsplit

from canwire.errors import BadValue

SCHEME = "zenoh://"
REALM = "canwire"
PORT = 7449
ANYBODY = "anybody"  # the user of hubs without authentication
RELAYED = "relayed-"  # what the names of clients begin with that connect through a relay
_EVERYWHERE = re.compile(r"^(\w+/)(?:0\.0\.0\.0|\[::\])(:\d+)")
_WORD = re.compile(r"[A-Za-z0-9_.-]{1,64}")


class Place(NamedTuple):
    """Where a hub is: its realm and name, and the endpoint that leads to it."""

    realm: str
    name: str
    endpoint: str
    by_host: bool  # the name is the endpoint's own, and may be another one than the hub's
    relayed: bool = False  # the endpoint is a relay on this machine

    def __str__(self) -> str:
        return f"{SCHEME}{self.realm}/{self.name}"


class Offer(NamedTuple):
    """A hub that is offered."""

    realm: str
    name: str
    instance: str
    version: int
    time: str


def word(what: str, text: str) -> str:
    """A name that is valid in a key; raises BadValue."""
    if not _WORD.fullmatch(text):
        raise BadValue(f"{what} {text!r}: 1 to 64 letters, digits, and any of - _ .")
    return text


def parse(address: str) -> Place:
    """zenoh://REALM/HOST[:PORT], or zenoh://REALM/NAME with ?via=ENDPOINT or ?relay=ENDPOINT; raises BadValue.

    >>> parse("zenoh://lab/bench1:7450").endpoint
    'tcp/bench1:7450'
    >>> parse("zenoh://lab/bench1?via=tls/router:7447").endpoint
    'tls/router:7447'
    >>> parse("zenoh://lab/bench1?relay=tcp/127.0.0.1:7448").relayed
    True
    """
    form = (
        f"{address!r}: zenoh://REALM/HOST[:PORT], or zenoh://REALM/NAME?via=tcp/ADDRESS:PORT through a "
        "router, ?relay=tcp/127.0.0.1:PORT through a relay"
    )
    parts = urlsplit(address)
    host = parts.path.removeprefix("/")
    if not address.startswith(SCHEME) or not host or "/" in host or parts.fragment:
        raise BadValue(form)
    name, _, port = host.partition(":")
    if port and not (port.isdecimal() and 0 < int(port) < 1 << 16):
        raise BadValue(form)
    how, _, via = parts.query.partition("=")
    if parts.query and (how not in ("via", "relay") or "/" not in via):
        raise BadValue(form)
    endpoint = via or f"tcp/{name}:{port or PORT}"
    return Place(word("realm", parts.netloc), word("host", name), endpoint, not via, how == "relay")


def address_of(offer: Offer, listen: tuple[str, ...], via: tuple[str, ...], host: str) -> str:
    """The address for programs; `host` replaces a listening address that means all addresses of the machine.

    >>> address_of(Offer("lab", "bench1", "1c73", 6, "real"), ("tcp/0.0.0.0:7449",), (), "b.example")
    'zenoh://lab/b.example'
    >>> address_of(Offer("lab", "bench1", "1c73", 6, "real"), ("tls/[::]:7447",), (), "b.example")
    'zenoh://lab/bench1?via=tls/b.example:7447'
    >>> address_of(Offer("lab", "bench1", "1c73", 6, "real"), (), ("tcp/10.0.0.7:7447",), "b.example")
    'zenoh://lab/bench1?via=tcp/10.0.0.7:7447'
    """
    place = f"{SCHEME}{offer.realm}/"
    here = [_EVERYWHERE.sub(rf"\g<1>{host}\g<2>", endpoint) for endpoint in listen]
    for endpoint in here:
        protocol, _, where = endpoint.partition("/")
        if protocol == "tcp":
            return place + where.removesuffix(f":{PORT}")
    return place + f"{offer.name}?via={[*here, *via][0]}"


def token(offer: Offer) -> str:
    """The key of a hub's token."""
    realm, name, instance, version, time = offer
    return f"canwire/{realm}/hub/{name}/{instance}/{version}/{time}"


def tokens(realm: str, name: str = "*") -> str:
    """The keys of the tokens of all hubs of this realm, or of one hub."""
    return f"canwire/{realm}/hub/{name}/**"


def offer_of(key: str) -> Offer | None:
    """The offer in the key of a token; None for a key of another form, which a later canwire may have."""
    parts = key.split("/")
    if len(parts) != 7 or parts[2] != "hub" or not parts[5].isdecimal():
        return None
    return Offer(parts[1], parts[3], parts[4], int(parts[5]), parts[6])


def clients(realm: str, instance: str, part: str) -> str:
    """Keys of all clients of a hub for one purpose."""
    return f"canwire/{realm}/to/{instance}/*/*/{part}"


def client(realm: str, instance: str, user: str, name: str) -> str:
    """The beginning of the keys of one client."""
    return f"canwire/{realm}/to/{instance}/{user}/{name}"


def client_of(key: str) -> tuple[str, str]:
    """The user and the client of a client's key."""
    parts = key.split("/")
    return parts[4], parts[5]
