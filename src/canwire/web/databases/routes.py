"""Opens network descriptions in the page, assigns them to buses, and closes them; all views use them."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from starlette.concurrency import run_in_threadpool
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from canwire import CanwireError
from canwire.web.actions import Call, action

if TYPE_CHECKING:
    from starlette.requests import Request

    from canwire.web.databases.loaded import Loaded
    from canwire.web.desk import Desk

OPEN_PATH = "/databases/open"
MOST_BYTES = 256 << 20


class DatabaseRoutes:
    """The routes. Files that were opened in the page are kept in a folder that is deleted when the server ends."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._folder = desk.closing.enter_context(tempfile.TemporaryDirectory(prefix="canwire-web-"))
        self._next = 1

    def routes(self) -> list[BaseRoute]:
        return [
            Route("/databases", self._listed),
            Route(OPEN_PATH, self._open, methods=["POST"]),
            Route("/databases/close", action(self._desk, self._close), methods=["POST"]),
            Route("/databases/assign", action(self._desk, self._assign), methods=["POST"]),
        ]

    def _listed(self, _: Request) -> Response:
        return JSONResponse([_told(one) for one in self._desk.databases.loaded])

    async def _open(self, request: Request) -> Response:
        """Open a file: the body contains its bytes, the query `name` its name and optionally `bus` its bus."""
        word = self._desk.words(request)
        name = Path(request.query_params.get("name", "")).name[:200]
        if not name:
            return JSONResponse({"message": word("base.needed")}, 422)
        folder = Path(self._folder, str(self._next))
        self._next += 1
        path = folder / name
        try:
            folder.mkdir()
            path.write_bytes(await request.body())
            bus = request.query_params.get("bus", "")[:80]
            loaded = await run_in_threadpool(self._desk.databases.load, path, bus, name)
        except (CanwireError, OSError) as error:
            path.unlink(missing_ok=True)
            return JSONResponse({"message": word.error(error).replace(f"{folder}/", "")}, 409)
        count = len(loaded.file.messages)
        return JSONResponse({"message": word("databases.opened", name=name, count=count)} | _told(loaded))

    def _close(self, call: Call) -> str:
        return call.word("databases.closed", name=self._desk.databases.close(call.fields.text("key")).name)

    def _assign(self, call: Call) -> str:
        bus = call.fields.text("bus", longest=80)
        call.fields.check()
        loaded = self._desk.databases.assign(call.fields.text("key"), bus)
        if not bus:
            return call.word("databases.for-all", name=loaded.name)
        return call.word("databases.for-bus", name=loaded.name, bus=bus)


def _told(one: Loaded) -> dict[str, object]:
    return {"key": one.key, "name": one.name, "bus": one.bus, "messages": len(one.file.messages)}
