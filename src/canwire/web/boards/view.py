"""The boards, their lines and chips; what can be plugged, started and stopped."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.routing import BaseRoute, Route

from canwire import HubLost, conflicts_on, kind_names
from canwire.web.actions import action
from canwire.web.boards import changes
from canwire.web.boards.leds import leds_of
from canwire.web.boards.registers import registers_of
from canwire.web.desk import View
from canwire.web.lines import by_board, lateness_of, look

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.responses import Response

    from canwire.web.desk import Desk

RATES = (1_000_000, 800_000, 500_000, 250_000, 125_000, 100_000, 50_000, 20_000, 10_000)


def routes(desk: Desk) -> list[BaseRoute]:
    return [
        Route("/boards", lambda request: _page(desk, request)),
        Route("/boards/tree", lambda request: _tree(desk, request)),
        Route("/boards/registers", lambda request: _registers(desk, request)),
        *(
            Route(f"/boards/{name}", action(desk, do), methods=["POST"])
            for name, do in changes.ACTIONS.items()
        ),
    ]


VIEW = View("boards", routes, scripts=("registers.js",), styles=("boards.css",))


def _page(desk: Desk, request: Request) -> Response:
    return desk.page(request, VIEW, rates=RATES, kinds=kind_names())


def _tree(desk: Desk, request: Request) -> Response:
    try:
        hub = desk.link.hub
        lines = look(hub)
        boards = by_board(lines, hub.boards())
        notices = [*map(str, conflicts_on(hub)), *lateness_of(lines)]
        leds = {line.place.address: leds_of(hub, line) for line in lines if line.can is not None}
    except HubLost as error:
        return desk.part(request, "boards/away.jinja", error=str(error))
    return desk.part(request, "boards/tree.jinja", boards=boards, notices=notices, leds=leds)


def _registers(desk: Desk, request: Request) -> Response:
    try:
        chips = registers_of(desk.link.hub)
    except HubLost as error:
        return desk.part(request, "boards/away.jinja", error=str(error))
    return desk.part(request, "boards/registers.jinja", chips=chips)
