"""Clients of a hub whose connection is gone: each may return within a limited time."""

from __future__ import annotations

from canwire.hub.links.network.cuts.silence import was_cut


class Absent:
    """The absent clients, and until when each may return. No clock: times in s are arguments. Not thread-safe.

    A client may return for `grace_s` after its connection has ended, or for `cut_s` if `lease_s` of silence before
    show that the network was cut.
    """

    def __init__(self, lease_s: float, grace_s: float, cut_s: float) -> None:
        self._lease_s = lease_s
        self._grace_s = grace_s
        self._cut_s = cut_s
        self._until_s: dict[str, float] = {}

    def went(self, client: str, now_s: float, silent_ns: int) -> None:
        """Note that a client's connection ended; either end had received nothing from the other for `silent_ns`."""
        cut = was_cut(silent_ns, self._lease_s)
        self._until_s[client] = now_s + (self._cut_s if cut else self._grace_s)

    def came(self, client: str) -> None:
        """The client is back, or was dropped; unknown ones are ignored."""
        self._until_s.pop(client, None)

    def over(self, now_s: float) -> list[str]:
        """The clients that were away for too long."""
        return [client for client, until_s in self._until_s.items() if now_s >= until_s]

    def wait_s(self, now_s: float, most_s: float) -> float:
        """The time until the next client may be away for too long, `most_s` at most."""
        return max(0.0, min([most_s, *(until_s - now_s for until_s in self._until_s.values())]))

    def __bool__(self) -> bool:
        return bool(self._until_s)
