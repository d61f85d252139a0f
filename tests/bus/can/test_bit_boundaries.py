"""Where each node's own bits begin and end between frames, and what happens in the middle of them."""

from __future__ import annotations

import pytest

from canwire import Frame
from canwire.bus.can import station as states
from tests.bus.can.test_around_frames import C04, Recorder, in_third_bit, offered

pytestmark = pytest.mark.core


# an SOF in the third bit of the intermission


def test_who_joins_an_sof_in_the_third_bit_drives_nothing_before_its_next_bit() -> None:
    node = Recorder()
    clock = in_third_bit(node)
    node.offer = offered(Frame(0x400))
    station = clock.station
    station.sample(0)
    assert (station.transmitting, station.out) == (True, 1)
    station.begin_bit()
    assert (station.index, station.out) == (1, 1)
    assert station.state == states.FRAME
