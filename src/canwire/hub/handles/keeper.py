"""Lets the threads of a program make a hub's virtual time pass (canwire.threads)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

from canwire.hub.protocol import messages as m

if TYPE_CHECKING:
    from canwire.hub.handles.timed import Timed


class Called(Protocol):
    """The methods of a client of the hub that a keeper uses."""

    @property
    def lost(self) -> bool: ...
    def call(self, request: m.Message) -> Any: ...


class HubKeeper:
    """The virtual time of a hub in this process, which no other program shares."""

    alone = True

    def __init__(self, client: Called) -> None:
        self._client = client

    @property
    def lost(self) -> bool:
        return self._client.lost

    def now_ns(self) -> int:
        return int(self._client.call(m.Advance(0)).value)

    def pass_time(self, now_ns: int, until_ns: int) -> int:
        """Let time pass until then, or until a signal; returns the new time."""
        return int(self._client.call(m.Advance(until_ns - now_ns)).value)

    def leave(self) -> None:
        """Nothing: no other program waits for this one."""

    def rejoin(self) -> None:
        """See `leave`."""


class LockstepKeeper:
    """Lockstep time: the threads of this program share one place in the order of turns."""

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
        """Let other programs run until then, or until a signal to this program."""
        return self._timed().await_turn(until_ns)

    def leave(self) -> None:
        """Time does not wait for this program."""
        if not self.lost:
            self._timed().leave()

    def rejoin(self) -> None:
        """Take part again; the program continues at its turn."""
        if not self.lost:
            self._timed().join()

    def _timed(self) -> Timed:
        return next(
            (timed for client, timed in self._connections if not client.lost), self._connections[0][1]
        )
