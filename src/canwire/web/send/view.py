"""The view of the transmit list: frames sent by hand, by a key, or in a cycle, on any line; and
schedules of LIN lines."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from canwire import CanwireError, LinFrame
from canwire.web.actions import Call, action
from canwire.web.desk import View
from canwire.web.fields import Fields
from canwire.web.lines import look
from canwire.web.send.exact import ExactCycles
from canwire.web.send.files import MOST_BYTES, read, typed_of, written
from canwire.web.send.lin_outlets import LinOutlets
from canwire.web.send.outlets import Outlets
from canwire.web.send.row import Row, Sent
from canwire.web.send.schedules import Schedules
from canwire.web.send.transmit_list import TransmitList
from canwire.web.send.typed import typed_row

if TYPE_CHECKING:
    from starlette.requests import Request

    from canwire.web.database import Database
    from canwire.web.desk import Desk

SCRIPTS, STYLES = ("send/send.js",), ("send/send.css",)  # of every page with the list


class Sending:
    """The state of the view: the list, and the objects that send it."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._outlets = Outlets(desk.link)
        self.lin = LinOutlets(desk.link)
        self._exact = ExactCycles(desk.link)
        for close in (self._outlets.close, self.lin.close, self._exact.close):
            desk.closing.callback(close)
        self.list = TransmitList(self._send, self._drop, self._exact)
        desk.closing.callback(self.list.close)
        self._schedules = Schedules(desk, self.lin)
        desk.kept[VIEW.name] = self

    def routes(self) -> list[BaseRoute]:
        actions = {
            "put": self._put,
            "change": self._change,
            "remove": self._remove,
            "now": self._now,
            "start": self._start,
            "stop": self._stop,
            "stop-all": self._stop_all,
            "load": self._load,
        }
        return [
            Route("/send", lambda request: self._desk.page(request, VIEW)),
            Route("/send/list", self._list),
            Route("/send/choices", self._choices),
            Route("/send/signals", self._signals),
            Route("/send/file", self._file),
            *(
                Route(f"/send/{name}", action(self._desk, do), methods=["POST"])
                for name, do in actions.items()
            ),
            *self._schedules.routes(),
        ]

    def database_of(self, address: str) -> Database:
        """Return the description of this line's bus; while the hub is away, that for every bus."""
        try:
            buses = {one.place.address: one.place.info.bus for one in look(self._desk.link.hub)}
        except CanwireError:
            buses = {}
        return self._desk.databases.of(buses.get(address, ""))

    def change(self, number: int, given: dict[str, str], call: Call) -> Row:
        """Change these fields of a row, whose cycle continues; raises BadFields, BadValue."""
        before = typed_of(self.list.row(number))
        fields = Fields({**before, **given, "number": str(number)}, call.word)
        return self.list.put(typed_row(fields, call.word, self.database_of))

    def set_signal(self, call: Call, line: str, message: str, signal: str, value: str) -> None:
        """Change a signal in the row of this message, and send the row unless its cycle runs; a missing row is added.

        Raises BadFields, BadValue, and the errors of queuing the frame.
        """
        for row in self.list.rows:
            if row.line == line and row.content.message == message:
                row = self.change(row.number, {f"signal.{signal}": value}, call)
                break
        else:
            fields = Fields({"line": line, "message": message, f"signal.{signal}": value}, call.word)
            row = self.list.put(typed_row(fields, call.word, self.database_of))
        if not row.running:
            self.list.send_now(row.number)

    def _send(self, row: int, line: str, frame: Sent) -> None:
        if isinstance(frame, LinFrame):
            self.lin.send(row, line, frame)
        else:
            self._outlets.send(row, line, frame)

    def _drop(self, row: int) -> None:
        self._outlets.drop(row)
        self.lin.drop(row)

    def _delivered(self, row: int) -> int:
        return self._outlets.delivered(row) + self.lin.delivered(row) + self._exact.delivered(row)

    def _list(self, request: Request) -> Response:
        rows = [self._shown(row) for row in self.list.rows]
        return self._desk.part(request, "send/list.jinja", rows=rows, scheduled=self.lin.scheduled)

    def _choices(self, _: Request) -> Response:
        """Return the choices for a row: lines with the names of their messages."""
        try:
            lines = look(self._desk.link.hub)
        except CanwireError:
            lines = []
        messages = {one.place.info.bus: self._desk.databases.of(one.place.info.bus) for one in lines}
        told = [
            {
                "address": one.place.address,
                "bus": one.place.info.bus,
                "board": one.place.board.description,
                "lin": one.lin is not None,
                "running": one.running,
                "state": one.state,
            }
            for one in lines
        ]
        return JSONResponse(
            {
                "lines": told,
                "messages": {bus: database.messages_of() for bus, database in messages.items()},
                "tables": self._schedules.tables(),
            }
        )

    def _signals(self, request: Request) -> Response:
        """Render the fields for a message's signals."""
        query = request.query_params
        inputs = self.database_of(query.get("line", "")).inputs(query.get("message", ""))
        return self._desk.part(request, "send/signals.jinja", inputs=inputs)

    def _file(self, _: Request) -> Response:
        """Return the list as a file, which `load` accepts."""
        text = written(typed_of(row) for row in self.list.rows)
        headers = {"content-disposition": 'attachment; filename="transmit-list.json"'}
        return Response(text, media_type="application/json", headers=headers)

    def _load(self, call: Call) -> str:
        """Add the rows of such a file after the present rows."""
        text = call.fields.text("list", longest=MOST_BYTES, empty=False)
        call.fields.check()
        rows = read(text, call.word, lambda fields: typed_row(fields, call.word, self.database_of))
        for row in rows:
            self.list.put(row)
        return call.word("send.loaded", count=len(rows))

    def _shown(self, row: Row) -> dict[str, object]:
        """Return the values for list.jinja: the row, its number of acknowledged frames, and its typed values."""
        typed = typed_of(row)
        delivered = self._delivered(row.number)
        inputs = self.database_of(row.line).inputs(row.content.message) if row.content.message else []
        return {
            "row": row,
            "sent": delivered,
            "waiting": 0 if row.exact else max(0, row.queued - delivered),
            "inputs": [(one, row.content.signals.get(one.name, "")) for one in inputs],
            "typed": typed,
        } | typed

    def _put(self, call: Call) -> str:
        row = self.list.put(typed_row(call.fields, call.word, self.database_of))
        return call.word("send.kept", number=row.number)

    def _change(self, call: Call) -> str:
        number = _number(call)
        given = {name: value for name, value in call.fields.given.items() if name != "number"}
        self.change(number, given, call)
        return call.word("send.kept", number=number)

    def _remove(self, call: Call) -> str:
        number = _number(call)
        self.list.remove(number)
        return call.word("send.removed", number=number)

    def _now(self, call: Call) -> str:
        number = _number(call)
        self.list.send_now(number)
        return call.word("send.sent-now", number=number)

    def _start(self, call: Call) -> str:
        number = _number(call)
        self.list.start(number)
        return call.word("send.started", number=number)

    def _stop(self, call: Call) -> str:
        number = _number(call)
        self.list.stop(number)
        return call.word("send.stopped", number=number)

    def _stop_all(self, call: Call) -> str:
        self.list.stop_all()
        self.lin.stop_schedules()
        return call.word("send.all-stopped")


def _number(call: Call) -> int:
    number = call.fields.whole("number", 1, 1_000_000)
    call.fields.check()
    return number


VIEW = View("send", lambda desk: Sending(desk).routes(), scripts=SCRIPTS, styles=STYLES)
