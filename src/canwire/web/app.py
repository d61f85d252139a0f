"""The application: every view's routes, the static files, and the gate before all of them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.applications import Starlette
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.routing import BaseRoute, Mount, Route
from starlette.staticfiles import StaticFiles

from canwire import HubLost
from canwire.web.gate import Gate
from canwire.web.words import HERE

if TYPE_CHECKING:
    from starlette.requests import Request

    from canwire.web.desk import Desk


def make_app(desk: Desk, token: str, hosts: list[str], port: int) -> Gate:
    """`hosts` are the names and ports it answers to ("127.0.0.1:8080")."""
    routes: list[BaseRoute] = [
        Route("/", lambda request: RedirectResponse(f"/{desk.views[0].name}")),
        Route("/link", lambda request: _link(desk, request)),
    ]
    for folder in ("base", *(view.name for view in desk.views)):
        if (HERE / folder / "static").is_dir():
            routes.append(Mount(f"/static/{folder}", StaticFiles(directory=HERE / folder / "static")))
    for view in desk.views:
        routes += view.routes(desk)
    return Gate(Starlette(routes=routes, exception_handlers={HubLost: _away}), token, hosts, port)


def _link(desk: Desk, request: Request) -> Response:
    """The head's line: is the hub there, and how long was it away."""
    gaps = desk.link.gaps
    return desk.part(
        request,
        "base/link.jinja",
        away=bool(gaps) and not gaps[-1].over,
        gaps=len(gaps),
        seconds=sum(gap.seconds for gap in gaps),
    )


def _away(_: Request, error: Exception) -> Response:
    return PlainTextResponse(str(error), 503)
