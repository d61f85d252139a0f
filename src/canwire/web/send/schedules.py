"""Starts LIN lines as master or slave, and runs schedule tables in the hub: typed ones, or those of an LDF file."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from starlette.routing import BaseRoute, Route

from canwire import BadText, BadValue, LinFrame, LinSchedule, ldf, parse_lin_schedule
from canwire.web.actions import Call, action
from canwire.web.fields import BadFields

if TYPE_CHECKING:
    from canwire.web.desk import Desk
    from canwire.web.send.lin_outlets import LinOutlets

SLOWEST, FASTEST = 1_000, 20_000  # bit/s: LIN 2.2A 6.3


class Schedules:
    """Routes of the view."""

    def __init__(self, desk: Desk, outlets: LinOutlets) -> None:
        self._desk = desk
        self._outlets = outlets
        self._networks: dict[str, ldf.LinDescription] = {}

    def routes(self) -> list[BaseRoute]:
        actions = {
            "lin-up": self._up,
            "lin-down": self._down,
            "schedule": self._start,
            "schedule-stop": self._stop,
        }
        return [
            Route(f"/send/{name}", action(self._desk, do), methods=["POST"]) for name, do in actions.items()
        ]

    def tables(self) -> list[dict[str, str]]:
        """Return the schedule tables of the open LDF files."""
        return [
            {"key": f"{one.key}/{table}", "name": f"{one.name}: {table}"}
            for one in self._desk.databases.loaded
            if one.path.suffix.lower() == ".ldf"
            for table in self._network(one.key).schedules
        ]

    def _up(self, call: Call) -> str:
        line = call.fields.text("line", longest=80, empty=False)
        rate = call.fields.whole("rate", SLOWEST, FASTEST)
        role = call.fields.choice("role", ("master", "slave"))
        call.fields.check()
        self._outlets.bring_up(line, rate, master=role == "master")
        return call.word(f"send.lin-{role}", line=line, rate=rate)

    def _down(self, call: Call) -> str:
        line = call.fields.text("line", longest=80, empty=False)
        call.fields.check()
        self._outlets.shut_down(line)
        return call.word("send.lin-stopped", line=line)

    def _start(self, call: Call) -> str:
        """Start a schedule. Fields: line, rounds, and slots or the key of a table."""
        fields = call.fields
        line = fields.text("line", longest=80, empty=False)
        rounds = fields.whole("rounds", 0, 1_000_000) if fields.text("rounds") else 0
        key = fields.text("table")
        slots = fields.text("slots", longest=4000, empty=bool(key))
        fields.check()
        try:
            if key:
                table, frames = self._described(key)
            else:
                table, frames = parse_lin_schedule(filter(None, re.split(r"[\s;]+", slots)))
        except (BadValue, BadText) as bad:
            raise BadFields({"table" if key else "slots": call.word.error(bad)}) from None
        self._outlets.schedule(line, table, frames, rounds)
        return call.word("send.scheduled", line=line, count=len(table.slots))

    def _stop(self, call: Call) -> str:
        line = call.fields.text("line", longest=80)
        self._outlets.stop_schedules(line)
        return call.word("send.schedule-stopped", line=line)

    def _described(self, key: str) -> tuple[LinSchedule, list[LinFrame]]:
        """Return a table, and the responses of its master."""
        file, _, name = key.partition("/")
        if not any(one.key == file for one in self._desk.databases.loaded):
            raise BadValue(f"{key}: this description is not open any more")
        network = self._network(file)
        if name not in network.schedules:
            raise BadValue(f"{key}: {network.unusable.get(name, 'there is no such schedule')}")
        return network.schedules[name], list(network.responses(network.master).values())

    def _network(self, key: str) -> ldf.LinDescription:
        if key not in self._networks:
            path = next(one.path for one in self._desk.databases.loaded if one.key == key)
            self._networks[key] = ldf.load(path)
        return self._networks[key]
