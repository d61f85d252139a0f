"""One client on the network, at the hub's end: it holds the client's leases, and copies its rings to the client.

For the hub it is a client like any other, with a separate link, so the rules for local programs apply to it.
"""

from __future__ import annotations

import contextlib
import itertools
import sys
import threading
import time
import traceback
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING

from canwire.errors import BadMessage, CanwireError, HubError, LimitReached
from canwire.hub.links.network import access, wire
from canwire.hub.links.network.calls import Answered, Asked, asked_in, encode, refused
from canwire.hub.links.network.cuts.late import Late
from canwire.hub.links.network.lockstep.places import Places
from canwire.hub.links.network.lockstep.stirs import IncomingStirs
from canwire.hub.links.network.mirrors import Outgoing
from canwire.hub.links.network.notes import OutgoingNotes
from canwire.hub.links.network.opening import Opened, filled, taken_over
from canwire.hub.links.network.pump import Pump
from canwire.hub.links.network.session.settings import TIMED_SILENCE_S
from canwire.hub.links.stream.client import StreamLink
from canwire.hub.protocol import messages as m
from canwire.hub.protocol.failure import failed

if TYPE_CHECKING:
    from canwire.hub.protocol.link import Answer, Link

CALLS = 64  # of one client that wait at a time
_CALL = bytes((wire.CALL,))
_ROOM = 1 << 14  # bytes of requests on their way to the hub, which its socket accepts without blocking
_ARRIVAL_S = 1.0  # what was sent before a call is waited for so long, in lockstep longer

Reply = Callable[[bytes], object]


