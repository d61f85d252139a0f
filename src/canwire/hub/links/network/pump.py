"""Moves records between the rings of one end of a link and the other end, in one thread that blocks no other."""

from __future__ import annotations

import contextlib
import sys
import threading
import time
import traceback
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING

from canwire.errors import BadMessage
from canwire.hub.links.network import wire
from canwire.hub.links.network.cuts.age import OtherClock
from canwire.hub.links.network.flow.way import Way
from canwire.hub.links.network.incoming import Incoming
from canwire.hub.links.network.mirrors import FULL, Outgoing
from canwire.hub.links.network.moved import Mirror, Moved, Sender
from canwire.platform import EventDescriptor
from canwire.ring import RECHECK_S

if TYPE_CHECKING:
    from canwire.hub.links.network.wire import Report

HEARTBEAT_NS = 400_000_000  # between two signs of life
_ASK_NS = 50_000_000  # before what was sent and has not come is asked for
_WATCH_NS = 20_000_000  # between two looks at FIFOs that are only looked at


class Pump:
    """Moves records. `send` sends a payload, drops it rather than wait, and may be called from any thread.

    `take` is called with the payloads of the other end, in any order; if some arrive twice or never, no record is lost.
    `healthy` returns whether to send signs of life.
    """

    def __init__(
        self,
        send: Callable[[bytes], object],
        doorbell: EventDescriptor | None = None,
        healthy: Callable[[], bool] = lambda: True,
        *,
        relayed: bool = False,
    ) -> None:
        self._send = send
        self._healthy = healthy
        self._wake = EventDescriptor()
        self._moved = Moved((self._wake,) if doorbell is None else (self._wake, doorbell))
        self._sending = threading.Lock()  # over taking something to be sent, and sending it
        self._arrived = threading.Condition()
        self._turns = 0
        self._stopping = False
        self.quiet = False  # rings are moved with calls and answers, and their events are for others
        self._asked_ns = self._beaten_ns = self._watched_ns = 0
        self.heard_ns = time.monotonic_ns()
        self.clock = OtherClock()
        self.way = Way(relayed=relayed)
        self._unheard_ns = 0  # how long the other end had heard nothing, when it last said so
        self._thread = threading.Thread(target=self._run, name="canwire-network", daemon=True)

    def start(self) -> None:
        self._thread.start()

    def add(self, mirror: Mirror, *events: EventDescriptor) -> None:
        """Move this ring, too. The first of `events` is signalled when it changes here; all are closed with it."""
        if isinstance(mirror, Outgoing):
            mirror.belongs_to(self.way)
        self._moved.add(mirror, events)
        self.wake()

    def remove(self, numbers: tuple[int, ...]) -> None:
        """Stop moving these rings; unknown numbers are ignored."""
        for number in numbers:
            mirror, events = self._moved.remove(number)
            if mirror is not None:
                with self._sending, contextlib.suppress(OSError):
                    mirror.close()
                    for event in events:
                        event.close()

    @property
    def silent_ns(self) -> int:
        """How long either end has received nothing from the other one, to the knowledge of this end."""
        return max(time.monotonic_ns() - self.heard_ns, self._unheard_ns)

    def wake(self) -> None:
        """Wake the pump, as there may be something to send."""
        self._wake.signal()

    def holding_back(self) -> AbstractContextManager[object]:
        """A context during which nothing is sent."""
        return self._sending

    def flush(self) -> None:
        """Send all new records, and report those taken here, before the next call."""
        with self._sending:
            self._send_all(time.monotonic_ns(), at_once=True)

    def written(self) -> tuple[tuple[int, int], ...]:
        """The positions of the writers of outgoing rings."""
        return tuple((one.number, one.written) for one in self._moved.senders.values())

    def mirrors(self) -> tuple[Mirror, ...]:
        """All rings that are moved."""
        return self._moved.mirrors()

    def mirror(self, number: int) -> Mirror | None:
        """The ring of this number, if it is still moved."""
        return self._moved.mirror(number)

    def await_arrival(self, positions: tuple[tuple[int, int], ...], timeout: float) -> bool:
        """Wait until incoming rings have reached these positions; False after `timeout` seconds.

        Missing records are not requested: they may wait for room, and the other end reports what it has sent.
        """
        if self._have(positions):
            return True
        deadline = time.monotonic() + timeout
        with self._arrived:
            while not self._have(positions) and not self._stopping:
                left = deadline - time.monotonic()
                if left <= 0:
                    return False
                self._arrived.wait(left)
        return self._have(positions)

    def take(self, payload: bytes) -> None:
        """Accept a payload of the other end; raises BadMessage. Never waits."""
        self.heard_ns = time.monotonic_ns()
        kind = payload[0] if payload else 0
        if kind in wire.BATCHES:
            self._accept(payload)
        elif kind == wire.REPORTS:
            self._acknowledge(wire.reports_in(payload))
        elif kind == wire.STATES:
            self._compare(wire.states_in(payload))
        elif kind == wire.COUNTS:
            for count in wire.counts_in(payload):
                watched = self._moved.watched.get(count.ring)
                if watched is not None and watched.show(count):
                    self.wake()
        elif kind == wire.TOGETHER:
            for part in wire.parts_in(payload):
                self.take(part)
        else:
            raise BadMessage(f"a message of kind {kind}: 1 to 4, or {wire.TOGETHER} to {wire.SQUEEZED}")

    def close(self) -> None:
        """End, and release all rings; a second call does nothing."""
        if self._stopping:
            return
        self._stopping = True
        self._wake.signal()
        with self._arrived:
            self._arrived.notify_all()
        if self._thread.ident is not None and self._thread is not threading.current_thread():
            self._thread.join()
        self.remove(self._moved.numbers())
        self._moved.close()
        self._wake.close()

    # what comes

    def _accept(self, payload: bytes) -> None:
        number, first, records, stamp = wire.frames_in(payload)
        taker = self._moved.takers.get(number)
        if taker is None:
            return  # closed meanwhile, or not open yet: then it is asked for
        if isinstance(taker, Incoming):
            urgent = taker.accept(first, records, stamp, self.heard_ns)
        else:
            urgent = taker.accept(first, records)
        if urgent:
            self.wake()
        with self._arrived:
            self._arrived.notify_all()

    def _acknowledge(self, found: list[Report]) -> None:
        for report in found:
            sender = self._moved.senders.get(report.ring)
            if isinstance(sender, Outgoing):
                sender.acknowledge(report, self.heard_ns)
            elif sender is not None:
                sender.acknowledge(report)
            if sender is not None and sender.sent != sender.written:
                self.wake()
        if self.way.waits():  # there may be room now
            self.wake()

    def _compare(self, found: list[tuple[int, int]]) -> None:
        """The other end has sent so much."""
        for number, sent in found:
            if number == wire.SILENCE:
                self._unheard_ns = sent
            elif number == wire.CLOCK:
                self.clock.heard(sent, time.monotonic_ns())
            taker = self._moved.takers.get(number)
            if taker is not None:
                taker.sent(sent)
                self.wake()

    def _have(self, positions: tuple[tuple[int, int], ...]) -> bool:
        takers = self._moved.takers
        return all(
            taker.received >= position
            for number, position in positions
            if (taker := takers.get(number)) is not None
        )

    # the thread

    def _run(self) -> None:
        timeout = 0.0
        while not self._stopping:
            self._moved.wait(timeout)
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
        """Report the records taken here before sending others, so that the other end knows of the new room first."""
        left = True
        while left:
            left = False
            found: list[bytes] = []
            for one in self._in_turn():
                batches = one.batches(now_ns, at_once=at_once)
                found += batches
                left |= len(batches) >= FULL
            if found and self.way.asks:
                found.append(wire.states(self._unconfirmed()))
                self._asked_ns = now_ns
            for payload in wire.packed(self._news(now_ns, at_once=at_once or bool(found)) + found):
                self._send(payload)

    def _in_turn(self) -> list[Sender]:
        """Begin with another ring each time, so that one that is always full does not block the others."""
        found = list(self._moved.senders.values())
        self._turns += 1
        first = self._turns % (len(found) or 1)
        return found[first:] + found[:first]

    def _unconfirmed(self) -> list[tuple[int, int]]:
        return [(one.number, one.sent) for one in self._moved.senders.values() if one.unconfirmed]

    def _news(self, now_ns: int, *, at_once: bool) -> list[bytes]:
        """How far rings are that are copies here, and FIFOs that are only looked at."""
        reports = []
        for taker in self._moved.takers.values():
            made = taker.report(now_ns, at_once=at_once)
            if made is not None:
                reports.append(made)
        counts = [changed for one in self._moved.watched.values() if (changed := one.changed()) is not None]
        return ([wire.reports(reports)] if reports else []) + ([wire.counts(counts)] if counts else [])

    def _send_signs(self, now_ns: int) -> None:
        """That this end lives, and what it has sent, for the other one to find out what it misses."""
        beat = now_ns >= self._beaten_ns + HEARTBEAT_NS
        if not beat and now_ns < self._asked_ns + _ASK_NS:
            return
        sent = self._unconfirmed()
        if beat or sent:
            self._asked_ns = now_ns
            if self._healthy():
                silence = (wire.SILENCE, max(0, now_ns - self.heard_ns))
                self._send(wire.states(sent + [silence, (wire.CLOCK, time.monotonic_ns())] * beat))
                counts = [one.now() for one in self._moved.watched.values()] if beat else []
                if counts:
                    self._send(wire.counts(counts))
        if beat:
            self._beaten_ns = now_ns

    def _arm_all(self, now_ns: int) -> int:
        """Arm all events; returns when to check the rings again without a signal."""
        due_ns = now_ns + (_WATCH_NS if self._moved.watched else HEARTBEAT_NS)
        for taker in () if self.quiet else self._moved.takers.values():
            due_ns = min(due_ns, taker.arm(now_ns) or due_ns)
        for sender in self._moved.senders.values():
            if not self.quiet:
                due_ns = min(due_ns, sender.arm(now_ns) or due_ns)
            if sender.unconfirmed:
                due_ns = min(due_ns, self._asked_ns + _ASK_NS)
        return due_ns
