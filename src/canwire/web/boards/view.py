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
from canwire.web.lines import Line, by_board, lateness_of, look

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.responses import Response

    from canwire import BoardInfo
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
        lines = look(hub)
        found = [one for one in by_board(lines, hub.boards()) if _fits(one, request)]
        boards, more = found[:MOST_SHOWN], max(0, len(found) - MOST_SHOWN)
        shown = [line for _, of_board in boards for line in of_board]
        notices = [("conflict", str(one)) for one in conflicts_on(hub)]
        notices += [("lateness", one) for one in lateness_of(lines)]
        leds = {line.place.address: leds_of(hub, line) for line in shown if line.can is not None}
    except HubLost as error:
        return desk.part(request, "boards/away.jinja", error=desk.words(request).error(error))
    return desk.part(request, "boards/tree.jinja", boards=boards, more=more, notices=notices, leds=leds)


def _fits(board: tuple[BoardInfo, list[Line]], request: Request) -> bool:
    """Whether it has every word that is searched for: of its name, its kind, its buses."""
    info, lines = board
    buses = " ".join(line.place.info.bus for line in lines)
    text = f"{info.hardware_id} {info.description} {info.kind} {buses}".lower()
    return all(word in text for word in request.query_params.get("q", "").lower().split())


def _registers(desk: Desk, request: Request) -> Response:
    try:
        hub = desk.link.hub
        found = [one for one in by_board(look(hub), hub.boards()) if _fits(one, request)]
        chips = registers_of(hub, {info.id for info, _ in found[:MOST_SHOWN]})
    except HubLost as error:
        return desk.part(request, "boards/away.jinja", error=desk.words(request).error(error))
    return desk.part(request, "boards/registers.jinja", chips=chips)
