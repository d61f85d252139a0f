"""Share modes and channel limits of a line."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import InUse, NoChannel
from canwire.boards.sharing import SHARE_READ, SHARE_WRITE, Share, Sharing
from tests.cases import each
from tests.effort import examples

ACCESS = list(product([False, True], [False, True], range(4)))


@pytest.mark.conforms("FS-17")
@each(
    ("first", "second", "works"),
    [
        ((True, False, SHARE_READ), (True, False, 3), True),
        ((True, False, SHARE_READ), (False, True, 3), False),
        ((False, True, SHARE_WRITE), (False, True, 3), True),
        ((False, True, SHARE_WRITE), (True, False, 3), False),
        ((True, True, 0), (True, False, 3), False),
        ((True, True, 0), (False, True, 3), False),
        ((True, True, 3), (True, True, 3), True),
        ((True, False, 3), (True, False, SHARE_WRITE), False),  # who came first reads
        ((True, True, 0), (False, False, 3), True),  # to query takes nothing from anybody
        ((False, False, 0), (True, True, 0), True),
    ],
)
def test_share_modes(first: tuple[bool, bool, int], second: tuple[bool, bool, int], works: bool) -> None:
    sharing = Sharing("line")
    sharing.open(Share("first", *first))
    if works:
        sharing.open(Share("second", *second))
    else:
        with pytest.raises(InUse, match="first"):
            sharing.open(Share("second", *second))


@pytest.mark.conforms("FS-16")
def test_channels_run_out_and_come_back() -> None:
    sharing = Sharing("line", receive_channels=2, send_channels=3)
    both = [Share(str(number), True, True, 3) for number in range(2)]
    for share in both:
        sharing.open(share)
    with pytest.raises(NoChannel, match="all 2 receive channels"):
        sharing.open(Share("late", True, False, 3))
    sharing.open(Share("writer", False, True, 3))
    with pytest.raises(NoChannel, match="all 3 send channels"):
        sharing.open(Share("late", False, True, 3))
    sharing.close(both[0])
    sharing.close(both[0])
    sharing.open(Share("late", True, True, 3))
    assert len(sharing) == 3


@examples(100)
@given(st.lists(st.tuples(st.sampled_from(ACCESS), st.booleans()), max_size=30))
def test_what_was_refused_leaves_nothing(steps: list[tuple[tuple[bool, bool, int], bool]]) -> None:
    sharing, open_shares = Sharing("line", 2, 3), list[Share]()
    for access, closes in steps:
        if closes and open_shares:
            sharing.close(open_shares.pop(0))
        share = Share("one", *access)
        try:
            sharing.open(share)
        except InUse:
            continue
        open_shares.append(share)
        assert len(sharing) == len(open_shares)
        assert sum(other.read for other in open_shares) <= 2
        assert sum(other.write for other in open_shares) <= 3
        for one, other in product(open_shares, open_shares):
            if one is not other and (one.read or one.write):
                assert not other.read or one.share & SHARE_READ
                assert not other.write or one.share & SHARE_WRITE
