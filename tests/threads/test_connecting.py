"""A program whose threads take turns connects once more, or starts a thread of canwire's own."""

from __future__ import annotations

from pathlib import Path

import canwire
from canwire import Hub
from tests.hubs import served_here


def test_who_connects_keeps_its_turn_until_the_links_thread_has_begun(
    canwire_hub: Hub, tmp_path: Path
) -> None:
    with served_here(tmp_path, time="real") as address, canwire.in_time(canwire_hub):
        before_ns = canwire_hub.now_ns()
        for _ in range(3):
            with canwire.connect(address) as other:
                assert other.time == "real"
        assert canwire_hub.now_ns() == before_ns
