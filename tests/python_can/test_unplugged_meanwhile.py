"""A board that goes while a bus is being opened costs only those who wanted that very board."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

import canwire
from canwire import LineStatus, NoSuchBoard, Unplugged
from canwire.python_can.line import can_places, line_of_channel


class Pulled:
    """A hub one of whose boards goes between the listing and the first look at it."""

    def __init__(self, hub: canwire.Hub, boards: set[int], error: type[Exception]) -> None:
        self._hub = hub
        self._boards = boards
        self._error = error

    def line_status(self, board: int, line: int) -> LineStatus:
        if board in self._boards:
            raise self._error("it was pulled out")
        return self._hub.line_status(board, line)

    def line_statuses(self, boards: Iterable[int]) -> dict[tuple[int, int], LineStatus]:
        return self._hub.line_statuses(set(boards) - self._boards)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._hub, name)


WANTED = canwire.WantedMode(bit_rate=500_000)


@pytest.mark.finding("faults 8")
@pytest.mark.parametrize("error", [NoSuchBoard, Unplugged])
@pytest.mark.parametrize("busy", [False, True])
def test_another_boards_end_is_not_ours(hub: canwire.Hub, error: type[Exception], busy: bool) -> None:
    boards = sorted({place.board.id for place in can_places(hub)})
    if busy:  # lines that are all used: one is shared
        for place in can_places(hub):
            channel = hub.open_channel(place.board.id, place.line)
            channel.set_up(canwire.ChannelMode(8, 8))
    pulled: Any = Pulled(hub, {boards[0]}, error)
    place, control = line_of_channel(pulled, "can0", WANTED)
    assert place.board.id in boards[1:]
    if control is not None:
        control.close()
    last = hub.boards()[-1]
    place, control = line_of_channel(pulled, f"{last.hardware_id}:0", WANTED)
    assert place.board.id == last.id


@pytest.mark.finding("faults 8")
def test_all_of_them_gone(hub: canwire.Hub) -> None:
    pulled: Any = Pulled(hub, {board.id for board in hub.boards()}, Unplugged)
    with pytest.raises(NoSuchBoard, match="can0: all its boards have just been pulled out"):
        line_of_channel(pulled, "can0", WANTED)
