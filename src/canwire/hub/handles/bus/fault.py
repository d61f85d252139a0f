"""A fault that a program has set on a bus of its hub."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.hub.handles.lease import Lease
from canwire.hub.protocol import messages as m
from canwire.values.checks import nanoseconds

if TYPE_CHECKING:
    from canwire.hub.handles.client import Client
    from canwire.hub.protocol.fault_messages import FaultInfo


class HubFault(Lease):
    """A fault ends after all its times or after its time, at `cancel`, and with this connection to the hub.

    A persistent fault outlives the connection, and stays until a program clears it.
    """

    def __init__(self, hub: Client, handle: int, bus: str) -> None:
        super().__init__(hub, handle, f"fault on {bus}")
        self._last: FaultInfo | None = None

    def info(self) -> FaultInfo:
        """The fault and its effects so far; after `cancel`, its effects up to then."""
        return self._last or self._told(m.GetFault(self._handle))

    @property
    def struck(self) -> int:
        """How many times the fault has occurred."""
        return self.info().struck

    @property
    def times_left(self) -> int | None:
        """How many more times the fault will occur; 0 when it is over, None: no limit."""
        return self.info().times_left

    def wait(self, timeout: float | None = None) -> bool:
        """Wait until the fault is over, at most `timeout` seconds of the hub's time (None: no limit); True if it is.

        In virtual time, waiting lets that time pass.
        """
        span_ns = None if timeout is None else nanoseconds("timeout", timeout)
        if self._last is not None:
            return True
        return bool(self._told(m.AwaitFault(self._handle, span_ns)).over)

    def cancel(self) -> None:
        """Remove the fault, even a persistent one; a second call has no effect."""
        if self._last is None:
            self._last = self._told(m.CancelFault(self._handle))
            self.close()

    def __repr__(self) -> str:
        return f"<{self.name}{': ' + self._last.text if self._last else ''}>"

    def _told(self, request: m.Message) -> FaultInfo:
        info: FaultInfo = self.ask(request).info
        return info
