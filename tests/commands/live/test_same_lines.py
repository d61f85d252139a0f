"""commands/live/same_lines.py: once a hub is back, a verb leaves other programs the boards that they had."""

from __future__ import annotations

import pytest

from canwire import Hub
from canwire.commands.live.listening import places_of
from canwire.commands.reconnecting import Watch
from tests.hub.links.network.places import CONFIG, channel, running
from tests.hubs import connected, embedded

pytestmark = pytest.mark.conforms("N-59")


def address_on(hub: Hub, watch: Watch) -> str:
    ((_, place),) = places_of(hub, ["can0"], watch)
    return place.address


def test_the_same_line_where_this_program_had_started_it() -> None:
    watch = Watch()
    for _ in range(2):  # the hub, and the one after its restart
        with embedded(CONFIG) as engine, connected(engine) as hub:
            assert address_on(hub, watch) == "HW000001:0"


def test_another_line_where_it_was_another_program_s(capsys: pytest.CaptureFixture[str]) -> None:
    watch = Watch()
    with embedded(CONFIG) as engine, connected(engine) as hub, connected(engine) as other:
        control = other.open_control(other.boards()[0].id, 0)
        assert address_on(hub, watch) == "HW000001:0"
        control.close()
    with embedded(CONFIG) as engine, connected(engine) as hub:
        assert address_on(hub, watch) == "HW000002:0"
        assert (
            "can0: HW000001:0 was another program's before; listening on HW000002:0"
            in capsys.readouterr().err
        )
    with embedded(CONFIG) as engine, connected(engine) as hub, connected(engine) as other:
        other.open_control(other.boards()[0].id, 0)  # it is back already
        assert address_on(hub, watch) == "HW000001:0"


def test_it_says_so_where_all_boards_were_other_programs(capsys: pytest.CaptureFixture[str]) -> None:
    watch = Watch()
    with embedded(CONFIG) as engine, connected(engine) as hub, connected(engine) as other:
        running(other)
        held = [channel(other, board) for board in (0, 1)]
        assert held
        assert address_on(hub, watch) == "HW000001:0"
    with embedded(CONFIG) as engine, connected(engine) as hub:
        assert address_on(hub, watch) == "HW000001:0"
        assert "all boards were other programs' before" in capsys.readouterr().err


def test_a_board_that_is_gone_is_named(capsys: pytest.CaptureFixture[str]) -> None:
    watch = Watch()
    with embedded(CONFIG) as engine, connected(engine) as hub:
        assert address_on(hub, watch) == "HW000001:0"
    with embedded(CONFIG.replace("HW000001", "HW000007")) as engine, connected(engine) as hub:
        assert address_on(hub, watch) == "HW000007:0"
        assert "HW000001:0 is not there any more; listening on HW000007:0" in capsys.readouterr().err
