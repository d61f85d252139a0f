"""Which hubs are offered where this program is connected."""

from __future__ import annotations

from typing import Any

from canwire.hub.links.network import keys
from canwire.hub.links.network.keys import Offer
from canwire.hub.links.network.settings import load_zenoh

_LOOK_S = 1.5
_MANY = 1 << 16  # replies that may wait; with Zenoh's own few `get` hung at 800


def offers_in(session: Any, realm: str = "*", name: str = "*") -> list[Offer]:
    """Those that are there now, by their names."""
    many = load_zenoh().handlers.FifoChannel(_MANY)
    found = session.liveliness().get(keys.tokens(realm, name), many, timeout=_LOOK_S)
    offers = {keys.offer_of(str(reply.ok.key_expr)) for reply in found if reply.ok is not None}
    return sorted(offer for offer in offers if offer is not None)
