"""What moves records between the rings of one end of a link and the other end: one thread, which nobody waits for."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from canwire.errors import BadMessage
from canwire.hub.links.network import wire
from canwire.hub.links.network.lockstep.stirs import IncomingStirs, OutgoingStirs
from canwire.hub.links.network.mirrors import Incoming, Outgoing
from canwire.hub.links.network.notes import IncomingNotes, OutgoingNotes
from canwire.hub.links.network.watched import Watched
from canwire.platform import EventDescriptor, Poller
from canwire.ring import RECHECK_S

if TYPE_CHECKING:
    from canwire.hub.links.network.wire import Report

Sender = Outgoing | OutgoingNotes | OutgoingStirs
Taker = Incoming | IncomingNotes | IncomingStirs
Mirror = Sender | Taker | Watched
HEARTBEAT_NS = 400_000_000  # between two signs of life
_ASK_NS = 50_000_000  # before what was sent and has not come is asked for
_WATCH_NS = 20_000_000  # between two looks at FIFOs that are only looked at


@dataclass
class _Moved:
    """A mirror, and events that go with it: the first is signalled when its ring moves at this end."""

    mirror: Mirror
    events: tuple[EventDescriptor, ...]


class Pump:
    """`send` takes a payload for the other end, drops it rather than wait, and may be called from any thread.

    `take` gets what comes from there, in order or not, some of it twice or never: nothing of it is lost for good.
    `healthy` says whether signs of life are to be given.
    """

    def __init__(
        self,
        send: Callable[[bytes], object],
        doorbell: EventDescriptor | None = None,
        healthy: Callable[[], bool] = lambda: True,
    ) -> None:
        self._send = send
        self._healthy = healthy
        self._moved: dict[int, _Moved] = {}
        self._sending = threading.Lock()  # over taking something to be sent, and sending it
        self._changing = threading.Lock()  # over which mirrors there are
        self._arrived = threading.Condition()
        self._awaiting = 0
        self._stopping = False
        self.quiet = False  # rings are moved with calls and answers, and their events are for others
        self._asked_ns = self._beaten_ns = self._watched_ns = 0
        self.heard_ns = time.monotonic_ns()
        self._wake = EventDescriptor()
        self._events = [self._wake] if doorbell is None else [self._wake, doorbell]
        self._poller = Poller()
        for event in self._events:
            self._poller.watch(event.fileno(), Poller.READABLE)
        self._thread = threading.Thread(target=self._run, name="canwire-network", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def add(self, mirror: Mirror, *events: EventDescriptor) -> None:
        """Move this one, too; the first of `events` is signalled when its ring moves here, all are closed with it."""
        with self._changing:
            self._moved[mirror.number] = _Moved(mirror, events)
            for event in events[:1]:
                self._poller.watch(event.fileno(), Poller.READABLE)
        self.wake()

    def remove(self, numbers: tuple[int, ...]) -> None:
        """No longer; unknown ones are ignored."""
        for number in numbers:
            with self._changing:
                moved = self._moved.pop(number, None)
                for event in () if moved is None else moved.events[:1]:
                    self._poller.unwatch(event.fileno())
            if moved is not None:
                self._let_go(moved)

    def wake(self) -> None:
        """There may be something to send."""
        self._wake.signal()

    def flush(self) -> None:
        """Send what is there now, and what was taken here: what is said next comes behind it."""
        with self._sending:
            self._send_all(time.monotonic_ns(), at_once=True)

    def written(self) -> tuple[tuple[int, int], ...]:
        """Where the writers of outgoing rings are now."""
        return tuple((one.number, one.written) for one in self.mirrors() if isinstance(one, Sender))

    def mirror(self, number: int) -> Mirror | None:
        """The one of this number, if it is still moved."""
        moved = self._moved.get(number)
        return None if moved is None else moved.mirror

    def await_arrival(self, positions: tuple[tuple[int, int], ...], timeout: float) -> bool:
        """Wait until incoming rings are so far; False if they are not within so many seconds."""
        if self._have(positions):
            return True
        deadline = time.monotonic() + timeout
        with self._arrived:
            self._awaiting += 1
            try:
                while not self._have(positions) and not self._stopping:
                    left = deadline - time.monotonic()
                    if left <= 0:
                        return False
                    self._ask_for(positions)
                    self._arrived.wait(min(left, _ASK_NS / 1e9))
            finally:
                self._awaiting -= 1
        return self._have(positions)

    def take(self, payload: bytes) -> None:
        """What came from the other end; raises BadMessage. Never waits."""
        self.heard_ns = time.monotonic_ns()
        kind = payload[0] if payload else 0
        if kind == wire.FRAMES:
            self._accept(payload)
        elif kind == wire.REPORTS:
            self._acknowledge(wire.reports_in(payload))
        elif kind == wire.STATES:
            self._compare(wire.states_in(payload))
        elif kind == wire.COUNTS:
            for count in wire.counts_in(payload):
                watched = self._moved.get(count.ring)
                if watched is not None and isinstance(watched.mirror, Watched) and watched.mirror.show(count):
                    self.wake()
        else:
            raise BadMessage(f"a message of kind {kind}: 1 to 5")

    def close(self) -> None:
        """End, and let go of every ring; a second time does nothing."""
        if self._stopping:
            return
        self._stopping = True
        self._wake.signal()
        with self._arrived:
            self._arrived.notify_all()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join()
        self.remove(tuple(self._moved))
        self._poller.close()
        self._wake.close()

    # what comes

    def _accept(self, payload: bytes) -> None:
        number, first, records = wire.frames_in(payload)
        moved = self._moved.get(number)
        if moved is None or not isinstance(moved.mirror, Taker):
            return  # closed meanwhile, or not open yet: then it is asked for
        if moved.mirror.accept(first, records):
            self.wake()
        if self._awaiting:
            with self._arrived:
                self._arrived.notify_all()

    def _acknowledge(self, found: list[Report]) -> None:
        for report in found:
            moved = self._moved.get(report.ring)
            if moved is not None and isinstance(moved.mirror, Sender):
                moved.mirror.acknowledge(report)
                if moved.mirror.sent != moved.mirror.written:
                    self.wake()

    def _compare(self, found: list[tuple[int, int]]) -> None:
        for number, sent in found:
            moved = self._moved.get(number)
            if moved is not None and isinstance(moved.mirror, Taker):
                moved.mirror.sent(sent)
                self.wake()

    def _have(self, positions: tuple[tuple[int, int], ...]) -> bool:
        return not any(self._misses(number, position) for number, position in positions)

    def _misses(self, number: int, position: int) -> bool:
        moved = self._moved.get(number)
        return moved is not None and isinstance(moved.mirror, Taker) and moved.mirror.received < position

    def _ask_for(self, positions: tuple[tuple[int, int], ...]) -> None:
        for number, position in positions:
            moved = self._moved.get(number)
            if moved is not None and isinstance(moved.mirror, Taker):
                moved.mirror.sent(position)
        self.wake()

    # the thread

    def _run(self) -> None:
        timeout = 0.0
        while not self._stopping:
            found = self._poller.wait(timeout)
            self._clear({descriptor for descriptor, _ in found})
            try:
                timeout = self._turn()
            except Exception:  # one that fails at every turn must not take the whole processor
                traceback.print_exc(file=sys.stderr)
                timeout = 0.1

    def _turn(self) -> float:
        """Send what is due; the seconds until something else may be."""
        now_ns = time.monotonic_ns()
        with self._sending:
            self._send_all(now_ns)
            self._send_signs(now_ns)
        due_ns = min(self._beaten_ns + HEARTBEAT_NS, self._arm_all(now_ns))
        wait = max(0, due_ns - time.monotonic_ns()) / 1e9
        return wait if RECHECK_S is None else min(wait, RECHECK_S)

    def _send_all(self, now_ns: int, *, at_once: bool = False) -> None:
        """What was taken here is told before what is sent: who makes room and then sends finds that room there."""
        while True:
            mirrors = self.mirrors()
            found = [
                batch
                for one in mirrors
                if isinstance(one, Sender)
                for batch in one.batches(now_ns, at_once=at_once)
            ]
            self._tell(mirrors, now_ns, at_once=at_once or bool(found))
            for batch in found:
                self._send(batch)
            if not found:
                return

    def _tell(self, mirrors: list[Mirror], now_ns: int, *, at_once: bool) -> None:
        takers = [one for one in mirrors if isinstance(one, Taker)]
        reports = [made for one in takers if (made := one.report(now_ns, at_once=at_once)) is not None]
        watched = [one for one in mirrors if isinstance(one, Watched)]
        counts = [changed for one in watched if (changed := one.changed()) is not None]
        if reports:
            self._send(wire.reports(reports))
        if counts:
            self._send(wire.counts(counts))

    def _send_signs(self, now_ns: int) -> None:
        """That this end lives, and what it has sent, for the other one to find out what it misses."""
        beat = now_ns >= self._beaten_ns + HEARTBEAT_NS
        sent = [
            (one.number, one.sent) for one in self.mirrors() if isinstance(one, Sender) and one.unconfirmed
        ]
        if beat or (sent and now_ns >= self._asked_ns + _ASK_NS):
            self._asked_ns = now_ns
            if self._healthy():
                self._send(wire.states(sent))
                counts = [one.now() for one in self.mirrors() if isinstance(one, Watched)] if beat else []
                if counts:
                    self._send(wire.counts(counts))
        if beat:
            self._beaten_ns = now_ns

    def _arm_all(self, now_ns: int) -> int:
        """When to look at the rings again without any signal."""
        due_ns = now_ns + HEARTBEAT_NS
        for mirror in self.mirrors():
            if isinstance(mirror, Watched):
                due_ns = min(due_ns, now_ns + _WATCH_NS)
                continue
            if not self.quiet:
                due_ns = min(due_ns, mirror.arm(now_ns) or due_ns)
            if not isinstance(mirror, Taker) and mirror.unconfirmed:
                due_ns = min(due_ns, self._asked_ns + _ASK_NS)
        return due_ns

    def mirrors(self) -> list[Mirror]:
        """Everything that is moved."""
        with self._changing:
            return [moved.mirror for moved in self._moved.values()]

    def _clear(self, ready: set[int]) -> None:
        with self._changing:
            watched = [event for moved in self._moved.values() for event in moved.events[:1]]
            for event in (*self._events, *watched):
                if event.fileno() in ready:
                    event.clear()

    def _let_go(self, moved: _Moved) -> None:
        with self._sending, contextlib.suppress(OSError):
            moved.mirror.close()
            for event in moved.events:
                event.close()
