"""Which line an interface is, while boards come and go."""

from __future__ import annotations

from typing import Any

import pytest

import canwire
from canwire import NoSuchBoard, Unplugged, WantedMode, every_line
from canwire.socketcan.lines import channel_on, company_for, line_of
from tests.hubs import left_meanwhile, taken_meanwhile
from tests.python_can.test_unplugged_meanwhile import Pulled


@pytest.mark.finding("faults 8")
@pytest.mark.parametrize("error", [NoSuchBoard, Unplugged])
def test_another_boards_end_is_not_ours(error: type[Exception]) -> None:
    with canwire.connect(time="virtual") as hub:
        boards = sorted({place.board.id for place in every_line(hub, "CAN")})
        pulled: Any = Pulled(hub, {boards[-1]}, error)
        place, control = line_of(pulled, "can0", WantedMode())
        assert place.board.id in boards[:-1]
        assert control is not None
        with control:
            company = company_for(pulled, place, WantedMode())
        assert company is not None
        assert company[0].board.id in boards[:-1]
        company[1].close()


@pytest.mark.finding("socketcan 1")
def test_whoever_had_the_line_running_may_leave_while_a_channel_is_opened() -> None:
    with canwire.connect(time="virtual") as hub:
        _, first = channel_on(hub, "HW000001:0", WantedMode())
        with left_meanwhile(first):
            place, second = channel_on(hub, "HW000001:0", WantedMode())
        assert place.status(hub).running
        assert place.status(hub).channels == 1
        second.close()


def test_a_line_that_somebody_takes_meanwhile_is_not_chosen() -> None:
    """Both programs would be one node on that bus, and nobody would acknowledge."""
    with canwire.connect(time="virtual") as hub:
        first, *others = canwire.find_lines(hub, "can0", "CAN")
        with taken_meanwhile(hub):
            place, control = line_of(hub, "can0", WantedMode())
            assert place in others
            assert control is not None
            control.close()
        with taken_meanwhile(hub):
            company = company_for(hub, first, WantedMode())
            assert company is not None
            assert company[0] in others[1:]
            company[1].close()
