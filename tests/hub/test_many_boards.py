"""Thousands of boards on one bus: each look at the bus passes by each controller, so there must be few."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from canwire import BadValue, BitTiming, Hub, LineMode, conflicts_on
from canwire.boards.config.configuration import Config
from canwire.bus.can import bus
from canwire.commands.devices.uses import LinUse, boards_of
from canwire.hub.owner.engine import Engine
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.web.lines import look
from tests.hubs import connected

BOARDS = 130
CONFIG = (
    '[[bus]]\nname = "can0"\n' + BOARDS * '[[board]]\nkind = "usb-to-can-fd"\nbuses = ["can0", "can0", ""]\n'
)
FEW = {"ListBoards": 1, "GetLineStatuses": 3, "GetLinStatuses": 3}


@pytest.fixture(scope="module")
def engine() -> Iterator[Engine]:
    made = Engine(World(Config.parse(CONFIG), virtual=True), "virtual")
    yield made
    made.close()


@pytest.fixture
def hub(engine: Engine) -> Iterator[Hub]:
    with connected(engine) as made:
        yield made


@pytest.fixture
def asked(hub: Hub, monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    found: Counter[str] = Counter()
    ask: Callable[[m.Message], Any] = hub.ask

    def counted(request: m.Message) -> Any:
        found[type(request).__name__] += 1
        return ask(request)

    monkeypatch.setattr(hub, "ask", counted)
    return found


def test_devices_asks_for_many_lines_at_once(hub: Hub, asked: Counter[str]) -> None:
    found = list(boards_of(hub))
    assert asked == FEW
    assert len(found) == BOARDS
    for board, uses in found:
        assert [isinstance(use, LinUse) for use in uses] == [False, False, True]
        assert uses[:2] == [hub.line_status(board.id, line) for line in (0, 1)]


def test_the_page_does_too(hub: Hub, asked: Counter[str]) -> None:
    lines = look(hub)
    assert asked == FEW
    assert [(line.place.line, line.can is None, line.lin is None) for line in lines] == BOARDS * [
        (0, False, True),
        (1, False, True),
        (2, True, False),
    ]


def test_rates_on_a_bus(hub: Hub, asked: Counter[str]) -> None:
    assert conflicts_on(hub, "can0") == []
    assert asked == {"ListBoards": 1, "GetLineStatuses": 3}


def test_one_reply_asks_the_buses_for_their_lateness_once(
    hub: Hub, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks: list[int] = []

    def late() -> tuple[int, int]:
        looks.append(1)
        return 5, 7

    monkeypatch.setattr(engine.world, "lateness", late)
    boards = [board.id for board in hub.boards()][:64]
    can, lin = hub.line_statuses(boards), hub.lin_statuses(boards)
    assert len(looks) == 2
    assert {(status.behind_ns, status.skipped_ns) for status in can.values()} == {(5, 7)}
    assert {(state.status.behind_ns, state.status.skipped_ns) for state in lin.values()} == {(5, 7)}


def test_boards_that_are_not_there_are_left_out(hub: Hub) -> None:
    board = hub.boards()[0].id
    assert set(hub.line_statuses([board, 99_999, board])) == {(board, 0), (board, 1)}
    assert set(hub.lin_statuses([99_999, board])) == {(board, 2)}
    assert hub.line_statuses([]) == {}


def test_one_reply_has_an_end(hub: Hub) -> None:
    assert len(hub.call(m.GetLineStatuses(tuple(range(1, 257)))).values) == 2 * BOARDS
    for request in (m.GetLineStatuses(tuple(range(257))), m.GetLinStatuses(tuple(range(257)))):
        with pytest.raises(BadValue, match="the lines of 257 boards: at most 256 in one request"):
            hub.call(request)


def test_a_start_looks_closely_only_where_it_is_set_up_in_a_new_way(
    hub: Hub, engine: Engine, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks: list[str] = []
    status = CanSlot.status

    def counted(slot: CanSlot) -> Any:
        looks.append(slot.name)
        return status(slot)

    monkeypatch.setattr(CanSlot, "status", counted)
    told: list[str] = []
    monkeypatch.setattr(engine.world, "warn", told.append)
    boards = [board.id for board in hub.boards()]
    rates = (500_000, 500_000, 500_000, 500_000, 250_000)
    controls = [hub.open_control(board, 0) for board in boards[: len(rates)]]
    seen: list[int] = []
    for control, rate in zip(controls, rates, strict=True):
        assert told == []
        looks.clear()
        control.initialise(LineMode(BitTiming.for_bit_rate(rate)))
        control.start()
        seen.append(len(looks))
    assert seen == [1, 2, 0, 0, 5]  # at the first, at the first company, and at another rate
    assert len(told) == 1
    assert told[0].startswith("can0: different bit rates on one bus: HW000001")
    controls[0].start()
    assert len(told) == 1
    for control in controls:
        control.close()


def test_a_board_that_is_plugged_has_nobody_look_at_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    look: Callable[..., Any] = bus.in_step
    looks: list[object] = []

    def counted(*found: Any) -> Any:
        looks.append(found)
        return look(*found)

    monkeypatch.setattr(bus, "in_step", counted)
    World(Config.parse(CONFIG), virtual=True)
    assert not looks
