"""How long a way to a hub is, before anything is said on it."""

from __future__ import annotations

import socket
import time

from canwire.hub.links.network.session.door import round_trip_s


def test_a_round_trip_is_part_of_the_time_that_the_call_took() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        endpoint = f"tcp/127.0.0.1:{listener.getsockname()[1]}"
        began_s = time.monotonic()
        found_s = round_trip_s(endpoint)
        assert 0 < found_s <= time.monotonic() - began_s
    assert round_trip_s(endpoint) == 0
