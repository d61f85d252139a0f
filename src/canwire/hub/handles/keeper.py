"""How the threads of a program let a hub's virtual time pass (canwire.threads)."""

from __future__ import annotations

from typing import Any, Protocol

from canwire.hub.protocol import messages as m


class Called(Protocol):
    """What is needed of a client of the hub."""

    @property
    def lost(self) -> bool: ...
    def call(self, request: m.Message) -> Any: ...


class HubKeeper:
    """The virtual time of a hub in this process."""

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
