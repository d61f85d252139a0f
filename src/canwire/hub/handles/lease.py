"""The base class of leases, which a client has at its hub until it closes them, or until the client is gone."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING, Any, Self

from canwire.errors import Closed, HubLost
from canwire.hub.protocol import messages as m

if TYPE_CHECKING:
    from types import TracebackType

    from canwire.hub.handles.client import Client


class Lease:
    """A lease at the hub. It may be closed twice; a use after that raises Closed.

    A use raises Unplugged once its board was pulled out, and HubLost once the hub is gone.
    """

    def __init__(self, hub: Client, handle: int, name: str) -> None:
        self.hub = hub
        self.name = name
        self._handle = handle
        self._closed = False
        self._gone: Exception | None = None
        hub.adopt(self)

    @property
    def handle(self) -> int:
        return self._handle

    def check(self) -> None:
        """Raise an error if the lease is over."""
        if self._closed:
            raise Closed(self.name)
        if self._gone is not None:
            raise self._gone
        if self.hub.lost:
            raise HubLost(f"{self.name}: the hub is gone")

    @property
    def over(self) -> bool:
        """True if the lease has ended."""
        return self._closed or self._gone is not None or self.hub.lost

    def end(self, why: Exception) -> None:
        """For the hub: the other side has ended this lease; threads that wait on it wake up."""
        if self._gone is None:
            self._gone = why

    def leave_to_parent(self, why: Exception) -> None:
        """For a fork of this process: this lease is the parent's."""
        self._gone = why

    def close(self) -> None:
        if not self._closed:
            over, self._closed = self.over, True
            self.hub.forget(self)
            if not over:
                with contextlib.suppress(HubLost):  # then it is given back already
                    self.hub.call(m.Close(self._handle))

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<{self.name}, {self._state()}>"

    def _state(self) -> str:
        if self._closed:
            return "closed"
        if self._gone is not None:
            return str(self._gone)
        return "the hub is gone" if self.hub.lost else "open"

    def ask(self, request: m.Message) -> Any:
        """Ask the hub about this lease."""
        self.check()
        return self.hub.call(request)
