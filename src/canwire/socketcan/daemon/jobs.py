"""The BCM mode of a client: frames that are sent periodically, and identifiers that are watched."""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import BadText
from canwire.socketcan.bcm.message import RX_CHANGED, RX_DELETE, RX_SETUP, TX_DELETE, Message
from canwire.socketcan.bcm.sending import Sending
from canwire.socketcan.bcm.watching import Watching
from canwire.socketcan.daemon.words import heard

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire.socketcan.loop import Loop


class Jobs:
    """`put` sends a frame, `tell` sends a text to the client."""

    def __init__(self, loop: Loop, put: Callable[[bytes], object], tell: Callable[[str], object]) -> None:
        self._loop = loop
        self._put = put
        self._tell = tell
        self._sendings: dict[int, Sending] = {}
        self.watchings: dict[int, Watching] = {}

    def manage(self, message: Message) -> None:
        """Execute a request other than TX_SEND. Raises BadText if the job does not exist."""
        can_id = message.can_id
        if message.opcode == TX_DELETE and can_id in self._sendings:
            self._sendings.pop(can_id).stop()
        elif message.opcode == RX_DELETE and can_id in self.watchings:
            self.watchings.pop(can_id).stop()
        elif message.opcode in (TX_DELETE, RX_DELETE):
            raise BadText("there is no such job")
        elif message.opcode == RX_SETUP:
            if can_id in self.watchings:
                self.watchings.pop(can_id).stop()
            self.watchings[can_id] = Watching(self._loop, lambda _: None, self._changed, message)
        elif can_id in self._sendings:
            self._sendings[can_id].change(message)
        elif not message.flags:
            raise BadText("there is no such job")
        else:
            self._sendings[can_id] = Sending(self._loop, self._put, lambda _: None, message)

    def stop(self) -> None:
        """End all jobs."""
        operations: list[Sending | Watching] = [*self._sendings.values(), *self.watchings.values()]
        for operation in operations:
            operation.stop()
        self._sendings.clear()
        self.watchings.clear()

    def _changed(self, message: Message, stamp_ns: int) -> None:
        if message.opcode == RX_CHANGED:
            self._tell(heard(message.frames[0], stamp_ns, apart=True))
