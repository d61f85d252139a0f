"""How a hub is offered to other machines."""

from __future__ import annotations

from typing import NamedTuple

from canwire.hub.links.network import keys
from canwire.hub.links.network.access import Access
from canwire.hub.links.network.session.settings import CUT_S, LEASE_S, TIMED_SILENCE_S

LOOPBACK = f"tcp/127.0.0.1:{keys.PORT}"
GRACE_S = 2.0  # a client whose connection is broken may return within this time
AGE_S = 2.0  # of commands, which are refused after that


class Offered(NamedTuple):
    """How a hub is offered: realm and name, endpoints where it listens for programs and for relays, routers, users."""

    realm: str = keys.REALM
    name: str = ""
    listen: tuple[str, ...] = (LOOPBACK,)
    via: tuple[str, ...] = ()
    relay: tuple[str, ...] = ()
    access: Access | None = None
    insecure: bool = False
    lease_s: float = LEASE_S
    grace_s: float = GRACE_S
    cut_s: float = CUT_S
    timed_silence_s: float = TIMED_SILENCE_S
    age_s: float = AGE_S
