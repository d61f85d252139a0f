"""Lists the hubs that are offered on the network, as text or JSON."""

from __future__ import annotations

import json

import canwire
from canwire.commands.console import complain


def print_offers(endpoint: str, *, as_json: bool) -> int:
    """Print the hubs offered at an endpoint; 1 if there is none."""
    offers = canwire.offered_hubs(endpoint)
    if as_json:
        print(json.dumps([offer._asdict() for offer in offers], indent=2))
    else:
        for realm, name, instance, version, time in offers:
            print(f"zenoh://{realm}/{name}  {time} time, version {version}, {instance}")
    if not offers:
        complain(f"no hub is offered at {endpoint}")
    return 0 if offers else 1
