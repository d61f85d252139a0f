"""A program's side of a link: calls, time, and everything it holds at the hub. It knows no kind of what is held."""

from __future__ import annotations

import contextlib
import os
import sys
import threading
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol, Self

from canwire.boards.can.modes import LineStatus
from canwire.errors import CanwireError, HubLost, Unplugged
from canwire.hub.protocol import messages as m
from canwire.platform import EventDescriptor
from canwire.values.checks import LONGEST_NS, nanoseconds

if TYPE_CHECKING:
    from types import TracebackType

    from canwire.hub.protocol.link import Answer, Link, Listener


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
        self._closed = True  # until there is something to close
        self._link = link
        self._lock = threading.Lock()
        self._holdings: dict[int, Holding] = {}
        self._forked = False
        self.doorbell = EventDescriptor.adopt(link.doorbell)
        self._closed = False
        link.listen(weakly(self._notice))
        _OPEN.add(self)

    def __del__(self) -> None:
        """Nobody holds it any more, nor anything of it: it is given back, by a thread that may wait for the hub."""
        if not getattr(self, "_closed", True) and not self._forked and not sys.is_finalizing():
            with contextlib.suppress(
                RuntimeError
            ):  # no thread can be had: the process ends, or has none left
                threading.Thread(target=self.close, name="canwire gives back", daemon=True).start()

    @property
    def address(self) -> str:
        """Of the socket; "" for a hub in this process."""
        return self._link.address

    @property
    def time(self) -> str:
        """How it passes: "real" with the clock, "fast" as quickly as buses work, "virtual" while somebody waits."""
        return self._link.time

    @property
    def virtual(self) -> bool:
        return self._link.time == "virtual"

    @property
    def lost(self) -> bool:
        """The hub is gone, this connection was closed, or it is that of the process that forked this one."""
        return self._closed or self._forked or self._link.lost

    # calls

    def ask(self, request: m.Message) -> Answer:
        """A reply and its descriptors; raises what the hub raised."""
        if self._forked:
            raise CanwireError(_FORKED)
        if self._closed:
            raise HubLost("this connection to the hub was closed")
        return self._link.call(request)

    def call(self, request: m.Message) -> Any:
        """The reply of a request whose answer has no descriptors."""
        return self.ask(request)[0]

    def line_status(self, board: int, line: int) -> LineStatus:
        """A CAN line as it is now, and who holds its control; raises Unsupported for a LIN line."""
        status: LineStatus = self.call(m.GetLineStatus(board, line)).status
        return status

    def lin_status(self, board: int, line: int) -> m.LinLineState:
        """A LIN line as it is now, and who holds what on it; raises Unsupported for a CAN line."""
        state: m.LinLineState = self.call(m.GetLinStatus(board, line))
        return state

    # time

    def now_ns(self) -> int:
        """The hub's time."""
        return int(self.call(m.Advance(0)).value)

    def run_for(self, seconds: float) -> None:
        """Virtual time: let so much of it pass."""
        self.advance(lambda: False, seconds)

    def advance(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Virtual time: let it pass until `ready()` or until `timeout` seconds of it are over; was it ready?"""
        now_ns = self.now_ns()
        end_ns = now_ns + (LONGEST_NS if timeout is None else nanoseconds("timeout", timeout))
        while not ready() and now_ns < end_ns:
            now_ns = int(self.call(m.Advance(end_ns - now_ns)).value)
        return ready()

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
            self.doorbell.leave()
            self._link.close()

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
        if isinstance(notice, m.Gone):
            for holding in self._held():
                if holding.handle in notice.handles:
                    holding.end(Unplugged(notice.text))
        elif notice is None:
            for holding in self._held():
                holding.end(HubLost(f"{holding.name}: the hub is gone"))


def weakly(method: Listener) -> Listener:
    """For a link, which must not keep who listens when nobody else holds that any more."""
    found = weakref.WeakMethod(method)

    def heard(notice: m.Message | None) -> None:
        listener = found()
        if listener is not None:
            listener(notice)

    return heard


_FORKED = "this connection belongs to the process that was forked; connect again in this one"
_OPEN: weakref.WeakSet[Client] = weakref.WeakSet()


def _after_fork() -> None:
    for client in list(_OPEN):
        client.leave_to_parent()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
