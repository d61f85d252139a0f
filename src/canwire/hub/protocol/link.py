"""The interface between a client's handles and its hub, in this process or in another one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from canwire.hub.protocol.messages import Message
from canwire.platform import Descriptor, EventDescriptor

Answer = tuple[Any, tuple[Descriptor, ...]]
"""A reply and the descriptors that came with it; the caller that receives it owns them."""

Listener = Callable[[Message | None], None]
"""Called with every notice, and with None once the hub is gone."""


class Link(Protocol):
    """One client's connection.

    Any thread may use `call`. It raises what the hub raised. Once the hub is gone, it raises HubLost within 200 ms (2 s
    between machines), also in calls that are waiting. A separate thread of the link calls each listener for every
    notice; after the hub is gone, once more with None.
    """

    copies: bool  # rings here are copies of the hub's, which are elsewhere
    time: str  # "real", "fast" or "virtual"
    address: str  # of the socket, or on the network; "" in this process

    def call(self, request: Message) -> Answer:
        """Send a request and wait for the reply."""

    def listen(self, listener: Listener) -> None:
        """Pass on notices: BoardsChanged, Gone, None."""

    @property
    def lost(self) -> bool:
        """True once the hub is gone."""

    @property
    def doorbell(self) -> EventDescriptor:
        """The event that signals frames in this client's transmit queues to the hub; the link owns it."""

    def stir(self) -> None:
        """Make this program's threads check again what they wait for, without a lock and without waiting."""

    def close(self) -> None:
        """End all leases; a second call has no effect."""
