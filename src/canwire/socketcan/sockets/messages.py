"""The common part of CAN_BCM and CAN_ISOTP: the program's messages arrive as requests, single frames go to a line."""

from __future__ import annotations

import errno
from typing import TYPE_CHECKING

from canwire.socketcan.interfaces import REFUSED
from canwire.socketcan.outlets import MessageOutlet
from canwire.socketcan.requests.control import Unasked
from canwire.socketcan.sockets.base import CanSocket, Opened, message_of
from canwire.socketcan.sockets.frame_queue import FrameQueue

if TYPE_CHECKING:
    from canwire.socketcan.interfaces import Interface
    from canwire.socketcan.port import Port
    from canwire.socketcan.requests.control import Answered

_AT_ONCE = 64


class MessageSocket(CanSocket):
    """A socket whose `sent` processes what the program has written, and answers it."""

    def __init__(self, opened: Opened) -> None:
        self.outlet = MessageOutlet(opened.ring)
        self._frames = FrameQueue()
        super().__init__(opened)

    def sent(self, data: bytes, index: int, waits: bool, asked: Answered) -> None:
        """Process a message of the program and answer it, now or later; raises OSError, with which the call fails."""
        raise NotImplementedError

    def tell(
        self,
        payload: bytes,
        stamp_ns: int,
        index: int,
        error: int = 0,
        *,
        flags: int = 0,
        about: bytes = b"",
    ) -> None:
        """Send a message to the program."""
        if self.over:
            return
        header = message_of(payload, stamp_ns, index, self.outlet.drops, error, flags)
        self.outlet.put(header, about)
        self.setting.stir()
        self.rewatch()
        self.told()

    def send_frame(self, port: Port, frame: bytes) -> None:
        """Send a struct can_frame or canfd_frame; it waits in a queue while the line has no room."""
        self._frames.send(port, self.slot, frame)

    def send_to(self, data: bytes, index: int) -> None:
        self.sent(data, index, False, Unasked())

    def wants_writable(self) -> bool:
        return self.outlet.waiting > 0

    def written(self) -> None:
        self.outlet.flush()
        self.setting.stir()

    def readable(self) -> None:
        """Read messages that were written without the library's requests; errors in these are not reported."""
        messages, hung_up = self.arrived(_AT_ONCE)
        for message in messages:
            try:
                self.sent(message, 0, True, Unasked())
            except OSError:
                self.setting.interfaces.drop(self.setting.table.bound_to(self.slot), 1, REFUSED)
        if hung_up:
            self.close()

    def congested(self) -> bool:
        return False

    def interface_lost(self, interface: Interface, error: int) -> None:
        self.setting.table.set_error(self.slot, error)
        if error == errno.ENODEV:
            self.setting.table.unbind(self.slot)
        self.tell(b"", 0, interface.index, error)
