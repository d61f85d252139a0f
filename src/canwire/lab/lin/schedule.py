"""The schedules of a master: their forms in calls, and their run in the time of a lab."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from canwire.boards.lin.line import LinLine
from canwire.boards.lin.schedule import LinScheduler
from canwire.lab.time import LabTime
from canwire.values.checks import nanoseconds
from canwire.values.lin.schedule import LinSchedule, LinSlot

Slot = int | LinSlot | tuple[int, float]
Table = LinSchedule | Iterable[Slot]


class LabSchedule(LinScheduler):
    """The LinScheduler of boards/lin/schedule.py; it stops the timeline while a schedule is changed."""

    def __init__(self, time: LabTime, line: LinLine) -> None:
        super().__init__(line, {})
        self._time = time

    def start(self, name: str | None = None, *, rounds: int | None = None) -> None:
        with self._time.touch():
            super().start(name, rounds=rounds)

    def stop(self) -> None:
        with self._time.touch():
            super().stop()

    def request(self, data: bytes, *, responses: int = 1) -> None:
        with self._time.touch():
            super().request(data, responses=responses)


def tables_of(schedule: Table | Mapping[str, Table]) -> dict[str, LinSchedule]:
    if isinstance(schedule, Mapping):
        return {name: _table(table, name) for name, table in schedule.items()}
    table = _table(schedule, "")
    return {table.name: table}


def _table(table: Table, name: str) -> LinSchedule:
    if isinstance(table, LinSchedule):
        return table
    slots: list[int | LinSlot] = []
    for slot in table:
        if isinstance(slot, tuple):
            id, seconds = slot
            slot = LinSlot.frame(id, delay_ns=nanoseconds("slot", seconds))
        slots.append(slot)
    return LinSchedule.of(slots, name)
