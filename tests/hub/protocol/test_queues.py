"""Where a channel's queues lie in shared memory."""

from __future__ import annotations

from canwire.hub.protocol.queues import transmit_offset
from canwire.ring import ring_size, rounded_capacity
from tests.cases import each

CACHE_LINE = 64


@each("receive", [1, 2, 3, 7, 100, 1000])
def test_the_transmit_ring_begins_behind_the_receive_ring_on_a_cache_line_of_its_own(receive: int) -> None:
    end, begin = ring_size(rounded_capacity(receive)), transmit_offset(receive)
    assert begin % CACHE_LINE == 0
    assert end <= begin < end + CACHE_LINE
