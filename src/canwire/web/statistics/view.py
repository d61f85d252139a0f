"""The view of load, rates, errors and counters over time, and of faults that the page sets on a bus."""

from __future__ import annotations

from typing import TYPE_CHECKING

from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route

from canwire import HubLost
from canwire.web.actions import Call, action
from canwire.web.desk import View
from canwire.web.lines import Line, can_lines
from canwire.web.statistics.faults import KINDS, Faults
from canwire.web.statistics.sampler import Sampler

if TYPE_CHECKING:
    from starlette.requests import Request

    from canwire.web.desk import Desk
    from canwire.web.trace.view import Tracing

_ADDRESS = 80  # characters
MOST_SHOWN = 40  # lines; more are found by the search


class Statistics:
    """The state of the view: samples, and the faults it has set."""

    def __init__(self, desk: Desk) -> None:
        self._desk = desk
        self._faults = Faults()
        self._sampler = Sampler(lambda: desk.link.hub)
        desk.closing.callback(self._sampler.close)
        desk.link.subscribe(lambda _: None, self._faults.forget)

    def routes(self) -> list[BaseRoute]:
        return [
            Route("/statistics", self._page),
            Route("/statistics/table", self._table),
            Route("/statistics/samples", self._samples),
            Route("/statistics/faults", self._shown_faults),
            Route("/statistics/fault", action(self._desk, self._put), methods=["POST"]),
            Route("/statistics/cancel", action(self._desk, self._cancel), methods=["POST"]),
        ]

    def _page(self, request: Request) -> Response:
        try:
            lines = can_lines(self._desk.link.hub)
        except HubLost:
            lines = []
        buses = sorted({line.place.info.bus for line in lines} - {""})
        return self._desk.page(request, VIEW, lines=lines, buses=buses, kinds=list(KINDS), most=MOST_SHOWN)

    def _table(self, request: Request) -> Response:
        words = request.query_params.get("q", "").lower().split()
        found = [line for line in can_lines(self._desk.link.hub) if all(one in _text(line) for one in words)]
        found.sort(key=lambda line: not line.running)
        lines, more = found[:MOST_SHOWN], max(0, len(found) - MOST_SHOWN)
        latest = {line.place.address: self._sampler.samples(line.place.address, 0)[-1:] for line in lines}
        peaks = {line.place.address: self._sampler.peak(line.place.address) for line in lines}
        return self._desk.part(
            request, "statistics/table.jinja", lines=lines, more=more, latest=latest, peaks=peaks
        )

    def _samples(self, request: Request) -> Response:
        """Return columns of numbers, one list for each field of Sample; `epoch` plus a time is in
        seconds since 1970."""
        address = request.query_params.get("line", "")[:_ADDRESS]
        after = request.query_params.get("after", "0")
        if not after.isdecimal() or len(after) > 12:
            return JSONResponse({"message": "after"}, 422)
        samples = self._sampler.samples(address, int(after))
        columns = [list(column) for column in zip(*samples, strict=True)]
        tracing: Tracing = self._desk.kept["trace"]
        return JSONResponse({"columns": columns, "epoch": tracing.history.eras[-1].epoch_ns / 1e9})

    def _shown_faults(self, request: Request) -> Response:
        faults = self._faults.shown(self._desk.link.hub)
        return self._desk.part(request, "statistics/faults.jinja", faults=faults)

    def _put(self, call: Call) -> str:
        kind = call.fields.choice("kind", KINDS)
        bus = call.fields.text("bus", empty=False)
        call.fields.check()
        self._faults.put(self._desk.link.hub, bus, kind, call.fields)
        return call.word("statistics.fault-set", kind=call.word(f"statistics.kind-{kind}"), bus=bus)

    def _cancel(self, call: Call) -> str:
        number = call.fields.whole("number", 1, 1_000_000)
        call.fields.check()
        self._faults.cancel(number)
        return call.word("statistics.fault-gone")


def _text(line: Line) -> str:
    return f"{line.place.address} {line.place.info.bus} {line.place.board.description}".lower()


VIEW = View(
    "statistics",
    lambda desk: Statistics(desk).routes(),
    scripts=("plots.js", "faults.js"),
    styles=("base/vendor/uPlot-1.6.32.min.css", "statistics.css"),
    vendored=("uPlot-1.6.32.iife.min.js",),
)
