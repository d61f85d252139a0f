"""How the threads of a program let a hub's virtual time pass (canwire.threads)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from canwire.hub.protocol import messages as m

if TYPE_CHECKING:
    from canwire.hub.handles.timed import Timed


class Called(Protocol):
    """What is needed of a client of the hub."""

    @property
    def lost(self) -> bool: ...
    def call(self, request: m.Message) -> Any: ...


class HubKeeper:
    """The virtual time of a hub in this process, which nobody else has a part in."""

    alone = True

    def __init__(self, client: Called) -> None:
        self._client = client

    @property
    def lost(self) -> bool:
        return self._client.lost

    def now_ns(self) -> int:
        return int(self._client.call(m.Advance(0)).value)

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        """Until then, or until something is signalled; the time it is then."""
        return int(self._client.call(m.Advance(until_ns - now_ns)).value)

    def leave(self) -> None:
        """Nobody else is held up."""

    def rejoin(self) -> None:
        """See `leave`."""


class LockstepKeeper:
    """The one time of many programs, of whose turns this one's threads have one together."""

    alone = False

    def __init__(self, client: Called, timed: Timed) -> None:
        self.place = timed.share()
        self._connections = [(client, timed)]

    @property
    def lost(self) -> bool:
        return all(client.lost for client, _ in self._connections)

    def add(self, client: Called, timed: Timed) -> None:
        """Another connection of this program, which has joined at `place`."""
        self._connections = [pair for pair in self._connections if not pair[0].lost] + [(client, timed)]

    def now_ns(self) -> int:
        return self._timed().now_ns()

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        """Other programs run until then, or until something is signalled to this one."""
        return self._timed().await_turn(until_ns)

    def leave(self) -> None:
        """Time does not wait for this program."""
        if not self.lost:
            self._timed().leave()

    def rejoin(self) -> None:
        """At its turn the program continues."""
        if not self.lost:
            self._timed().join()

    def _timed(self) -> Timed:
        return next(
            (timed for client, timed in self._connections if not client.lost), self._connections[0][1]
        )
