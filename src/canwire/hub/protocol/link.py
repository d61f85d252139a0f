"""The seam between a client's handles and its hub: in this process or behind a socket."""

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

    `call` may be used from any thread; it raises what the hub raised, or HubLost once the hub is gone, within
    200 ms (2 s between machines) and for calls that wait too. Notices come on a thread of the link's own, each
    listener is called for every one; after the hub is gone, once more with None.
    """

    copies: bool  # rings here are copies of the hub's, which are elsewhere
    time: str  # "real", "fast" or "virtual"
    address: str  # of the socket, or on the network; "" in this process

    def call(self, request: Message) -> Answer:
        """Ask and wait for the answer."""

    def listen(self, listener: Listener) -> None:
        """Pass on notices: BoardsChanged, Gone, None."""

    @property
    def lost(self) -> bool:
        """The hub is gone."""

    @property
    def doorbell(self) -> EventDescriptor:
        """What tells the hub of frames in this client's transmit queues; the link keeps it."""

    def stir(self) -> None:
        """Have this program's threads look again at what they wait for; without a lock and without waiting."""

    def close(self) -> None:
        """Give back everything held; a second time does nothing."""
