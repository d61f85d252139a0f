"""A program's side of a link: calls, time, and everything it holds at the hub. It knows no kind of what is held."""

from __future__ import annotations

import contextlib
import os
import threading
import time
import weakref
from collections.abc import Callable, Coroutine, Iterator
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar

from canwire.boards.can.modes import LineStatus
from canwire.errors import CanwireError, HubLost, Unplugged
from canwire.hub.protocol import messages as m
from canwire.values.checks import LONGEST_NS, nanoseconds

if TYPE_CHECKING:
    from types import TracebackType

    from canwire.hub.handles.timed import Timed
    from canwire.hub.protocol.link import Answer, Link


Result = TypeVar("Result")


class Holding(Protocol):
    """Something held at the hub: hub/handles/lease.py's leases."""

    name: str

    @property
    def handle(self) -> int:
        """What the hub calls it."""

    def end(self, why: Exception) -> None:
        """The hub has ended it, or is gone itself."""

    def leave_to_parent(self, why: Exception) -> None:
        """This process is a fork of the one that holds it: touch nothing that both of them have."""

    def close(self) -> None:
        """Give it back; a second time does nothing."""


class Client:
    """What leases need of their hub. Calls may come from any thread; once the hub is gone they raise HubLost."""

    def __init__(self, link: Link) -> None:
        self._closed = False
        self._link = link
        self._lock = threading.Lock()
        self._holdings: dict[int, Holding] = {}
        self._forked = False
        self._timed: Timed | None = None
        self.doorbell = link.doorbell
        self._listen(self._notice)
        _OPEN.add(self)
        self._forgotten = weakref.finalize(self, _close_elsewhere, link)
        self._forgotten.atexit = False

    @property
    def address(self) -> str:
        """Of the socket; "" for a hub in this process."""
        return self._link.address

    @property
    def time(self) -> str:
        """How it passes: "real" with the clock, "fast" as quickly as buses work, "virtual" while somebody waits,
        "lockstep" while all programs wait that take part."""
        return self._link.time

    @property
    def virtual(self) -> bool:
        """Waiting here takes virtual time."""
        return self._timed is not None or self._link.time == "virtual"

    @property
    def timed(self) -> bool:
        """This program keeps one time with others."""
        return self._timed is not None

    @property
    def copies(self) -> bool:
        """Rings here are copies of the hub's: what is at their other ends is told by the hub's."""
        return self._link.copies

    def keep_time(self, name: str) -> None:
        """Take part in a lockstep hub's time, in the place of this name; waits for this thread's first turn.

        Raises WrongState for a hub whose time passes otherwise.
        """
        from canwire.hub.handles.timed import Timed

        self._timed = Timed(self, name, self._link.stir)

    @property
    def lost(self) -> bool:
        """The hub is gone, this connection was closed, or it is that of the process that forked this one."""
        return self._closed or self._forked or self._link.lost

    def _listen(self, listener: Callable[[m.Message | None], None]) -> None:
        """Pass notices on to a method of something that this client belongs to, which they do not keep alive."""
        method = weakref.WeakMethod(listener)

        def tell(notice: m.Message | None) -> None:
            if (found := method()) is not None:
                found(notice)

        self._link.listen(tell)

    # calls

    def ask(self, request: m.Message) -> Answer:
        """A reply and its descriptors; raises what the hub raised."""
        if self._forked:
            raise CanwireError(_FORKED)
        if self._closed:
            raise HubLost("this connection to the hub was closed")
        if self._timed is not None:
            self._timed.forget_now()
        return self._link.call(request)

    def call(self, request: m.Message) -> Any:
        """The reply of a request whose answer has no descriptors."""
        return self.ask(request)[0]

    def line_status(self, board: int, line: int, *, kin: str = "") -> LineStatus:
        """A CAN line now, its mode as programs of the interface `kin` see it; raises Unsupported for a LIN line."""
        status: LineStatus = self.call(m.GetLineStatus(board, line, kin)).status
        return status

    def lin_status(self, board: int, line: int) -> m.LinLineState:
        """A LIN line as it is now, and who holds what on it; raises Unsupported for a CAN line."""
        state: m.LinLineState = self.call(m.GetLinStatus(board, line))
        return state

    # time

    def now_ns(self) -> int:
        """The hub's time."""
        if self._timed is not None:
            return self._timed.now_ns()
        return int(self.call(m.Advance(0)).value)

    def clock_s(self) -> float:
        """Seconds on the clock that waiting goes by: the hub's where its time is virtual, else this computer's."""
        return self.now_ns() / 1e9 if self.virtual else time.monotonic()

    def sleep(self, seconds: float) -> None:
        """Do nothing for so many seconds of the hub's time; where that is not virtual, of the clock."""
        if self._timed is not None:
            self._timed.sleep(seconds)
        elif self.virtual:
            self.run_for(seconds)
        else:
            time.sleep(nanoseconds("seconds", seconds) / 1e9)

    @contextlib.contextmanager
    def away(self) -> Iterator[None]:
        """For what takes time that is not the hub's: joining a thread, a file, a user. Its time passes meanwhile.

        A program that keeps one time with others takes part in it again afterwards, at its turn.
        """
        if self._timed is None:
            yield
            return
        self._timed.leave()
        try:
            yield
        finally:
            self._timed.join()

    def run(self, main: Coroutine[Any, Any, Result]) -> Result:
        """`asyncio.run(main)` in the hub's time where that is virtual: asyncio.sleep, timeouts and loop.time() too.

        Tasks wait for events and buses by their `fileno()` (loop.add_reader, python-can's Notifier with a loop).
        """
        import asyncio

        if not self.virtual:
            return asyncio.run(main)
        from canwire.hub.handles.event_loop import run

        return run(self, main)

    def time_state(self) -> m.TimeState:
        """The time, who takes part in it, and why it does not pass, if anybody should know."""
        state: m.TimeState = self.call(m.GetTime())
        return state

    def run_for(self, seconds: float) -> None:
        """Virtual time: let so much of it pass."""
        self.advance(lambda: False, seconds)

    def advance(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Virtual time: let it pass until `ready()` or until `timeout` seconds of it are over; was it ready?"""
        if self._timed is not None:
            return self._timed.advance(ready, timeout)
        now_ns = self.now_ns()
        end_ns = now_ns + (LONGEST_NS if timeout is None else nanoseconds("timeout", timeout))
        while not ready() and now_ns < end_ns:
            now_ns = int(self.call(m.Advance(end_ns - now_ns)).value)
        return ready()

    def wait_once(self, timeout: float | None) -> None:
        """One time with others: until anything is signalled to this program, at most `timeout` seconds of it."""
        if self._timed is not None:
            self._timed.wait_once(timeout)

    def stir(self) -> None:
        """Have this program's own threads look again at what they wait for; from anywhere, signal handlers too."""
        if self._timed is not None:
            self._timed.stir()

    def stir_everybody(self) -> None:
        """Something changed, without the hub, that other programs may wait for."""
        if self._timed is not None:
            self._timed.stir_everybody()

    # what is held

    def adopt(self, holding: Holding) -> None:
        """For leases: tell it when it ends, and close it with this."""
        with self._lock:
            self._holdings[holding.handle] = holding

    def forget(self, holding: Holding) -> None:
        """For leases: it was closed."""
        with self._lock:
            self._holdings.pop(holding.handle, None)

    def close(self) -> None:
        """Give back everything; a second time does nothing."""
        if not self._closed:
            for holding in self._held():
                with contextlib.suppress(HubLost, Unplugged):
                    holding.close()
            self._closed = True
            self._forgotten.detach()
            self._link.close()
            if self._timed is not None:
                self._timed.lost()

    def leave_to_parent(self) -> None:
        """For a fork of this process: every handle says so from now on, and takes nothing out of the parent's queues.

        Without locks: the threads that may have held them are not here.
        """
        self._forked = True
        self._lock = threading.Lock()
        for holding in list(self._holdings.values()):
            holding.leave_to_parent(CanwireError(f"{holding.name}: {_FORKED}"))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        where = self.address or "in this process"
        return f"<hub {where}, {self.time} time{', lost' if self.lost else ''}>"

    def _held(self) -> list[Holding]:
        with self._lock:
            return list(self._holdings.values())

    def _notice(self, notice: m.Message | None) -> None:
        if notice is None and self._timed is not None:
            self._timed.lost()
        if isinstance(notice, m.Gone):
            for holding in self._held():
                if holding.handle in notice.handles:
                    holding.end(Unplugged(notice.text))
        elif notice is None:
            for holding in self._held():
                holding.end(HubLost(f"{holding.name}: the hub is gone"))


def _close_elsewhere(link: Link) -> None:
    """A client was forgotten. The collector may have come by in any thread, even the hub's: another one hangs up."""
    with contextlib.suppress(RuntimeError):  # the interpreter is on its way out, and starts no threads
        threading.Thread(target=link.close, name="canwire-forgotten", daemon=True).start()


_FORKED = "this connection belongs to the process that was forked; connect again in this one"
_OPEN: weakref.WeakSet[Client] = weakref.WeakSet()


def _after_fork() -> None:
    for client in list(_OPEN):
        client.leave_to_parent()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
