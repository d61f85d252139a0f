"""A channel that is closed, or set up anew, leaves no copies of its rings with the link."""

from __future__ import annotations

from contextlib import closing

from canwire import ChannelMode, Hub
from canwire.hub.links.network.client import NetworkLink
from tests.hub.links.network.places import QUICK, channel, offered


def test_copies_end_with_their_channel() -> None:
    with offered() as place:
        link = NetworkLink(place.address, "elsewhere", patience=QUICK)
        with closing(Hub(link)) as hub:
            before = len(link._pump.mirrors())
            with channel(hub, 0) as made:
                with_it = len(link._pump.mirrors())
                made.deactivate()
                made.set_up(ChannelMode(receive=64, transmit=64))
                assert len(link._pump.mirrors()) == with_it > before
            assert len(link._pump.mirrors()) == before
