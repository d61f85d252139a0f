"""Periodic messages that the hub sends by the cyclic list of a line, even while this program is busy.

A line has one list, which one program holds at a time; all Bus objects of a process share it. A thread of python-can
sends messages that do not fit (a period that is no multiple of the ticks, too many messages, another holder).
"""

from __future__ import annotations

import logging
import math
import threading
import time
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from can import Message
from can.broadcastmanager import (
    LimitedDurationCyclicSendTaskABC,
    ModifiableCyclicTaskABC,
    RestartableCyclicTaskABC,
)

from canwire import BadFrame, BadValue, CanwireError, Hub, InUse, LineError, Scheduler, Ticks
from canwire.python_can.errors import operating, operation_error
from canwire.python_can.messages import record_of

if TYPE_CHECKING:
    from canwire import HubChannel

_LOG = logging.getLogger("can.canwire")
_DONE = 2  # boards/can/cyclic_object.py's CyclicState


class SharedList:
    """The cyclic list of a line, held while a task of this process has messages on it."""

    def __init__(self, lease: Scheduler) -> None:
        self.lease = lease
        self.lock = threading.RLock()
        self._tasks: set[HubTask] = set()

    @property
    def unused(self) -> bool:
        return not self._tasks

    def put(self, task: HubTask, records: Iterable[bytes], cycle: int, owner: HubChannel) -> list[int]:
        """Put all records on the list and return their indices; raises LineError or BadValue if they do not fit."""
        with self.lock:
            self._forget_finished()
            added: list[int] = []
            try:
                for record in records:
                    added.append(self.lease.add(record, cycle, owner=owner))
            except BaseException:
                self._remove(added)
                raise
            self._tasks.add(task)
            return added

    def take_off(self, task: HubTask, indices: list[int]) -> None:
        with self.lock:
            if task in self._tasks:
                self._tasks.remove(task)
                self._remove(indices)

    def _forget_finished(self) -> None:
        """Remove tasks whose time is over, even if they were not stopped."""
        states = self.lease.status().states
        for task in list(self._tasks):
            if task.indices and all(states[index] == _DONE for index in task.indices):
                indices, task.indices = task.indices, []
                self.take_off(task, indices)

    def _remove(self, indices: list[int]) -> None:
        for index in indices:
            self.lease.remove(index)


class Lists:
    """The lists that this process holds."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._held: dict[tuple[Hub, int, int], SharedList] = {}

    def put(self, task: HubTask, records: list[bytes], cycle: int, hub: Hub, owner: HubChannel) -> SharedList:
        """Put records on the list of the owner's line. Raises InUse, Unsupported, LineError, BadValue."""
        key = hub, owner.board, owner.line
        with self._lock:
            held = self._held.get(key)
            if held is None or held.lease.over:
                lease = hub.open_scheduler(owner.board, owner.line)
                lease.resume()
                held = self._held[key] = SharedList(lease)
            try:
                task.indices = held.put(task, records, cycle, owner)
            finally:
                self._drop_unused(key, held)
            return held

    def take_off(self, task: HubTask, hub: Hub, owner: HubChannel) -> None:
        """Take the task off the list; the last task releases the list for other programs."""
        key = hub, owner.board, owner.line
        with self._lock:
            held = self._held.get(key)
            if held is None:
                return
            try:
                if not held.lease.over:
                    indices, task.indices = task.indices, []
                    held.take_off(task, indices)
            finally:
                self._drop_unused(key, held)

    def _drop_unused(self, key: tuple[Hub, int, int], held: SharedList) -> None:
        if held.unused or held.lease.over:
            self._held.pop(key, None)
            held.lease.close()


LISTS = Lists()


