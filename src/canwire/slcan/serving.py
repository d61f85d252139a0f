"""Runs dongles in one loop: it moves bytes between each dongle and its wire, and lets it serve its CAN side."""

from __future__ import annotations

import contextlib
import selectors
import time
from collections.abc import Callable
from functools import partial

from canwire import Event, HubLost, Unplugged
from canwire.slcan.can_side import TRANSMIT_QUEUE
from canwire.slcan.dongle import Dongle
from canwire.slcan.pace import Pace
from canwire.slcan.wires import Wire

_CHUNK = 16_384
_HOLD_LOOK_S, _LONGEST_HOLD_S = 0.01, 0.25


class Served:
    """A dongle on its wire. `event` is signalled when its CAN side has frames or events."""

    def __init__(self, dongle: Dongle, event: Event, wire: Wire, pace: Pace) -> None:
        self.dongle = dongle
        self.pace = pace
        self.event = event
        self.wire = wire
        self.blocked = False  # the wire takes no more at the moment
        self.look_at = 0.0
        self._sent, self._sent_s = 0, 0.0

    def can_side(self) -> None:
        self.event.reset()
        self.dongle.pump()
        self.bring()

    def host_side(self) -> None:
        if not self.pace:
            self.pace.put(self.wire.read())
        self.bring()

    def bring(self) -> None:
        """Pass the bytes that are due to the dongle."""
        now_s = time.monotonic()
        while not self._holds(now_s) and (data := self.pace.due(now_s)):
            self.dongle.feed(data)
        self.flush()

    def wait_s(self, now_s: float) -> float | None:
        """Seconds until `bring` has something to do; None if no bytes are held."""
        return _HOLD_LOOK_S if self.pace and self._holds(now_s) else self.pace.wait_s(now_s)

    def _holds(self, now_s: float) -> bool:
        """A paced host waits while the queue is full, unless nothing goes out at all: then it gets its BELL."""
        if not self.pace.paced:
            return False
        if self.dongle.counters.sent != self._sent or self.dongle.waiting < TRANSMIT_QUEUE:
            self._sent, self._sent_s = self.dongle.counters.sent, now_s
        return self.dongle.waiting >= TRANSMIT_QUEUE and now_s - self._sent_s < _LONGEST_HOLD_S

    def flush(self) -> None:
        """Write as much of the output as the wire accepts."""
        self.blocked = False
        while self.dongle.output:
            if not self.wire.connected:
                self.dongle.unplug_host()
                return
            written = self.wire.write(self.dongle.output[:_CHUNK])
            if written == 0 and self.wire.connected:
                self.blocked = True
                return
            self.dongle.written(written)


class Service:
    """Runs any number of dongles in one thread.

    If the board of a dongle is pulled out, `warn` is called and the others continue. `run` raises HubLost.
    """

    def __init__(self, warn: Callable[[str], object] | None = None) -> None:
        self._selector = selectors.DefaultSelector()
        self._served: list[Served] = []
        self._registered: dict[Served, dict[int, int]] = {}
        self._warn = warn

    def add(self, dongle: Dongle, event: Event, wire: Wire, *, baud_rate: int = 0) -> None:
        """Serve this dongle from now on; `event` is signalled when its CAN side has frames or events.

        With a `baud_rate` the host's bytes arrive at the pace of a serial line, else as fast as the host writes.
        """
        served = Served(dongle, event, wire, Pace(baud_rate))
        self._served.append(served)
        self._registered[served] = {}
        self._selector.register(
            event.fileno(), selectors.EVENT_READ, partial(self._work, served, served.can_side)
        )
        self._sync(served)

    def run(self, stop: Event) -> None:
        """Serve the dongles until `stop` is set, or until no dongle is left."""
        self._selector.register(stop.fileno(), selectors.EVENT_READ, None)
        try:
            while self._served:
                for key, _ in self._selector.select(self._look()):
                    if key.data is None:
                        self._count_the_last()
                        return
                    key.data()
        finally:
            self._selector.unregister(stop.fileno())

    def _count_the_last(self) -> None:
        """Fetch what has arrived from the CAN side, so that the counters at the end are complete."""
        for served in list(self._served):
            with contextlib.suppress(HubLost):
                self._work(served, served.dongle.pump)

    def close(self) -> None:
        self._selector.close()
        for served in self._served:
            served.wire.close()

    def _look(self) -> float | None:
        """Serve wires without a host and paced lines; returns the seconds until the next time."""
        wait: float | None = None
        now = time.monotonic()
        for served in list(self._served):
            if served.wait_s(now) == 0:
                self._work(served, served.bring)
            left_s = served.wait_s(now)
            if left_s is not None:
                wait = left_s if wait is None else min(wait, left_s)
            if served not in self._served or self._found(served, now):
                continue
            left = max(0.0, served.look_at - now)
            wait = left if wait is None else min(wait, left)
        return wait

    def _found(self, served: Served, now: float) -> bool:
        """True if its descriptors say when there is something on the wire: no periodic check is necessary."""
        look_s = served.wire.look_s
        if look_s is not None and (now >= served.look_at or look_s == 0):
            self._work(served, served.wire.look)
            look_s = served.wire.look_s
            served.look_at = now + (look_s or 0.0)
        return look_s is None

    def _work(self, served: Served, work: Callable[[], None]) -> None:
        was_connected = served.wire.connected
        try:
            work()
        except Unplugged as error:
            self._drop(served)
            if self._warn is not None:
                self._warn(f"{served.wire.name}: {error}")
            return
        if was_connected and not served.wire.connected:
            served.dongle.unplug_host()
        self._sync(served)

    def _sync(self, served: Served) -> None:
        """Wait for what this wire has now."""
        reading = (
            () if served.pace else served.wire.descriptors()
        )  # a host that is too fast waits in its write
        wanted = dict.fromkeys(reading, selectors.EVENT_READ)
        if served.blocked and served.wire.connected:
            descriptor = served.wire.writing()
            wanted[descriptor] = wanted.get(descriptor, 0) | selectors.EVENT_WRITE
        before = self._registered[served]
        if wanted == before:
            return
        for descriptor in before:
            if descriptor not in wanted:
                self._forget(descriptor)
        for descriptor, events in wanted.items():
            work = partial(self._work, served, served.host_side)
            if descriptor not in before:
                self._selector.register(descriptor, events, work)
            elif before[descriptor] != events:
                self._selector.modify(descriptor, events, work)
        self._registered[served] = wanted

    def _drop(self, served: Served) -> None:
        for descriptor in self._registered.pop(served):
            self._forget(descriptor)
        self._forget(served.event.fileno())
        self._served.remove(served)
        served.wire.close()

    def _forget(self, descriptor: int) -> None:
        """It may be closed already."""
        with contextlib.suppress(KeyError, ValueError, OSError):
            self._selector.unregister(descriptor)
