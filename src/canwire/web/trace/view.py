"""The view of the trace: in chronological order or one row for each identifier, with details down to the bits."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

import numpy
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute

from canwire import BadValue
from canwire.web.actions import Call, action
from canwire.web.desk import View
from canwire.web.fields import BadFields
from canwire.web.lines import Line, look
from canwire.web.send.view import SCRIPTS, STYLES
from canwire.web.trace.details import details_of
from canwire.web.trace.feed import Feed
from canwire.web.trace.logs import Logs, file_name, writable_formats
from canwire.web.trace.look import Look
from canwire.web.trace.opened import OpenedLogs
from canwire.web.trace.plotting import MOST_PLOTTED, Wanted, curve
from canwire.web.trace.recording import Recording
from canwire.web.trace.source import LiveSource, Source
from canwire.web.trace.store.history import CHUNK, History
from canwire.web.trace.store.kinds import is_frame
from canwire.web.trace.taps import Taps
from canwire.web.trace.viewing import Viewing

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.websockets import WebSocket

    from canwire.web.desk import Desk

MOST_BUSES = 512
_ADDRESS = re.compile(r"[\w-]{1,60}:\d{1,3}")


class Tracing:
    """The state of the view: the history, the taps that fill it, the databases."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self.databases = desk.databases
        self.history = History()
        self.taps = Taps(desk.link, self.history, desk.epoch_ns)
        self.live = LiveSource(self.history, self.taps)
        self.recording = Recording(self.history, self.taps)
        self.opened = OpenedLogs()
        self.logs = Logs(desk, self.source, self.opened, self.taps)
        for close in (self.history.close, self.opened.close_all, self.taps.close, self.recording.close):
            desk.closing.callback(close)
        desk.kept[VIEW.name] = self

    def routes(self) -> list[BaseRoute]:
        return [
            Route("/trace", self._page),
            Route("/trace/lines", self._lines),
            Route("/trace/names", self._names),
            Route("/trace/row", self._row),
            Route("/trace/plot", self._plot),
            *self.logs.routes(),
            Route("/trace/recording", self._recording),
            Route("/trace/record", action(self._desk, self._record), methods=["POST"]),
            Route("/trace/record-stop", action(self._desk, self._record_stop), methods=["POST"]),
            WebSocketRoute("/trace/live", self._live),
        ]

    def source(self, name: str) -> Source:
        """Return a source; raises BadValue if it does not exist."""
        return self.opened.find(name) if name else self.live

    def _page(self, request: Request) -> Response:
        return self._desk.page(request, VIEW, formats=writable_formats())

    def _lines(self, request: Request) -> Response:
        """Return all lines with kind and state, open logs, names of messages, and the progress of the recording."""
        opened = self.opened.logs
        log = opened.get(request.query_params.get("source", ""))
        if log is not None:
            lines = [_channel(one, log.kind_of(one)) for one in log.channels]
        else:
            lines = [_line(one) for one in look(self._desk.link.hub)]
        logs = [{"key": key, "name": one.name, "reading": one.reading} for key, one in opened.items()]
        told: dict[str, object] = {"lines": lines, "logs": logs}
        word = self._desk.words(request)
        for key, state in (("recording", self.recording.progress), ("replay", self.logs.replay.played)):
            told[key] = {**state._asdict(), "trouble": word.trouble(state.trouble)}
        return JSONResponse(told)

    def _names(self, request: Request) -> Response:
        """Return names of frames by bus and identifier, and the files that define them."""
        buses = request.query_params.get("buses", "").split(",")
        found = {bus: self.databases.of(bus).names for bus in buses[:MOST_BUSES]}
        return JSONResponse({"names": found, "files": [one.name for one in self.databases.loaded]})

    def _row(self, request: Request) -> Response:
        query, word = request.query_params, self._desk.words(request)
        try:
            record = query.get("record", "")
            following = self._following(query.get("source", ""), query.get("number", ""))
            database = self.databases.of(query.get("bus", ""))
            details = details_of(record, following, database, word)
        except BadFields as bad:
            return JSONResponse({"message": word("trace.no-record"), "faults": bad.faults}, 422)
        return self._desk.part(request, "trace/details.jinja", details=details)

    def _plot(self, request: Request) -> Response:
        """Return a signal's times (seconds) and values in the rows from number `from` on, and where to continue."""
        query = request.query_params
        try:
            source = self.source(query.get("source", ""))
            wanted = Wanted(int(query["line"]), int(query["id"], 16), len(query["id"]) == 8, query["signal"])
            begin = int(query.get("from", 0))
        except (ValueError, KeyError, BadValue) as error:
            return JSONResponse({"message": self._desk.words(request).error(error)}, 422)
        end = source.history.total
        begin = max(begin, end - MOST_PLOTTED)
        database = self.databases.of(source.bus_of(wanted.line))
        times, values = curve(source.history, database, wanted, begin, end)
        return JSONResponse({"t": times, "v": values, "next": end})

    def _following(self, source: str, number: str) -> str:
        """Return in hex the next frame on the same line after the row with this number; "" if there is none nearby."""
        history = self.source(source).history
        first = int(number) if number.isdecimal() else history.total
        rows = history.read(first, first + 4 * CHUNK)
        if len(rows) < 2:
            return ""
        places = numpy.flatnonzero((rows["line"] == rows["line"][0]) & is_frame(rows))
        later = places[places > 0]
        return str(rows[later[0]]["record"].tobytes().hex()) if len(later) else ""

    def _recording(self, request: Request) -> Response:
        """Return a recording as a file: the one with the given number, else the last one."""
        number = request.query_params.get("number", "0")
        try:
            path = self.recording.path(int(number) if number.isdecimal() else -1)
        except BadValue as error:
            return JSONResponse({"message": self._desk.words(request).error(error)}, 404)
        return FileResponse(path, media_type="text/plain", filename=file_name("log"))

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
        def viewing(wanted: Look, viewer: object, before: Viewing | None) -> Viewing:
            return Viewing(wanted, self.source(wanted.source), self.databases, viewer, before, word)

        word = self._desk.words(socket)
        await Feed(socket, viewing).run()


def _line(line: Line) -> dict[str, object]:
    return {
        "address": line.place.address,
        "bus": line.place.info.bus,
        "kind": line.place.info.bus_type,
        "running": line.running,
        "state": line.state,
    }


def _channel(name: str, kind: str) -> dict[str, object]:
    """Return the description of a log's channel."""
    return {"address": name, "bus": name, "kind": kind, "running": True, "state": ""}


def _addresses(text: str) -> list[str]:
    """Return addresses that are separated by commas; none if one of them is invalid."""
    chosen = [one for one in text.split(",") if one]
    return chosen if all(map(_ADDRESS.fullmatch, chosen)) else []


VIEW = View(
    "trace",
    lambda desk: Tracing(desk).routes(),
    scripts=("trace.js", *SCRIPTS),
    styles=("trace.css", "base/vendor/uPlot-1.6.32.min.css", *STYLES),
    vendored=("uPlot-1.6.32.iife.min.js",),
)
