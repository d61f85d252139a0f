"""The send window: generators, and the messages that were actually sent.

Source: CANDRV manual, 10.4, send dialog; rulings.md 35.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.candrv import COMMTIMEOUTS, INFINITE, CandrvError, Command, FrameFormat, Win32Error
from canwire.candrv.filters import aligned
from canwire.web.cancheck.generators import MS, Generators
from canwire.web.cancheck.generators import Row as Generator
from canwire.web.cancheck.listing import PAUSED, Listing, Row, message_row, shown_time
from canwire.web.cancheck.recipe import Outgoing

if TYPE_CHECKING:
    from canwire.candrv import Handle
    from canwire.web.cancheck.echoes import Echoes

SINGLE_MS = 50  # in single message mode a message waits so long for its turn before it is tried again


class SendWindow:
    """`take` lists the frames that were sent since its last call; `generators.fire` sends. Raises CandrvError.

    `echoes` returns the frames that the line has sent; messages are identified by content and order, as in the driver
    itself. `given_up` counts messages that were never sent.
    """

    kind = "send"

    def __init__(
        self,
        number: int,
        handle: Handle,
        echoes: Echoes,
        clock_ns: Callable[[], int] | None = None,
        changed: Callable[[], None] = lambda: None,
    ) -> None:
        self.number = number
        self.handle = handle
        self.echoes = echoes
        self.list = Listing(changed)
        self.trouble = ""
        self.given_up = 0
        self._changed = changed
        self._lock = threading.RLock()
        self._under_way: deque[tuple[int, Outgoing]] = deque()
        at_once = 0 if handle.device.settings.send_buffer_mode else SINGLE_MS
        handle.timeouts = COMMTIMEOUTS(0, 0, INFINITE, 0, at_once)
        self.generators = Generators(self._send, clock_ns or handle.device.hub.now_ns)

    @property
    def align(self) -> int:
        return self.handle.device.settings.align

    def _send(self, index: int, message: Outgoing) -> bool:
        word = aligned(message.identifier, message.extended, self.align)
        fmt = FrameFormat.EXT if message.extended else FrameFormat.STD
        with self._lock:
            try:
                self.handle.write_message(word, message.data, rtr=message.rtr, dlc=message.dlc, fmt=fmt)
            except CandrvError as error:
                if error.code == Win32Error.ERROR_TIMEOUT:
                    return False
                raise
            self._under_way.append((index, message))
            return True

    def take(self) -> int:
        """List the messages that were sent since the last call; returns their number."""
        rows = []
        with self._lock:
            for message, at_ns in self.echoes.take():
                index = self._found(message)
                if index is not None:
                    rows.append(message_row(shown_time(at_ns // MS), index, message, self.align))
            self.list.append(*rows)
        return len(rows)

    def wait(self) -> None:
        """Wait until the line has sent a frame; raises CanwireError when the line no longer reports this."""
        self.echoes.wait()

    def abort(self) -> int:
        """Execute CANBUS_CMD_ABORT_TRANSMISSION, and empty the send buffer; returns the number of
        discarded messages."""
        with self._lock:
            self.handle.command(Command.ABORT_TRANSMISSION)
            waiting = self.handle.sending.waiting
            self.take()
            count = max(0, len(self._under_way) - waiting)  # one may be on the wire, and is completed
            for _ in range(count):
                self._under_way.pop()
            self.given_up += count
        self._changed()
        return count

    def generator_row(self, generator: Generator) -> Row:
        """Return the cells of a generator, as for messages: Time is when its next message is due, or -Paused-."""
        due_ns = generator.due_ns
        time = PAUSED if due_ns is None else shown_time(due_ns // MS)
        return message_row(time, generator.number, generator.message, self.align)

    def close(self) -> None:
        """Close the window. Messages in the send buffer are still sent, as with every handle. A second call does
        nothing."""
        self.generators.pause_all()
        self.generators.wake()
        self.list.close_log()
        try:
            self.handle.close()
        finally:
            self.echoes.close()

    def _found(self, message: Outgoing) -> int | None:
        """Return the generator of the oldest message with this content; None for a message of another program."""
        if not any(one == message for _, one in self._under_way):
            return None
        while True:
            index, one = self._under_way.popleft()
            if one == message:
                return index
            self.given_up += 1  # the driver gave it up: messages of a handle keep their order
