"""The transmit list: by hand, on a key, in a cycle, for any line."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.responses import Response
from starlette.routing import BaseRoute, Route

from canwire import HubLost
from canwire.web.actions import Call, action
from canwire.web.desk import View
from canwire.web.lines import can_lines
from canwire.web.send.files import MOST_BYTES, read, written
from canwire.web.send.outlets import Outlets
from canwire.web.send.transmit_list import Row, TransmitList
from canwire.web.send.typed import typed_row

if TYPE_CHECKING:
    from starlette.requests import Request

    from canwire.web.desk import Desk


class Sending:
    """What the view keeps: the list, and the channels it sends from."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._outlets = outlets = Outlets(desk.link)
        desk.closing.callback(outlets.close)
        self.list = TransmitList(outlets.send, outlets.drop)
        desk.closing.callback(self.list.close)

    def routes(self) -> list[BaseRoute]:
        actions = {
            "put": self._put,
            "remove": self._remove,
            "now": self._now,
            "start": self._start,
            "stop": self._stop,
            "stop-all": self._stop_all,
            "load": self._load,
        }
        return [
            Route("/send", self._page),
            Route("/send/list", self._list),
            Route("/send/signals", self._signals),
            Route("/send/file", self._file),
            *(
                Route(f"/send/{name}", action(self._desk, do), methods=["POST"])
                for name, do in actions.items()
            ),
        ]

    def _page(self, request: Request) -> Response:
        try:
            lines = can_lines(self._desk.link.hub)
        except HubLost:
            lines = []
        return self._desk.page(request, VIEW, lines=lines, messages=self._desk.database.messages())

    def _list(self, request: Request) -> Response:
        return self._desk.part(request, "send/list.jinja", rows=[self._shown(row) for row in self.list.rows])

    def _signals(self, request: Request) -> Response:
        """Fields for a message's signals."""
        inputs = self._desk.database.inputs(request.query_params.get("message", ""))
        return self._desk.part(request, "send/signals.jinja", inputs=inputs)

    def _file(self, _: Request) -> Response:
        """The list as a file, which `load` takes."""
        text = written(_fields(row) for row in self.list.rows)
        headers = {"content-disposition": 'attachment; filename="transmit-list.json"'}
        return Response(text, media_type="application/json", headers=headers)

    def _load(self, call: Call) -> str:
        """Rows of such a file, after those that are there."""
        text = call.fields.text("list", longest=MOST_BYTES, empty=False)
        call.fields.check()
        rows = read(text, call.word, lambda fields: typed_row(fields, call.word, self._desk.database))
        for row in rows:
            self.list.put(row)
        return call.word("send.loaded", count=len(rows))

    def _shown(self, row: Row) -> dict[str, object]:
        """For list.jinja: the row, how often it was on the bus, and what is typed for it."""
        typed = _fields(row)
        delivered = self._outlets.delivered(row.number)
        return {
            "row": row,
            "sent": delivered,
            "waiting": max(0, row.queued - delivered),
            "typed": typed,
        } | typed

    def _put(self, call: Call) -> str:
        row = self.list.put(typed_row(call.fields, call.word, self._desk.database))
        return call.word("send.kept", number=row.number)

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
        return call.word("send.all-stopped")


def _number(call: Call) -> int:
    number = call.fields.whole("number", 1, 1_000_000)
    call.fields.check()
    return number


def _fields(row: Row) -> dict[str, str]:
    """What is typed to get this row."""
    frame = row.frame
    kind = "remote" if frame.remote else "fdbrs" if frame.bit_rate_switch else "fd" if frame.fd else "classic"
    return {
        "line": row.line,
        "format": kind,
        "id": f"{frame.id:08X}" if frame.extended else f"{frame.id:03X}",
        "extended": "on" if frame.extended else "",
        "data": frame.data.hex(" ").upper(),
        "dlc": str(frame.dlc),
        "cycle": f"{row.cycle_ms:g}" if row.cycle_ms else "",
        "most": str(row.most or ""),
        "key": row.key,
        "comment": row.comment,
        "message": row.message,
        **{f"signal.{name}": value for name, value in row.signals},
    }


VIEW = View("send", lambda desk: Sending(desk).routes(), scripts=("send.js",), styles=("send.css",))
