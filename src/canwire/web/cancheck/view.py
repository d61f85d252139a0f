"""CanCheck on the page: the manual's graphical front end to a CAN port, its windows as panels of the page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.responses import PlainTextResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute

from canwire import CanwireError
from canwire.web.actions import action
from canwire.web.cancheck.checking import Checking
from canwire.web.cancheck.doing import MainDoing, WindowDoing
from canwire.web.cancheck.feed import Feed
from canwire.web.cancheck.receive import KINDS
from canwire.web.cancheck.registry import RegistryDialog, ports
from canwire.web.cancheck.send_doing import SendDoing
from canwire.web.desk import View

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.websockets import WebSocket

    from canwire.web.desk import Desk


class CanCheckView:
    """One CanCheck for all viewers with the token; others can only watch."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self.checking = Checking()
        desk.closing.callback(self.checking.hub_lost)
        desk.link.subscribe(lambda _: None, self.checking.hub_lost)
        desk.kept[VIEW.name] = self

    def routes(self) -> list[BaseRoute]:
        actions = {
            **MainDoing(self.checking).actions,
            **WindowDoing(self.checking).actions,
            **SendDoing(self.checking).actions,
        }
        return [
            Route("/cancheck", self._page),
            Route("/cancheck/entries", self._entries),
            Route("/cancheck/window", self._window),
            WebSocketRoute("/cancheck/live", self._live),
            *(
                Route(f"/cancheck/{name}", action(self._desk, do), methods=["POST"])
                for name, do in actions.items()
            ),
        ]

    def _page(self, request: Request) -> Response:
        try:
            found, trouble = ports(), ""
        except CanwireError as error:  # the registry's file makes no sense
            found, trouble = [], self._desk.words(request).error(error)
        return self._desk.page(request, VIEW, ports=found, trouble=trouble, kinds=KINDS)

    def _entries(self, request: Request) -> Response:
        """Render the entries of the registry dialog with their stored values."""
        try:
            dialog = RegistryDialog(self.checking.program.port.name)
            entries = dialog.entries()
        except CanwireError as error:
            return PlainTextResponse(self._desk.words(request).error(error), 409)
        return self._desk.part(request, "cancheck/entries.jinja", port=dialog.port, entries=entries)

    def _window(self, request: Request) -> Response:
        """Render a window's frame; a web socket sends its content."""
        query = request.query_params
        try:
            window = self.checking.program.window(int(query.get("number", ""), 16), query.get("kind", ""))
        except (ValueError, CanwireError) as error:
            return PlainTextResponse(self._desk.words(request).error(error), 404)
        return self._desk.part(request, f"cancheck/{window.kind}.jinja", window=window, kinds=KINDS)

    async def _live(self, socket: WebSocket) -> None:
        await Feed(socket, self.checking, self._desk.words(socket)).run()


VIEW = View(
    "cancheck",
    lambda desk: CanCheckView(desk).routes(),
    scripts=("cancheck.js",),
    styles=("cancheck.css",),
)
