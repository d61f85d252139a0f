"""The application: every view's routes, the static files, and the gate before all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from starlette.applications import Starlette
from starlette.requests import ClientDisconnect
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.routing import BaseRoute, Route

from canwire import HubLost
from canwire.web.databases.routes import MOST_BYTES as DATABASE_BYTES
from canwire.web.databases.routes import OPEN_PATH as DATABASE_PATH
from canwire.web.databases.routes import DatabaseRoutes
from canwire.web.files import static_routes
from canwire.web.gate import Gate
from canwire.web.send.files import MOST_BYTES as LIST_BYTES
from canwire.web.trace.logs import OPEN_PATH
from canwire.web.trace.opened import MOST_BYTES

if TYPE_CHECKING:
    from starlette.requests import Request

    from canwire.web.desk import Desk


UPLOADS = {OPEN_PATH: MOST_BYTES, DATABASE_PATH: DATABASE_BYTES, "/send/load": 4 * LIST_BYTES}


def make_app(desk: Desk, token: str, hosts: list[str], port: int, *, viewers: bool) -> Gate:
    """Make the application; it answers requests for `hosts`, which are names with ports ("127.0.0.1:8080")."""
    routes: list[BaseRoute] = [
        Route("/", lambda request: RedirectResponse(f"/{desk.views[0].name}")),
        Route("/link", lambda request: _link(desk, request)),
    ]
    routes += static_routes()
    routes += DatabaseRoutes(desk).routes()
    for view in desk.views:
        routes += view.routes(desk)
    handlers: Any = {HubLost: lambda request, error: _away(desk, request, error), ClientDisconnect: _too_long}
    return Gate(
        Starlette(routes=routes, exception_handlers=handlers), token, hosts, port, UPLOADS, viewers=viewers
    )


def _link(desk: Desk, request: Request) -> Response:
    """Render the head's line: whether the hub is connected, and how long it was away."""
    gaps = desk.link.gaps
    return desk.part(
        request,
        "base/link.jinja",
        away=bool(gaps) and not gaps[-1].over,
        gaps=len(gaps),
        seconds=sum(gap.seconds for gap in gaps),
    )


def _too_long(_: Request, __: Exception) -> Response:
    """Answer a request whose body was cut by the gate; a client that has disconnected does not read this."""
    return PlainTextResponse("the body is too long", 413)


def _away(desk: Desk, request: Request, error: Exception) -> Response:
    return PlainTextResponse(desk.words(request).error(error), 503)
