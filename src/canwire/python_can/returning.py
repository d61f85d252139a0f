"""`reconnect=True`: a thread opens a bus again after its hub or its board was away."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple, cast
from weakref import WeakMethod, WeakSet

import can

from canwire import Absence, BadValue, CanwireError, Closed, Event, Hub, HubLost, Unplugged
from canwire.python_can.hubs import HUBS
from canwire.python_can.opened import Opened, Wish

if TYPE_CHECKING:
    from can.broadcastmanager import ThreadBasedCyclicSendTask

    from canwire.python_can.periodic import HubTask

_LOG = logging.getLogger("can.canwire")


class Missed(NamedTuple):
    """How many times a bus was without its hub or board, for how many seconds in all, and its messages lost by that."""

    times: int = 0
    seconds: float = 0.0
    unsent: int = 0


def check_reconnect(reconnect: object, hub: object) -> None:
    """Raise BadValue unless `reconnect` is a bool; a True one needs a hub that can be connected by its address."""
    if not isinstance(reconnect, bool):
        raise BadValue(f"reconnect={reconnect!r}: True or False")
    if reconnect and not isinstance(hub, (str, type(None))):
        raise BadValue(
            f"reconnect=True, hub={hub!r}: a lost canwire.Hub cannot be connected again; give its address"
        )


class Returning:
    """The thread of one bus. `adopt` makes the bus use what was opened again; it may raise CanwireError.

    Messages that waited to be sent are discarded and counted, so that none is sent late.
    """

    def __init__(self, opened: Opened, wish: Wish, adopt: Callable[[Opened], None]) -> None:
        if opened.hub.timed or opened.hub.virtual:
            raise BadValue(
                "reconnect=True: the time of a lockstep or virtual hub does not continue in another hub"
            )
        self.missed = Missed()
        self._tasks: WeakSet[HubTask] = WeakSet()
        self._opened = opened
        self._wish = wish
        self._adopt = WeakMethod(adopt)
        self._address = opened.hub.address
        self._name = opened.company.channel_info
        self._absence = Absence()
        self._displaced = Absence()  # of the place that periodic messages have at the hub
        self._unsent_before = 0
        self._closed = False
        self._changed = threading.Condition()
        self._look = Event()
        opened.hub.watch(self._look)
        threading.Thread(target=self._run, name=f"canwire-returning {wish.name}", daemon=True).start()

    @property
    def away(self) -> bool:
        """True while the hub or the board is gone."""
        return self._opened.channel.over

    def receive(self, timeout: float | None) -> can.Message | None:
        """As Receiver.receive, but it waits while the hub is away."""
        end_s = None if timeout is None else time.monotonic() + timeout
        left_s, waited = timeout, False
        while True:
            receiver = self._opened.receiver
            try:
                message = receiver.receive(left_s)
            except (HubLost, Unplugged):
                message = None
                self._look.set()
            except Closed:
                if not waited:
                    raise
                return None  # it was shut down meanwhile
            if end_s is not None:
                left_s = max(0.0, end_s - time.monotonic())
            if message is not None or self._closed or left_s == 0:
                return message

            def changed(before: object = receiver) -> bool:
                now = self._opened.receiver
                return self._closed or now is not before or bool(now.ready)

            with self._changed:
                self._changed.wait_for(changed, left_s)
            waited = True

    def keep(self, task: HubTask) -> HubTask:
        """The same periodic task; it continues after an absence."""
        task.returns = True
        self._tasks.add(task)
        return task

    def patient(self, task: can.CyclicSendTaskABC) -> can.CyclicSendTaskABC:
        """The same thread of python-can that sends periodically; it continues after an absence."""
        threaded = cast("ThreadBasedCyclicSendTask", task)
        threaded.bus = cast("can.BusABC", _Patient(self, threaded.bus))
        return threaded

    def leave_out(self) -> None:
        """Count a message that a periodic task did not send."""
        with self._changed:
            self._count(unsent=1)

    def close(self) -> None:
        """End the thread; waiting threads return."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._look.set()

    def _run(self) -> None:
        while not self._closed and self._adopt() is not None:
            if self.away:
                self._come_back()
            if not self.away:
                self._place_tasks()
            pauses_s = [one.pause_s for one in (self._absence, self._displaced) if one.lasts]
            self._look.wait(min(pauses_s, default=None))

    def _come_back(self) -> None:
        """Try to open everything again."""
        before = self._opened
        if not self._absence.lasts:
            self._note_loss(before)
        try:
            hub = HUBS.acquire(self._address)
            try:
                opened = self._open(hub, before)
            except BaseException:
                HUBS.release(hub)
                raise
        except CanwireError as error:
            self._failed(error)
            return
        before.close()
        before.hub.unwatch(self._look)
        opened.hub.watch(self._look)
        HUBS.release(before.hub)
        self._note_return(opened)

    def _open(self, hub: Hub, before: Opened) -> Opened:
        opened = Opened(hub, self._wish, before)
        try:
            with self._changed:
                adopt = self._adopt()
                if self._closed or adopt is None:
                    raise HubLost("the bus was shut down meanwhile")
                adopt(opened)
                self._opened = opened
                self._changed.notify_all()
        except BaseException:
            opened.close()
            raise
        return opened

    def _note_loss(self, before: Opened) -> None:
        before.receiver.drain()
        with self._changed:
            self._unsent_before = self.missed.unsent
            self._count(times=1, unsent=before.sender.left())
            self._changed.notify_all()  # what had arrived before is received now
        try:
            before.channel.check()
        except CanwireError as error:
            self._failed(error)

    def _failed(self, error: CanwireError) -> None:
        if self._absence.failed(error) and not self._closed:
            _LOG.warning("%s: %s; connecting again", self._name, error)

    def _note_return(self, opened: Opened) -> None:
        away_s = self._absence.end()
        assert away_s is not None
        with self._changed:
            self._count(seconds=away_s)
            unsent = self.missed.unsent - self._unsent_before
        _LOG.warning(
            "%s: connected again on %s; the %.1f s before were missed, and %d messages were not sent",
            self._name,
            opened.place.address,
            away_s,
            unsent,
        )

    def _place_tasks(self) -> None:
        """Put periodic messages on the list of the line that there is now."""
        opened = self._opened
        displaced = [task for task in self._tasks if task.displaced]
        for task in displaced:
            try:
                task.move(opened.hub, opened.channel, opened.place.info.capabilities.cyclic)
            except CanwireError as error:
                if self._displaced.failed(error):
                    _LOG.warning("%s: periodic messages wait: %s", self._name, error)
                return
        self._displaced.end()

    def _count(self, times: int = 0, seconds: float = 0.0, unsent: int = 0) -> None:
        had = self.missed
        self.missed = Missed(had.times + times, had.seconds + seconds, had.unsent + unsent)


class _Patient:
    """What a thread of python-can sends by: nothing is sent while the hub is away, and the thread does not end."""

    def __init__(self, returning: Returning, bus: can.BusABC) -> None:
        self._returning = returning
        self._bus = bus

    def send(self, message: can.Message) -> None:
        try:
            self._bus.send(message)
        except can.CanOperationError:
            if not self._returning.away:
                raise
            self._returning.leave_out()
