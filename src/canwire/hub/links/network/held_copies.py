"""The copies of rings of a client, by the handle that they belong to."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from canwire.hub.links.network.opening import Copies, Filled, copied
from canwire.hub.owner.limits import enough
from canwire.hub.protocol import messages as m

if TYPE_CHECKING:
    from canwire.hub.links.network.pump import Pump
    from canwire.platform import EventDescriptor


class HeldCopies:
    """Kept until their handle is closed or opens others."""

    def __init__(self, pump: Pump, doorbell: EventDescriptor) -> None:
        self._pump = pump
        self._doorbell = doorbell
        self._lock = threading.Lock()
        self._copies: dict[int, Copies] = {}

    def adopt(self, request: m.Message, reply: m.Message, rings: Filled) -> tuple[int, ...]:
        """Make copies of the rings that a reply opened, in place of those of its handle.

        Returns descriptors for the program. Raises LimitReached.
        """
        with enough(type(request).__name__):
            copies = copied(request, reply, rings, self._doorbell, self._pump.clock)
        if not (isinstance(request, m.Close) or copies.opened):
            return ()
        handle = reply.handle if isinstance(reply, m.FifoOpened) else getattr(request, "handle", 0)
        with self._lock:
            before = self._copies.pop(handle, None)
            if copies.opened:
                self._copies[handle] = copies
        for mirror, events in copies.opened:
            self._pump.add(mirror, *events)
        if before is not None:
            self._pump.remove(tuple(one.mirror.number for one in before.opened))
            before.let_go()
        return copies.descriptors

    def close(self) -> None:
        """Release all copies; the pump must have ended."""
        with self._lock:
            found, self._copies = list(self._copies.values()), {}
        for copies in found:
            copies.let_go()
