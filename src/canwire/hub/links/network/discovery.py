"""The hubs that are offered on the network that this program is connected to."""

from __future__ import annotations

from typing import Any

from canwire.errors import BadMessage, HubError, HubLost
from canwire.hub.links.network import keys
from canwire.hub.links.network.keys import Offer
from canwire.hub.links.network.session.settings import load_zenoh
from canwire.hub.protocol import messages as m

_LOOK_S = 1.5
_MANY = 1 << 16  # replies that may wait; with Zenoh's own few `get` hung at 800


def offers_in(session: Any, realm: str = "*", name: str = "*") -> list[Offer]:
    """The hubs that are offered now, by their names."""
    many = load_zenoh().handlers.FifoChannel(_MANY)
    found = session.liveliness().get(keys.tokens(realm, name), many, timeout=_LOOK_S)
    offers = {keys.offer_of(str(reply.ok.key_expr)) for reply in found if reply.ok is not None}
    return sorted(offer for offer in offers if offer is not None)


def find(session: Any, place: keys.Place, address: str) -> Offer:
    """The hub of an address: the hub of that name, or the only one at that endpoint.

    Raises HubLost if no hub matches, HubError if several do, BadMessage if the hub has another version.
    """
    offers = offers_in(session, place.realm)
    named = [offer for offer in offers if offer.name == place.name]
    if place.by_host and not named:
        named = offers
    if not named:
        there = ", ".join(offer.name for offer in offers) or "none"
        raise HubLost(f"{address}: no such hub at {place.endpoint}; in realm {place.realm}: {there}")
    if len(named) > 1:
        which = ", ".join(f"{offer.name} ({offer.instance})" for offer in named)
        raise HubError(f"{address}: several hubs could be meant: {which}; end one of them, or name the other")
    if named[0].version != m.VERSION:
        raise BadMessage(
            f"{address}: that hub speaks version {named[0].version}, this program {m.VERSION}; install the same "
            "canwire on both machines"
        )
    return named[0]
