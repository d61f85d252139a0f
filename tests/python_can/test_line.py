"""Which line a bus of python-can gets while other programs look for one, too."""

from __future__ import annotations

import pytest

import canwire
from canwire.python_can.line import line_of_channel
from tests.hubs import taken_meanwhile


@pytest.mark.conforms("PL-01")
def test_a_line_that_somebody_takes_meanwhile_is_not_chosen(hub: canwire.Hub) -> None:
    """Two programs that began together were one node, of which nobody acknowledged what the other one sent."""
    first, *others = canwire.find_lines(hub, "can0", "CAN")
    with taken_meanwhile(hub):
        place, control = line_of_channel(hub, "can0", canwire.WantedMode(500_000))
        assert place in others
        assert control is not None
        control.close()
        assert first.status(hub).channels == 1
