"""What verbs that listen say of their lines when they begin."""

from __future__ import annotations

import pytest

import canwire
from canwire import WantedMode
from canwire.commands.live.listening import Listening, places_of
from tests.hubs import stopped_meanwhile


@pytest.mark.finding("socketcan 1")
def test_a_line_that_is_stopped_meanwhile_is_not_said_to_run() -> None:
    with canwire.connect(time="virtual") as hub:
        places = places_of(hub, ["HW000001:0"])
        with stopped_meanwhile(hub), Listening(hub, places, WantedMode()) as listening:
            assert listening.told == [
                "HW000001:0 on can0 does not run yet (it was stopped meanwhile); listening"
            ]
        with Listening(hub, places, WantedMode()) as listening:
            assert listening.told == ["HW000001:0 on can0: 500000 bit/s, 2000000 after BRS; listening"]
