"""A connection for udsoncan's client in the lab: ISO-TP on a node, with timeouts in the lab's time."""

from __future__ import annotations

import isotp
from udsoncan.connections import BaseConnection
from udsoncan.exceptions import TimeoutException

from canwire import LabNode
from canwire.ecus.transport import LabIsoTp


class UdsConnection(BaseConnection):
    """A connection for `udsoncan.client.Client`: `node` sends requests with identifier `request` and receives
    `response`.

    Times of the client (P2, P2*) pass in the lab; its overall `request_timeout` counts the wall clock's time.
    """

    def __init__(self, node: LabNode, request: int = 0x7E0, response: int = 0x7E8) -> None:
        super().__init__(node.name)
        normal = isotp.AddressingMode.Normal_11bits
        self.transport = LabIsoTp(node, isotp.Address(normal, txid=request, rxid=response))
        self._opened = False

    def open(self) -> UdsConnection:
        self._opened = True
        return self

    def close(self) -> None:
        """Close; the node stays on its bus."""
        self.transport.reset()
        self._opened = False

    def is_open(self) -> bool:
        return self._opened

    def specific_send(self, payload: bytes, timeout: float | None = None) -> None:
        """Queue a request; it is sent while the client waits for the answer."""
        self.transport.send(payload)

    def specific_wait_frame(self, timeout: float | None = None) -> bytes | None:
        """The next message; raises udsoncan's TimeoutException after `timeout` seconds of the lab's time."""
        message = self.transport.receive(5.0 if timeout is None else timeout)
        if message is None:
            raise TimeoutException("no answer in time")  # type: ignore[no-untyped-call]
        return message

    def empty_rxqueue(self) -> None:
        """Discard messages that were not requested."""
        while self.transport.receive() is not None:
            pass

    def __enter__(self) -> UdsConnection:
        return self.open()

    def __exit__(self, *_: object) -> None:
        self.close()
