"""Panels: signals as values, switches and sliders, which a browser keeps and saves to files.

A value is the newest one on its line, from any sender. A switch or slider changes its signal in the transmit list's row
of that message (a missing row is added), and sends the row unless its cycle runs.
"""

from __future__ import annotations

import asyncio
import json
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy
from starlette.concurrency import run_in_threadpool
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute

from canwire.web.actions import Call, action
from canwire.web.desk import View
from canwire.web.live import converse
from canwire.web.trace.answers import frame_of
from canwire.web.trace.store.kinds import Mask, identifiers, is_frame

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.websockets import WebSocket

    from canwire.web.desk import Desk
    from canwire.web.send.view import Sending
    from canwire.web.trace.view import Tracing

PACE_S = 0.1
MOST = 200  # of a panel
_LONGEST = 200


class Bound(NamedTuple):
    """The signal that one part of a panel shows."""

    line: str
    message: str
    signal: str


class Panels:
    """The panels: values come from the trace's history, changes are made in the transmit list."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk

    def routes(self) -> list[BaseRoute]:
        return [
            Route("/panels", lambda request: self._desk.page(request, VIEW)),
            Route("/panels/signals", self._signals),
            Route("/panels/set", action(self._desk, self._set), methods=["POST"]),
            WebSocketRoute("/panels/live", self._live),
        ]

    @property
    def _tracing(self) -> Tracing:
        found: Tracing = self._desk.kept["trace"]
        return found

    @property
    def _sending(self) -> Sending:
        found: Sending = self._desk.kept["send"]
        return found

    def _signals(self, request: Request) -> Response:
        """Return a message's signals with their possible values."""
        query = request.query_params
        inputs = self._sending.database_of(query.get("line", "")).inputs(query.get("message", ""))
        return JSONResponse([one._asdict() for one in inputs])

    def _set(self, call: Call) -> str:
        fields = call.fields
        line = fields.text("line", longest=80, empty=False)
        message, signal = (fields.text(name, longest=_LONGEST, empty=False) for name in ("message", "signal"))
        value = fields.text("value", empty=False)
        fields.check()
        self._sending.set_signal(call, line, message, signal, value)
        return call.word("panels.was-set", signal=signal, value=value)

    async def _live(self, socket: WebSocket) -> None:
        """Receive {"bound": [[line, message, signal], ...]} from the viewer, and send the values in that order."""
        bound: list[Bound] = []
        viewer = object()

        def hear(told: dict[str, Any]) -> None:
            bound[:] = [Bound(*map(_text, one)) for one in told["bound"][:MOST]]
            self._tracing.taps.want(viewer, {one.line for one in bound})

        async def speak() -> None:
            before = ""
            while True:
                text = json.dumps(await run_in_threadpool(self._values, list(bound)))
                if text != before:
                    await socket.send_text(text)
                before = text
                await asyncio.sleep(PACE_S)

        try:
            await converse(socket, speak, hear)
        finally:
            self._tracing.taps.want(viewer, ())

    def _values(self, bound: list[Bound]) -> list[dict[str, object] | None]:
        """Return text, unit and number of each signal; None if its message has not been received."""
        watched = {line.address: line for line in self._tracing.taps.watched()}
        found: dict[tuple[str, str], dict[str, dict[str, object]]] = {}
        for one in bound:
            key = one.line, one.message
            if key not in found and one.line in watched:
                found[key] = self._signals_of(watched[one.line].number, watched[one.line].bus, one.message)
        return [found.get((one.line, one.message), {}).get(one.signal) for one in bound]

    def _signals_of(self, line: int, bus: str, message: str) -> dict[str, dict[str, object]]:
        database = self._desk.databases.of(bus)
        wanted = [int(key, 16) for key, name in database.names.items() if name == message]

        def test(rows: numpy.ndarray) -> Mask:
            return is_frame(rows) & (identifiers(rows) == (wanted or [-1])[0])

        page = self._tracing.history.identifiers.page([line], test, numpy.zeros(0), 0, 4)
        for row in page.rows:
            frame = frame_of(row["record"].tobytes())
            if frame is not None and database.name_of(frame) == message:
                return {
                    one.name: {
                        "text": one.value,
                        "unit": one.unit,
                        "number": database.number(frame, one.name),
                    }
                    for one in database.signals(frame)
                }
        return {}


def _text(value: object) -> str:
    if not isinstance(value, str) or len(value) > _LONGEST:
        raise ValueError("a text")
    return value


VIEW = View("panels", lambda desk: Panels(desk).routes(), scripts=("panels.js",), styles=("panels.css",))
