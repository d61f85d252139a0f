"""A program's side of a link: calls, time, and everything it holds at the hub. It knows no kind of what is held."""

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


class Client(ClientTime):
    """What leases need of their hub. Calls may come from any thread; once the hub is gone they raise HubLost.

    `lends`: the ends of queues that are set up from now on may be lent to another process (RingEnd.lend).
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
        """Of the socket; "" for a hub in this process."""
        return self._link.address

    @property
    def copies(self) -> bool:
        """Rings here are copies of the hub's, and only the hub's show the state of the other ends."""
        return self._link.copies

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
        if self.company is not None:
            return self.company.outside(self._link.call, request)
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

    # what is held

    def adopt(self, holding: Holding) -> None:
        """For leases: tell it when it ends, and close it with this."""
        with self._lock:
            self._holdings[holding.handle] = holding

    def lent(self, memory: Descriptor) -> LentMemory | None:
        """For leases: what keeps the memory of their rings for a process that they are lent to."""
        return LentMemory(memory) if self.lends else None

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
