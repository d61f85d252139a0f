"""What happens on the lines: chronological or one row for each identifier, opened to the bits on the wire."""

from __future__ import annotations

import re
import time
from typing import TYPE_CHECKING

from starlette.responses import FileResponse, JSONResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route, WebSocketRoute

from canwire import BadValue, HubLost
from canwire.web.actions import Call, action
from canwire.web.desk import View
from canwire.web.fields import BadFields
from canwire.web.lines import look
from canwire.web.trace.details import details_of
from canwire.web.trace.feed import Feed
from canwire.web.trace.history import History
from canwire.web.trace.recording import Recording
from canwire.web.trace.saving import log_lines
from canwire.web.trace.taps import Taps

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.websockets import WebSocket

    from canwire.web.desk import Desk

_ADDRESS = re.compile(r"[\w-]{1,60}:\d{1,3}")


class Tracing:
    """What the view keeps: the history, the taps that fill it, the database."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self.database = desk.database
        self.history = History()
        self.taps = Taps(desk.link, self.history)
        desk.closing.callback(self.taps.close)
        self.recording = Recording(self.history, self.taps, lambda: desk.epoch_ns(desk.link.hub))
        desk.closing.callback(self.recording.close)
        desk.kept[VIEW.name] = self

    def routes(self) -> list[BaseRoute]:
        return [
            Route("/trace", self._page),
            Route("/trace/lines", self._lines),
            Route("/trace/row", self._row),
            Route("/trace/log", self._log),
            Route("/trace/recording", self._recording),
            Route("/trace/record", action(self._desk, self._record), methods=["POST"]),
            Route("/trace/record-stop", action(self._desk, self._record_stop), methods=["POST"]),
            WebSocketRoute("/trace/live", self._live),
        ]

    def _page(self, request: Request) -> Response:
        return self._desk.page(request, VIEW, database=self.database.name)

    def _lines(self, _: Request) -> Response:
        """Every line, its kind of bus, whether it runs; the names of messages; how far the recording is."""
        lines = [
            {
                "address": line.place.address,
                "bus": line.place.info.bus,
                "kind": line.place.info.bus_type,
                "running": line.running,
            }
            for line in look(self._desk.link.hub)
        ]
        recording = self.recording.progress._asdict()
        return JSONResponse({"lines": lines, "names": self.database.names, "recording": recording})

    def _row(self, request: Request) -> Response:
        query, word = request.query_params, self._desk.words(request)
        try:
            details = details_of(query.get("record", ""), query.get("following", ""), self.database, word)
        except BadFields as bad:
            return JSONResponse({"message": word("trace.no-record"), "faults": bad.faults}, 422)
        return self._desk.part(request, "trace/details.jinja", details=details)

    def _log(self, request: Request) -> Response:
        """The history of the lines asked for, as a file."""
        chosen = _addresses(request.query_params.get("lines", ""))
        if not chosen:
            return JSONResponse({"message": self._desk.words(request)("trace.no-lines")}, 422)
        watched = [line for line in self.taps.watched() if line.address in chosen]
        try:
            epoch_ns = self._desk.epoch_ns(self._desk.link.hub)
        except HubLost:
            epoch_ns = 0
        names = {line.number: line.bus or line.address for line in watched}
        errors = request.query_params.get("errors") == "true"
        headers = {
            "content-disposition": f'attachment; filename="{_file_name()}"',
            "x-canwire-lost": str(sum(line.lost for line in watched)),
        }
        lines = log_lines(self.history, names, epoch_ns, errors=errors)
        return StreamingResponse(lines, media_type="text/plain", headers=headers)

    def _recording(self, _: Request) -> Response:
        """The recording that runs or ran last, as a file."""
        try:
            return FileResponse(self.recording.path, media_type="text/plain", filename=_file_name())
        except BadValue as error:
            return JSONResponse({"message": str(error)}, 404)

    def _record(self, call: Call) -> str:
        chosen = _addresses(call.fields.text("lines", longest=4000))
        if not chosen:
            call.fields.fault("lines", call.word("trace.no-lines"))
        call.fields.check()
        self.recording.start(chosen)
        return call.word("trace.recording", lines=", ".join(chosen))

    def _record_stop(self, call: Call) -> str:
        self.recording.stop()
        progress = self.recording.progress
        return call.word("trace.recorded", rows=progress.rows, missed=progress.missed)

    async def _live(self, socket: WebSocket) -> None:
        await Feed(socket, self.history, self.taps).run()


def _addresses(text: str) -> list[str]:
    """Addresses with commas between them; none if one of them is none."""
    chosen = [one for one in text.split(",") if one]
    return chosen if all(map(_ADDRESS.fullmatch, chosen)) else []


def _file_name() -> str:
    return time.strftime("canwire-%Y%m%d-%H%M%S.log")


VIEW = View(
    "trace",
    lambda desk: Tracing(desk).routes(),
    scripts=("trace.js",),
    styles=("trace.css",),
)
