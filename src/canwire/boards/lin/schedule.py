"""Runs schedule tables on a LIN line: one slot after the other, on a grid that does not drift.

Source: LIN 2.2A 2.3.3 and 2.4; reference/lin-protocol.md section 6.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Mapping
from functools import partial
from typing import NamedTuple

from canwire.boards.lin.line import Finished, LinLine
from canwire.errors import BadFrame, BadValue, LineError, WrongState
from canwire.timeline import Timer
from canwire.values.lin.event import LinOutcome
from canwire.values.lin.frame import MASTER_REQUEST, LinFrame
from canwire.values.lin.schedule import LinSchedule, LinSlot, SlotKind
from canwire.values.lin.timing import usual_slot_ns

_FRAME, _EVENT, _SPORADIC, _REQUEST = SlotKind.FRAME, SlotKind.EVENT, SlotKind.SPORADIC, SlotKind.REQUEST
_NOTHING = -1
_ANSWERED, _FAILED = LinOutcome.ANSWERED, LinOutcome.FAILED


class _Ready(NamedTuple):
    """A prepared slot: its length, and the function that gets its outcome."""

    slot: LinSlot
    delay_ns: int
    finished: Finished | None


class LinScheduler:
    """The master task of one line. The line must be initialised as master before `start`.

    The first round of a table counts as work of the timeline, later rounds are background, as periodic tasks
    are; so a timeline that runs until it is idle runs one round. While the line sleeps nothing is sent; the table
    continues once it is awake. A slot in which the line is busy or stopped is skipped and counted.
    """

    def __init__(self, line: LinLine, tables: Mapping[str, LinSchedule] | LinSchedule) -> None:
        self.tables = {tables.name: tables} if isinstance(tables, LinSchedule) else dict(tables)
        self.skipped = 0
        self.collisions = 0
        self._line = line
        self._timeline = line.timeline
        self._name: str | None = None
        self._ready: list[_Ready] = []
        self._resolving: deque[_Ready] = deque()
        self._index = 0
        self._first_round = True
        self._rounds_left: int | None = None
        self._next: tuple[str, int | None] | None = None
        self._due_ns = 0
        self._usual_ns = 0
        self._timer: Timer | None = None
        self._requests: deque[tuple[LinFrame, int]] = deque()
        self._to_fetch = 0

    @property
    def running(self) -> str | None:
        """The name of the running table, or None."""
        return self._name

    @property
    def waiting(self) -> int:
        """The number of requests and responses that wait for their slots."""
        return len(self._requests) + self._to_fetch

    def add(self, tables: Mapping[str, LinSchedule] | LinSchedule) -> None:
        """Add tables, which replace those of the same name; a running table does not change."""
        self.tables |= {tables.name: tables} if isinstance(tables, LinSchedule) else dict(tables)

    def start(self, name: str | None = None, *, rounds: int | None = None) -> None:
        """Run a table (None: the first one) from its first slot on: now, or after the present slot of a running table.

        It repeats until another table or `stop` ends it, or ends by itself after `rounds` rounds.
        Raises BadValue for an unknown table, WrongState for a line that is no master.
        """
        if self._line.mode is None or not self._line.mode.master:
            raise WrongState(f"{self._line.name}: only a master has a schedule; initialise the line as one")
        if not self.tables or (name is not None and name not in self.tables):
            there = ", ".join(map(repr, self.tables)) or "none"
            raise BadValue(f"{self._line.name}: no schedule {name!r}; there are {there}")
        if rounds is not None and rounds < 1:
            raise BadValue(f"rounds {rounds}: at least 1, or None for no limit")
        chosen = next(iter(self.tables)) if name is None else name
        if self._name is not None:
            self._next = (chosen, rounds)
            return
        self._line.when_awake = self._awake
        self._begin(chosen, rounds)
        self._due_ns = self._timeline.now_ns
        self._arm()

    def stop(self) -> None:
        """Start no more slots; a frame on the wire still ends. A second call does nothing."""
        self._name = self._next = None
        self._resolving.clear()
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def request(self, data: bytes, *, responses: int = 1) -> None:
        """Queue a master request of 8 bytes for the next request slot; shorter data are filled up with 0xFF.

        After it, `responses` slave responses are fetched in their slots. Raises BadFrame for more than 8 bytes.
        """
        if not 0 < len(data) <= 8:
            raise BadFrame(f"{len(data)} bytes: a master request has 1 to 8")
        if responses < 0:
            raise BadValue(f"responses {responses}: none or more")
        self._requests.append((LinFrame(MASTER_REQUEST, data.ljust(8, b"\xff")), responses))

    # slots

    def _begin(self, name: str, rounds: int | None) -> None:
        mode = self._line.mode
        assert mode is not None
        self._usual_ns = usual_slot_ns(mode.bit_rate)
        self._name = name
        self._ready = [self._make_ready(slot) for slot in self.tables[name].slots]
        self._index = 0
        self._first_round = True
        self._rounds_left = rounds

    def _arm(self) -> None:
        background = not self._first_round and self._rounds_left is None
        self._timer = self._timeline.at(self._due_ns, self._turn, background=background)

    def _turn(self) -> None:
        """Begin the next slot."""
        self._timer = None
        if self._line.controller.asleep:
            return  # `_awake` continues from here
        if self._next is not None:
            (name, rounds), self._next = self._next, None
            self._resolving.clear()
            self._begin(name, rounds)
        if self._index == len(self._ready) and not self._resolving:
            self._turn_page()
            if self._name is None:
                return
        if self._resolving:
            ready = self._resolving.popleft()
        else:
            ready = self._ready[self._index]
            self._index += 1
        self._due_ns += ready.delay_ns
        last = self._index == len(self._ready) and not self._resolving
        background = self._rounds_left is None and (last or not self._first_round)
        self._timer = self._timeline.at(
            self._due_ns, self._turn, background=background, slack_ns=self._slack_ns()
        )
        self._perform(ready)

    def _slack_ns(self) -> int:
        """How long the timer may be late: programs see the beginning of a slot only when its frame is over."""
        at_end = self._index == len(self._ready)
        if self._resolving or self._next is not None or (at_end and self._rounds_left == 1):
            return 0
        slot = self._ready[0 if at_end else self._index].slot
        controller = self._line.controller
        if slot.kind is not _FRAME or controller.bus is None:
            return 0
        return controller.bus.foreseen_ns(controller, slot.ids[0])

    def _turn_page(self) -> None:
        """At the end of a table start it again, or stop it after the last round."""
        self._index = 0
        self._first_round = False
        if self._rounds_left is not None:
            self._rounds_left -= 1
            if self._rounds_left == 0:
                self._name = None

    def _awake(self) -> None:
        if self._name is not None and self._timer is None:
            self._due_ns = self._timeline.now_ns
            self._arm()

    def _perform(self, ready: _Ready) -> None:
        slot = ready.slot
        kind = slot.kind
        if kind is _FRAME or kind is _EVENT:
            id = slot.ids[0]
        elif kind is _SPORADIC:
            id = self._most_urgent(slot.ids)
        elif kind is _REQUEST:
            self._send_request(slot)
            return
        else:
            id = slot.ids[0] if self._to_fetch else _NOTHING
        if id == _NOTHING:
            return
        try:
            self._line.ask(id, slot.length, ready.finished, kind is not _FRAME)
        except LineError:
            self.skipped += 1

    def _most_urgent(self, ids: Iterable[int]) -> int:
        is_updated = self._line.driver.is_updated
        return next((id for id in ids if is_updated(id)), _NOTHING)

    def _send_request(self, slot: LinSlot) -> None:
        if slot.data is not None:
            frame, responses = LinFrame(MASTER_REQUEST, slot.data), 1
        elif self._requests:
            frame, responses = self._requests[0]
        else:
            return
        try:
            self._line.send(frame)
        except LineError:
            self.skipped += 1
            return
        self._to_fetch = responses
        if slot.data is None:
            self._requests.popleft()

    def _make_ready(self, slot: LinSlot) -> _Ready:
        finished: Finished | None = None
        if slot.kind is _EVENT:
            finished = partial(self._event_over, slot)
        elif slot.kind is SlotKind.RESPONSE:
            finished = self._response_over
        return _Ready(slot, slot.delay_ns or self._usual_ns, finished)

    def _event_over(self, slot: LinSlot, outcome: LinOutcome) -> None:
        """After a collision, send the headers of the event's frames one by one."""
        if outcome is _FAILED:
            self.collisions += 1
            self._resolving.extend(map(self._make_ready, slot.resolving))
            if self._timer is not None:
                self._timer.cancel()
                self._arm()

    def _response_over(self, outcome: LinOutcome) -> None:
        if outcome is _ANSWERED:
            self._to_fetch -= 1
