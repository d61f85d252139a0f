"""The view of the boards, their lines and chips; boards can be plugged in, and lines started and stopped."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.routing import BaseRoute, Route

from canwire import HubLost, conflicts_on, every_line, kind_names
from canwire.web.actions import action
from canwire.web.boards import changes
from canwire.web.boards.leds import leds_of
from canwire.web.boards.registers import registers_of
from canwire.web.desk import View
from canwire.web.lines import by_board, lateness_of, look

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.responses import Response

    from canwire import BoardInfo, Hub
    from canwire.web.desk import Desk

MOST_SHOWN = 40  # boards; more are found by the search
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
        found = _searched(hub, request)
        shown = look(hub, [board.id for board in found[:MOST_SHOWN]])
        boards, more = by_board(shown, found[:MOST_SHOWN]), max(0, len(found) - MOST_SHOWN)
        notices = [("conflict", str(one)) for one in conflicts_on(hub)]
        notices += [("lateness", one) for one in lateness_of(shown)]
        leds = {line.place.address: leds_of(hub, line) for line in shown if line.can is not None}
    except HubLost as error:
        return desk.part(request, "boards/away.jinja", error=desk.words(request).error(error))
    return desk.part(request, "boards/tree.jinja", boards=boards, more=more, notices=notices, leds=leds)


def _searched(hub: Hub, request: Request) -> list[BoardInfo]:
    """Return the boards whose name, kind or buses contain every word of the search."""
    words = request.query_params.get("q", "").lower().split()
    buses: dict[int, str] = {}
    for place in every_line(hub) if words else ():
        buses[place.board.id] = f"{buses.get(place.board.id, '')} {place.info.bus}"
    texts = {
        info.id: f"{info.hardware_id} {info.description} {info.kind} {buses.get(info.id, '')}".lower()
        for info in hub.boards()
    }
    return [info for info in hub.boards() if all(word in texts.get(info.id, "") for word in words)]


def _registers(desk: Desk, request: Request) -> Response:
    try:
        hub = desk.link.hub
        chips = registers_of(hub, {info.id for info in _searched(hub, request)[:MOST_SHOWN]})
    except HubLost as error:
        return desk.part(request, "boards/away.jinja", error=desk.words(request).error(error))
    return desk.part(request, "boards/registers.jinja", chips=chips)
