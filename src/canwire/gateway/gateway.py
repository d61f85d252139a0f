"""A gateway between two lines, of one hub or of two."""

from __future__ import annotations

import threading
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING

from canwire.errors import BadValue, Closed, HubError
from canwire.gateway.claim import Claim
from canwire.gateway.end import End
from canwire.gateway.rules import GatewayCounts, GatewayRules, Passage
from canwire.hub.connect import connect
from canwire.hub.finding import LinePlace
from canwire.hub.handles.event import Event

if TYPE_CHECKING:
    from canwire.hub.handles.hub import Hub

_AT_ONCE = 256
_LOOK_S = 0.5  # between two looks at what other gateways do
_PASS = GatewayRules()


class Gateway:
    """Passes frames on between two lines, from the moment it is made until it is closed.

    `line` and `other` are names of lines or buses of `hub` and `other_hub` (None: this user's hub, and the same one).
    The name of a bus selects an unused line on it, or a shared one if all are used. `there` are the rules from `line`
    to `other`, `back` those from `other` to `line`; None: no frames pass in that direction. A line that does not run
    is started at the bit rate of its bus, or at 500 kbit/s if the bus has none. Frames that a gateway has sent are not
    passed back. A gateway that closes a ring, over any number of hubs, is refused. If several start at the same time,
    the youngest ends, and `wait` raises the reason.

    ::

        with Gateway("can0", "can1", there=GatewayRules(ids={0x100: 0x200}), back=None) as gateway:
            gateway.wait(10)
            print(gateway.there)

    Raises NoSuchBoard, BadValue (a ring, or both lines on one bus), HubError, and any error of starting a line.
    """

    def __init__(
        self,
        line: str | LinePlace,
        other: str | LinePlace,
        *,
        there: GatewayRules | None = _PASS,
        back: GatewayRules | None = _PASS,
        hub: Hub | None = None,
        other_hub: Hub | None = None,
    ) -> None:
        if there is None and back is None:
            raise BadValue("a gateway needs rules for one direction at least")
        self._closing = ExitStack()
        self._failure: BaseException | None = None
        self._over = Event(manual_reset=True)
        try:
            first = hub or self._closing.enter_context(connect(name="gateway"))
            second = other_hub or first
            self._ends = ends = [End(first, line), End(second, other)]
            self._claimed = self._claim(ends, there is not None, back is not None)
            for end in ends:
                end.open(self._closing)
            self._there = Passage(there or _PASS, ends[1].fd)
            self._back = Passage(back or _PASS, ends[0].fd)
            self.name = f"{ends[0].place.address} and {ends[1].place.address}"
            ways = [(ends[0], ends[1], self._there)] * (there is not None)
            ways += [(ends[1], ends[0], self._back)] * (back is not None)
            self._threads = [threading.Thread(target=self._carry, args=way, daemon=True) for way in ways]
            self._looking = threading.Thread(target=self._look_out, daemon=True)
        except BaseException:
            self._closing.close()
            raise
        for thread in (*self._threads, self._looking):
            thread.start()

    @property
    def there(self) -> GatewayCounts:
        """The current counts of frames from `line` to `other`."""
        return self._ends[1].account(self._there.counts)

    @property
    def back(self) -> GatewayCounts:
        """The current counts of frames from `other` to `line`."""
        return self._ends[0].account(self._back.counts)

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait until the gateway has ended; False if `timeout_s` is over before. Raises what ended it, as HubLost."""
        over = self._over.wait(timeout_s)
        if self._failure is not None:
            raise self._failure
        return over

    def close(self) -> None:
        """Stop passing frames; those that still wait count as given up. Closing twice is harmless."""
        self._over.set()
        self._looking.join()  # otherwise it could leave notes that are never removed
        for end, passage in zip(self._ends, (self._back, self._there), strict=True):
            end.account(passage.counts, over=True)
        self._closing.close()
        for thread in self._threads:
            if thread is not threading.current_thread():
                thread.join()

    def __enter__(self) -> Gateway:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        state = "over" if self._over.is_set() else "running"
        return f"<gateway between {self.name}, {state}: there {self.there}; back {self.back}>"

    def _claim(self, ends: list[End], there: bool, back: bool) -> Claim:
        """Write the notes that other gateways read; refuse a ring."""
        source, target = (end.known_as() for end in ends)
        if source == target:
            raise BadValue(f"both lines are on {ends[0].bus}: a gateway joins two buses")
        claim = Claim(((ends[0].hub, source), (ends[1].hub, target)), there, back)
        self._closing.callback(claim.give_up)
        claim.stake()
        return claim

    def _look_out(self) -> None:
        """Check for rings that other gateways have closed meanwhile together with this one."""
        while not self._over.wait(_LOOK_S):
            try:
                self._claimed.look()
            except (
                Closed,
                HubError,
            ):  # the threads that carry frames report it, unless the network is back before
                continue
            except Exception as error:  # `wait` raises it
                self._failure = error
                self._over.set()

    def _carry(self, source: End, target: End, passage: Passage) -> None:
        try:
            while not self._over.is_set():
                _pass_on(source, target, passage)
        except Closed as error:
            if not self._over.is_set():
                self._failure = error
        except Exception as error:  # the function that changes frames is the user's; `wait` raises its error
            self._failure = error
        self._over.set()


def _pass_on(source: End, target: End, passage: Passage) -> None:
    """Pass on the waiting frames, or the next one. Raises Closed once the gateway is closed."""
    frames = source.channel.receive_many(_AT_ONCE, None)
    counts = passage.counts
    for frame in frames:
        new = passage.through(frame)
        if new is None:
            continue
        if target.channel.writing.ring.free():
            target.channel.send(new)
            counts.passed += 1
        else:
            counts.lost += 1
    if len(frames) == _AT_ONCE:  # behind: some may have found no room
        lost = source.newly_lost()
        counts.heard += lost
        counts.lost += lost