class HubTask(LimitedDurationCyclicSendTaskABC, ModifiableCyclicTaskABC, RestartableCyclicTaskABC):
    """python-can's periodic task: several messages take turns, one each period.

    Raises InUse, Unsupported, LineError or BadValue if the messages cannot be on the list.
    """

    returns = False  # its bus connects again, and then calls `move`

    def __init__(
        self,
        hub: Hub,
        channel: HubChannel,
        ticks: Ticks,
        messages: Sequence[Message],
        period: float,
        duration: float | None,
        *,
        fd: bool,
    ) -> None:
        super().__init__(messages, period, duration)
        self.indices: list[int] = []
        self._hub = hub
        self._channel = channel
        self._fd = fd
        self._step = _ticks_of(self.period_ns, ticks, len(self.messages))
        self._list: SharedList | None = None
        self._moving = threading.RLock()
        self._runs, self._end_s = False, math.inf
        self._put()

    def start(self) -> None:
        """Begin with the first message; a running task begins again with it."""
        with operating(), self._moving:
            if not self.indices:
                self._put()
            self._begin(self.duration)
            self._runs = True
            self._end_s = math.inf if self.duration is None else time.monotonic() + self.duration

    def stop(self) -> None:
        """Stop sending; a second call has no effect. `start` begins again with the first message."""
        with operating(), self._moving:
            self._runs = False
            LISTS.take_off(self, self._hub, self._channel)

    @property
    def displaced(self) -> bool:
        """True if it was sending when its hub or board went, and has time left."""
        assert self._list is not None
        return self._runs and self._list.lease.over and time.monotonic() < self._end_s

    def move(self, hub: Hub, channel: HubChannel, ticks: Ticks) -> None:
        """Continue a displaced task for the rest of its time on another channel.

        Raises what the constructor raises; the task is then still displaced.
        """
        with self._moving:
            LISTS.take_off(self, self._hub, self._channel)
            if not self.displaced:  # it was stopped meanwhile
                return
            self._hub, self._channel = hub, channel
            self._step = _ticks_of(self.period_ns, ticks, len(self.messages))
            self._put()
            self._begin(None if self.duration is None else self._end_s - time.monotonic())

    def modify_data(self, messages: Sequence[Message] | Message) -> None:
        """Replace the messages; the ticks stay the same. While the hub is away, for its return."""
        before = self.messages
        super().modify_data(messages)
        try:
            with operating():
                records = [record_of(message, fd=self._fd) for message in self.messages]
                for index, record in zip(self.indices, records, strict=False):
                    assert self._list is not None
                    self._list.lease.replace(index, record)
        except BaseException:
            if not (self.returns and self.displaced):
                self.messages = before
                raise

    def _put(self) -> None:
        records = [record_of(message, fd=self._fd) for message in self.messages]
        self._list = LISTS.put(self, records, self._step * len(records), self._hub, self._channel)

    def _begin(self, duration: float | None) -> None:
        counts = self._counts(duration)
        begun = [index for index, count in zip(self.indices, counts, strict=True) if count != 0]
        endless = [0 if count is None else count for count in counts if count != 0]
        assert self._list is not None
        self._list.lease.start_in_turn(begun, endless, self._step)

    def _counts(self, duration: float | None) -> list[int | None]:
        """How many times each message is sent in `duration` seconds, None: without end."""
        number = len(self.messages)
        if duration is None:
            return [None] * number
        total = max(1, math.ceil(duration / self.period - 1e-9))
        return [(total - place + number - 1) // number for place in range(number)]


def hub_task(
    hub: Hub,
    channel: HubChannel,
    ticks: Ticks,
    messages: Sequence[Message],
    period: float,
    duration: float | None,
    *,
    fd: bool,
    name: str,
) -> HubTask | None:
    """A task on the hub's list; None if the list cannot do it, with the reason in the log."""
    try:
        return HubTask(hub, channel, ticks, messages, period, duration, fd=fd)
    except BadFrame as error:
        raise operation_error(error) from error
    except (LineError, BadValue) as error:
        level = logging.WARNING if isinstance(error, InUse) else logging.INFO
        _LOG.log(level, "%s: a thread sends every %g s instead of the hub: %s", name, period, error)
        return None
    except CanwireError as error:
        raise operation_error(error) from error


def _ticks_of(period_ns: int, ticks: Ticks, messages: int) -> int:
    """Raises BadValue for a period that the list cannot keep exactly."""
    tick_ns = ticks.tick_ns
    if (
        not tick_ns
        or period_ns < tick_ns
        or period_ns % tick_ns
        or period_ns // tick_ns * messages > ticks.maximum
    ):
        raise BadValue(
            f"a period of {period_ns} ns for {messages} messages is not 1 to {ticks.maximum} ticks of {tick_ns} ns"
        )
    return period_ns // tick_ns