class Guest:
    """`ask` accepts the bytes of a call from any thread, and does not wait; `send` sends payloads to the client."""

    def __init__(
        self,
        link: Link,
        user: str,
        may: str,
        send: Callable[[bytes], object],
        healthy: Callable[[], bool],
        age_s: float = 0.0,
        warn: Callable[[str], object] = lambda text: None,
        *,
        relayed: bool = False,
    ) -> None:
        self.user = user
        self.late = Late(age_s, warn)
        self._may = may
        self._reply: Reply = lambda answer: send(wire.answer(answer))
        self._link = link
        self._quick = link if isinstance(link, StreamLink) else None
        self._lock = threading.Lock()
        self._known: dict[
            int, list[Reply] | bytes
        ] = {}  # by serial: who waits for it, or what it was answered
        self._oldest = self._waiting = self._waiting_bytes = 0
        self._numbers = itertools.count(1)
        self._rings: dict[int, tuple[int, ...]] = {}  # by handle
        self._closed = False
        self._notes = OutgoingNotes()
        self.pump = Pump(send, healthy=healthy, relayed=relayed)
        self._places = Places(link, self.pump.mirror)
        self.pump.add(self._notes)
        self.pump.add(IncomingStirs(self._places.stir))
        self.pump.start()
        self._workers = ThreadPoolExecutor(CALLS, "canwire-guest")
        link.listen(self._notice)

    def take(self, payload: bytes) -> None:
        """Process a payload of the client; raises BadMessage. Never waits."""
        if payload[:1] == _CALL:
            self.ask(payload[1:], self._reply)
        else:
            self.pump.take(payload)

    @property
    def timed(self) -> bool:
        """True if its program takes part in lockstep, so that others wait for it."""
        return self._places.timed

    @property
    def silent_s(self) -> float:
        """Seconds since its last sign of life."""
        return (time.monotonic_ns() - self.pump.heard_ns) / 1e9

    def ask(self, payload: bytes, reply: Reply) -> None:
        """Carry out the call once, and answer each repetition of it; raises BadMessage."""
        asked = asked_in(payload)
        late = self.late.refusal(asked, time.monotonic_ns()) if asked.serial not in self._known else None
        if late is not None:
            reply(refused(payload, late))
            return
        with self._lock:
            self._oldest = max(self._oldest, asked.oldest)
            for serial in [serial for serial in self._known if serial < self._oldest]:
                if isinstance(self._known[serial], bytes):
                    del self._known[serial]
            known = self._known.get(asked.serial)
            if known is None and asked.serial < self._oldest:  # a repetition, slower than the call after it
                known = refused(payload, HubError("this call was answered already, or given up"))
            if isinstance(known, list):
                known.append(reply)
            elif known is None:
                self._known[asked.serial] = [reply]
                self._waiting += 1
                self._waiting_bytes += len(asked.request)
            crowded = self._waiting > CALLS
            roomy = self._waiting_bytes <= _ROOM
        if isinstance(known, bytes):
            reply(known)
        elif known is None and crowded:
            error = LimitReached(f"{CALLS} calls of this client wait for their answers; end one of them")
            self._answer(asked, failed(error))
        elif known is None and not self._begins(asked):
            if roomy and self._quick is not None and not self._places.timed:
                self._guarded(asked, partial(self._begin, asked, self._quick))
            else:
                self._leave_to_worker(asked)

    def close(self) -> None:
        """Release the client's leases; a second call does nothing."""
        if self._closed:
            return
        self._closed = True
        self.late.tell()
        self._link.close()  # calls that wait for an answer get HubLost
        self._places.lost()
        self._workers.shutdown(wait=True)
        self.pump.close()

    # what comes too late

    def _give_up(self, handle: int, count: int, age_s: float) -> None:
        """Frames: the channel's status counts them as refused."""
        self.late.frames(count, age_s)
        with contextlib.suppress(RuntimeError):  # closed this very moment
            self._workers.submit(self._count, handle, count)

    def _count(self, handle: int, count: int) -> None:
        with contextlib.suppress(CanwireError):  # the channel, or the hub, is gone, and its counts with it
            self._link.call(m.CountRefused(handle, count))

    # a call

    def _begins(self, asked: Asked) -> bool:
        """Begin a wait for a turn immediately if all data sent before it have arrived; else False: a worker does it."""
        if not self._places.timed or not self.pump.await_arrival(asked.positions, 0.0):
            return False
        try:
            serial, request = m.decode_request(asked.request)
            return serial == asked.serial and self._places.begins(
                asked, request, partial(self._answer, asked), may_wait=False
            )
        except BadMessage:
            return False  # and says so

    def _guarded(self, asked: Asked, work: Callable[[], object]) -> None:
        """An error is an answer, too."""
        try:
            work()
        except CanwireError as error:
            self._answer(asked, failed(error))
        except Exception as error:
            traceback.print_exc(file=sys.stderr)
            self._answer(asked, failed(HubError(f"the hub's network side failed at this request: {error!r}")))

    def _begin(self, asked: Asked, link: StreamLink) -> None:
        """Call the hub in this thread, and answer in the receiving one: each further thread costs a wake-up.

        It waits for nothing: what the client sent before has come, and the socket has room for `_ROOM` bytes.
        """
        if not self.pump.await_arrival(asked.positions, 0):
            self._leave_to_worker(asked)
            return
        request = self._checked(asked)
        if isinstance(request, m.JoinTime):
            self._leave_to_worker(asked)  # its place is held here
        elif request is not None:
            pending = link.begin(request)
            pending.when_settled(
                lambda: self._guarded(asked, lambda: self._pass_on(asked, request, pending.result()))
            )

    def _leave_to_worker(self, asked: Asked) -> None:
        with contextlib.suppress(RuntimeError):  # closed this very moment
            self._workers.submit(self._guarded, asked, partial(self._do, asked))

    def _checked(self, asked: Asked) -> m.Message | None:
        """The request to pass on; None if it is answered already. Raises BadMessage, HubError without the right."""
        serial, request = m.decode_request(asked.request)
        if isinstance(request, m.Hello):  # the answer to the first one was lost
            self._answer(asked, m.Welcome(m.VERSION, self._link.time))
            return None
        if serial != asked.serial:
            raise BadMessage(
                f"{type(request).__name__} with serial {serial} in a call with serial {asked.serial}"
            )
        access.check(self.user, self._may, request)
        return request

    def _do(self, asked: Asked) -> None:
        request = self._checked(asked)
        if request is None:
            return
        arrival_s = TIMED_SILENCE_S if self._places.timed else _ARRIVAL_S
        if not self.pump.await_arrival(asked.positions, arrival_s):
            raise HubError(
                "what was sent before this call did not arrive: the network loses too much; try again"
            )
        if self._places.begins(asked, request, partial(self._answer, asked), may_wait=True):
            return
        if isinstance(request, m.JoinTime):  # from now on all go by one time, which is not the clock's
            self.pump.quiet, self.late.age.limit_s = True, 0.0
        try:
            answer = self._places.call(asked, request)
        finally:
            self.pump.quiet = self._places.timed
        self._pass_on(asked, request, answer)

    def _pass_on(self, asked: Asked, request: m.Message, answer: Answer) -> None:
        """The hub's answer, and what it opened."""
        reply, descriptors = answer
        opened: list[Opened] = []
        try:
            told = self._places.signalled if self._places.timed else None
            opened = taken_over(
                request,
                reply,
                descriptors,
                self._link.doorbell,
                lambda: next(self._numbers),
                told,
                self.late.age,
                self._give_up,
            )
        except OSError as error:
            raise LimitReached(f"{type(request).__name__}: {error.strerror}") from error
        finally:
            if isinstance(request, m.Close) or opened:
                self._forget(getattr(request, "handle", 0))
        if opened:
            handle = reply.handle if isinstance(reply, m.FifoOpened) else getattr(request, "handle", 0)
            self._rings[handle] = tuple(one.mirror.number for one in opened)
        self._answer(asked, reply, opened)

    def _answer(self, asked: Asked, reply: m.Message, opened: Sequence[Opened] = ()) -> None:
        """Answer each repetition of the call, after everything that the client's queues hold by now."""
        rings = filled(opened)
        begun = tuple(
            (one.mirror.number, one.mirror.written) for one in opened if isinstance(one.mirror, Outgoing)
        )
        positions = self.pump.written() + begun
        self.pump.flush()
        taken = self._places.taken(self.pump.mirrors())
        body = m.encode_reply(asked.serial, reply)[m.LENGTH.size :]
        answer = encode(Answered(body, rings, positions, taken, time.monotonic_ns()))
        with self.pump.holding_back():  # records would reach the client before it knows their rings
            for mirror, events in opened:  # now: the client's next call may be about them
                self.pump.add(mirror, *events)
            with self._lock:
                waiting = self._known.get(asked.serial)
                self._known[asked.serial] = answer
                self._waiting -= 1
                self._waiting_bytes -= len(asked.request)
            for each in waiting if isinstance(waiting, list) else ():
                each(answer)

    def _forget(self, handle: int) -> None:
        self.pump.remove(self._rings.pop(handle, ()))

    def _notice(self, notice: m.Message | None) -> None:
        if notice is None:
            self._places.lost()
        else:
            self._notes.add(m.encode_reply(0, notice)[m.LENGTH.size :])
            self.pump.wake()
