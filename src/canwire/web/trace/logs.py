"""Saves the shown rows as a log of any format, and opens a log of any format."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy
from starlette.concurrency import run_in_threadpool
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import BaseRoute, Route

from canwire import BadValue, create_log, log_formats
from canwire.web.actions import Call, action
from canwire.web.fields import BadFields
from canwire.web.trace.look import Look
from canwire.web.trace.opened import OpenedLogs
from canwire.web.trace.replay import Replay, Wanted
from canwire.web.trace.saving import write_rows
from canwire.web.trace.store.filtering import BadFilter
from canwire.web.trace.store.history import CHUNK
from canwire.web.trace.viewing import selected

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.types import Receive, Scope, Send

    from canwire.web.desk import Desk
    from canwire.web.send.lin_outlets import LinOutlets
    from canwire.web.send.view import Sending
    from canwire.web.trace.source import Source
    from canwire.web.trace.taps import Taps

OPEN_PATH = "/trace/open"
_FIRST_S = 1.0  # for the first rows of a log
_AT_ONCE = 1 << 20  # bytes of a log that are written together
_FOLDERS = ("trace", "journal")  # formats that are no single file


class Download(FileResponse):
    """A file in a separate folder, which is removed afterwards, whatever becomes of the download."""

    def __init__(self, folder: tempfile.TemporaryDirectory[str], path: Path, **options: Any) -> None:
        super().__init__(path, **options)
        self._folder = folder

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        with self._folder:
            await super().__call__(scope, receive, send)


class Logs:
    """Routes of the trace. `source` returns a source by its name, and raises BadValue."""

    def __init__(self, desk: Desk, source: Callable[[str], Source], opened: OpenedLogs, taps: Taps) -> None:
        self._desk = desk
        self._source = source
        self._opened = opened
        self._taps = taps
        self.replay = Replay(desk.link, self._lin_outlets)
        desk.closing.callback(self.replay.stop)

    def routes(self) -> list[BaseRoute]:
        return [
            Route("/trace/log", self._save),
            Route(OPEN_PATH, self._open, methods=["POST"]),
            Route("/trace/close", action(self._desk, self._close), methods=["POST"]),
            Route("/trace/replay", action(self._desk, self._replay), methods=["POST"]),
            Route("/trace/replay-stop", action(self._desk, self._replay_stop), methods=["POST"]),
        ]

    def _save(self, request: Request) -> Response:
        """Save the rows of a viewer's view, or the rows with some numbers, as a file of the requested format."""
        query, word = request.query_params, self._desk.words(request)
        try:
            look = _look(query)
            source = self._source(look.source)
            form = next(one for one in writable_formats() if one == query.get("format", "candump"))
            if source.live:
                self._taps.settle()
            parts = self._parts(look, source, query.get("numbers"))
        except (ValueError, BadFilter, BadValue, StopIteration) as error:
            return JSONResponse({"message": str(error) or word("trace.no-lines")}, 422)
        names = {one.number: one.bus or one.address for one in source.lines(look.lines) if one.number >= 0}
        if not names:
            return JSONResponse({"message": word("trace.no-lines")}, 422)
        suffix = next(one.suffixes[0] for one in log_formats() if one.name == form)
        folder = tempfile.TemporaryDirectory(prefix="canwire-web-")
        path = Path(folder.name, f"trace{suffix}")
        errors = query.get("errors") == "true"
        try:
            with create_log(path, format=form) as log:
                for rows in parts:
                    write_rows(log, rows, names, source.history.eras, errors=errors)
        except OSError as error:  # the disk is full, perhaps
            folder.cleanup()
            return JSONResponse({"message": word.error(error)}, 409)
        headers = {"x-canwire-lost": str(sum(line.lost for line in source.lines(look.lines)))}
        kind = "text/plain" if form == "candump" else "application/octet-stream"
        name = file_name(suffix.removeprefix("."))
        return Download(folder, path, media_type=kind, filename=name, headers=headers)

    def _parts(self, look: Look, source: Source, numbers: str | None) -> Iterator[numpy.ndarray]:
        """Yield the rows with these numbers, or all rows that pass the filter, some at a time."""
        if numbers is not None:
            wanted = sorted({int(one) for one in numbers.split(",") if one})
            return iter([source.history.pick(numpy.array(wanted, numpy.int64))])
        rows = selected(look, source, self._desk.databases)
        return (rows.rows(at, CHUNK) for at in range(rows.gone, rows.count, CHUNK))

    def _lin_outlets(self) -> LinOutlets:
        sending: Sending = self._desk.kept["send"]
        return sending.lin

    def _replay(self, call: Call) -> str:
        """Replay a log. Fields: source, line.CHANNEL for each channel of the log, speed, and for the range from, to
        (s), filter."""
        fields = call.fields
        onto = {
            name.removeprefix("line."): fields.text(name, longest=80)
            for name in fields.given
            if name.startswith("line.")
        }
        onto = {channel: line for channel, line in onto.items() if line}
        query = {"lines": ",".join(onto), "source": fields.text("source")}
        query["filter"] = fields.text("filter", longest=400)
        speed = fields.real("speed", 0, 1000)
        begin_s = fields.real("from", 0, 1e9) if fields.text("from") else 0.0
        end_s = fields.real("to", 0, 1e9) if fields.text("to") else None
        self._check_lines(call, onto)
        log = self._opened.find(query["source"])
        try:
            selection = selected(_look(query), log, self._desk.databases)
        except (ValueError, BadFilter) as bad:
            raise BadFields({"filter": call.word("trace.bad-filter", part=str(bad))}) from None
        end_ns = None if end_s is None else round(end_s * 1e9)
        lines = {log.channels.index(one): line for one, line in onto.items() if one in log.channels}
        self.replay.start(Wanted(log.name, selection, lines, speed, round(begin_s * 1e9), end_ns))
        return call.word("trace.replaying", name=log.name, line=", ".join(lines.values()))

    def _check_lines(self, call: Call, onto: Mapping[str, str]) -> None:
        """Check that each line has at most one channel, and that at least one line is given."""
        fields = call.fields
        if not onto:
            first = next((name for name in fields.given if name.startswith("line.")), "line.")
            fields.fault(first, call.word("base.needed"))
        for place, (channel, line) in enumerate(onto.items()):
            if line in list(onto.values())[:place]:
                fields.fault(f"line.{channel}", call.word("trace.line-twice", line=line))
        fields.check()

    def _replay_stop(self, call: Call) -> str:
        self.replay.stop()
        return call.word(
            "trace.replayed", sent=self.replay.played.sent, delivered=self.replay.played.delivered
        )

    async def _open(self, request: Request) -> Response:
        """Open a log: the body contains its bytes, the query `name` its name; the answer contains its key."""
        name = Path(request.query_params.get("name", "")).name[:200]
        if not name:
            return JSONResponse({"message": self._desk.words(request)("base.needed")}, 422)
        folder = tempfile.TemporaryDirectory(prefix="canwire-web-")
        path = Path(folder.name, name)
        try:
            with path.open("wb") as file:
                pieces, size = [], 0
                async for piece in request.stream():
                    pieces.append(piece)
                    size += len(piece)
                    if size >= _AT_ONCE or not piece:  # the last one is empty
                        await run_in_threadpool(file.writelines, pieces)
                        pieces, size = [], 0
            key = self._opened.open(name, folder, path)
            await run_in_threadpool(
                self._opened.find(key).wait, _FIRST_S
            )  # who looks then finds its channels
        except (OSError, BadValue) as error:
            folder.cleanup()
            return JSONResponse({"message": self._desk.words(request).error(error)}, 409)
        return JSONResponse({"message": self._desk.words(request)("trace.opened", name=name), "key": key})

    def _close(self, call: Call) -> str:
        key = call.fields.text("key")
        name = self._opened.find(key).name
        self._opened.close(key)
        return call.word("trace.closed", name=name)


def writable_formats() -> list[str]:
    """Return the names of the formats that are written to one file."""
    return [one.name for one in log_formats() if one.writes and one.name not in _FOLDERS]


def _look(query: Mapping[str, str]) -> Look:
    until = query.get("until", "")
    return Look.parse(
        {
            "number": 0,
            "source": query.get("source", ""),
            "lines": [one for one in query.get("lines", "").split(",") if one],
            "filter": query.get("filter", ""),
            "direction": query.get("direction", ""),
            "since": int(query.get("since", 0)),
            "until": int(until) if until else None,
        }
    )


def file_name(suffix: str) -> str:
    """Return the name of a download, with the date and time of day."""
    return time.strftime(f"canwire-%Y%m%d-%H%M%S.{suffix}")
