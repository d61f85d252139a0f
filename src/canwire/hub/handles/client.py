"""A program's side of a link: calls, time, and leases. This file knows no concrete kind of lease."""

from __future__ import annotations

import contextlib
import threading
import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol, Self

from canwire.boards.can.modes import LineStatus
from canwire.errors import CanwireError, HubLost, Unplugged
from canwire.forks import hear_of_forks
from canwire.hub.handles.client_time import ClientTime
from canwire.hub.handles.lent import LentMemory
from canwire.hub.protocol import messages as m
from canwire.platform import Descriptor

if TYPE_CHECKING:
    from types import TracebackType

    from canwire.hub.protocol.link import Answer, Link


class Holding(Protocol):
    """The methods of a lease (hub/handles/lease.py) that a client uses."""

    name: str

    @property
    def handle(self) -> int:
        """The hub's number for this lease."""

    def end(self, why: Exception) -> None:
        """The hub has ended this lease, or is gone."""

    def leave_to_parent(self, why: Exception) -> None:
        """Called in a fork of the lease's process: touch nothing that both processes share."""

    def close(self) -> None:
        """End the lease; a second call has no effect."""


class Client(ClientTime):
    """The part of a connection that leases use. Any thread may call; once the hub is gone, calls raise HubLost.

    `lends`: ends of queues that are set up from now on may be lent to another process (RingEnd.lend).
    """

    lends = False

    def __init__(self, link: Link) -> None:
        super().__init__(link)
        self._closed = False
        self._lock = threading.Lock()
        self._holdings: dict[int, Holding] = {}
        self._forked = False
        self._listen(self._notice)
        hear_of_forks(self)
        self._forgotten = weakref.finalize(self, _close_elsewhere, link)
        self._forgotten.atexit = False

    @property
    def address(self) -> str:
        """The address of the hub's socket; "" for a hub in this process."""
        return self._link.address

    @property
    def copies(self) -> bool:
        """True if rings here are copies: only the hub's rings then show the state of the other ends."""
        return self._link.copies

    @property
    def lost(self) -> bool:
        """True if the hub is gone, if this connection was closed, or if it belongs to the parent of this fork."""
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
        """The reply to a request and its descriptors; raises what the hub raised."""
        if self._forked:
            raise CanwireError(_FORKED)
        if self._closed:
            raise HubLost("this connection to the hub was closed")
        if self._timed is not None:
            self._timed.forget_now()
        if self.company is not None:
            return self.company.outside(self._link.call, request)
        return self._link.call(request)

    def call(self, request: m.Message) -> Any:
        """The reply to a request, for requests without descriptors in the reply."""
        return self.ask(request)[0]

    def line_status(self, board: int, line: int, *, kin: str = "") -> LineStatus:
        """The present status of a CAN line, as programs of the interface `kin` see it; Unsupported for a LIN line."""
        status: LineStatus = self.call(m.GetLineStatus(board, line, kin)).status
        return status

    def lin_status(self, board: int, line: int) -> m.LinLineState:
        """The present status of a LIN line, with the holders of its leases; raises Unsupported for a CAN line."""
        state: m.LinLineState = self.call(m.GetLinStatus(board, line))
        return state

    # what is held

    def adopt(self, holding: Holding) -> None:
        """For leases: call `end` of this lease when the hub ends it, and close it with this connection."""
        with self._lock:
            self._holdings[holding.handle] = holding

    def lent(self, memory: Descriptor) -> LentMemory | None:
        """For leases: an object that keeps the memory of their rings for a process that borrows them."""
        return LentMemory(memory) if self.lends else None

    def forget(self, holding: Holding) -> None:
        """For leases: this lease was closed."""
        with self._lock:
            self._holdings.pop(holding.handle, None)

    def close(self) -> None:
        """End all leases and the connection; a second call has no effect."""
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
        """For a fork of this process: every handle raises from now on, and reads nothing from the parent's queues.

        It uses no locks, since threads that may have held them do not exist here.
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
    """Close the link of a client without references in a new thread: the collector may run in any, even the hub's."""
    with contextlib.suppress(RuntimeError):  # the interpreter is on its way out, and starts no threads
        threading.Thread(target=link.close, name="canwire-forgotten", daemon=True).start()


_FORKED = "this connection belongs to the process that was forked; connect again in this one"
