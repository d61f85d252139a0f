"""Everything that a client opens takes some of its room; where none is left it is refused, as if never asked for."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from canwire import Hub, LimitReached
from canwire.boards.config.configuration import Config
from canwire.boards.config.limits import LimitsConfig
from canwire.boards.config.tables import BoardConfig
from tests.hub.in_memory import Bench, bench_of

FULL = Config(
    bus=Config.default().bus,
    board=(BoardConfig(kind="usb-to-can-fd", serial="HW000001"),),
    limits=LimitsConfig(leases=1, channels=1, fifos=1),
)
Opening = Callable[[Hub, int], Any]
LEASES: dict[str, Opening] = {
    "layer": lambda hub, board: hub.open_layer(board, "BAL"),
    "control": lambda hub, board: hub.open_control(board, 0),
    "LIN control": lambda hub, board: hub.open_lin_control(board, 2),
    "scheduler": lambda hub, board: hub.open_scheduler(board, 0),
    "settings": lambda hub, board: hub.keep_settings(board, 0),
    "share": lambda hub, board: hub.open_share(board, 0, read=True, write=True, share=0),
}
CHANNELS: dict[str, Opening] = {
    "channel": lambda hub, board: hub.open_channel(board, 0, exclusive=True),
    "monitor": lambda hub, board: hub.open_monitor(board, 2, exclusive=True),
}
FIFOS: dict[str, Opening] = {"fifo": lambda hub, board: hub.create_fifo(1, 1)}


bench = bench_of(FULL)


@pytest.mark.parametrize(
    ("limit", "kind", "first"),
    [
        (limit, kind, first)
        for limit, kinds in {"leases": LEASES, "channels": CHANNELS, "fifos": FIFOS}.items()
        for kind in kinds
        for first in kinds
    ],
)
def test_whatever_fills_the_room_all_others_of_its_kind_are_refused(
    bench: Bench, limit: str, kind: str, first: str
) -> None:
    openings = LEASES | CHANNELS | FIFOS
    greedy, other = bench.hub("greedy"), bench.hub("other")
    for _ in range(2):  # what was closed makes room again
        held = openings[first](greedy, bench.board)
        with pytest.raises(LimitReached, match=f"1 of 1 {limit}"):
            openings[kind](greedy, bench.board)
        if kind != first:
            openings[kind](other, bench.board).close()  # nobody holds what was refused
        held.close()
    openings[kind](greedy, bench.board).close()


def test_the_other_end_of_a_fifo_needs_room_too(bench: Bench) -> None:
    made = bench.hub("one").create_fifo(1, 1)
    other = bench.hub("other")
    own = other.create_fifo(1, 1)
    with pytest.raises(LimitReached, match="1 of 1 fifos"):
        other.open_fifo(made.id, "reader")
    own.close()
    other.open_fifo(made.id, "reader").close()
