"""ICanMessageReader and ICanMessageWriter of Ixxat.Vci4, for channels of both kinds.

Source: the vendor's published contract of Ixxat.Vci4; VCI V4 manual 5.2.2.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Generic, TypeVar, cast

from canwire.vci.can.message import CanMsg, CanMsg2
from canwire.vci.fifo.fifo import FifoReader, FifoWriter
from canwire.vci.net4.message import CanMessage, CanMessage2
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciTxQueueFull
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ArgumentException
from canwire.vci.v3.message_fifo import Lockable, MessageReader

Raw = TypeVar("Raw", bound=CanMsg | CanMsg2)
Received = TypeVar("Received", bound=CanMessage | CanMessage2)


class CanMessageReader(MessageReader[Raw, Received], Lockable[Raw], Generic[Raw, Received]):
    """ICanMessageReader: reads CanMessage from an ICanChannel, CanMessage2 from an ICanChannel2."""

    def __init__(self, reader: FifoReader[Raw], kind: type[Received]) -> None:
        """Channels make it."""
        super().__init__(reader)
        self._kind = kind

    def _received(self, raw: Raw, out: Received | None = None) -> Received:
        if out is not None and not isinstance(out, self._kind):
            raise ArgumentException(
                VCI_E_INVALIDARG, f"this channel reads {self._kind.__name__}, not {type(out).__name__}"
            )
        made = self._kind() if out is None else out
        made.raw = cast(Any, raw)
        return made


class CanMessageWriter(Lockable[Raw], Generic[Raw]):
    """ICanMessageWriter: accepts CanMessage and CanMessage2, on an ICanChannel up to 8 bytes and no CAN FD."""

    def __init__(self, writer: FifoWriter[Raw], kind: type[Raw]) -> None:
        """Channels make it."""
        super().__init__(writer)
        self._writer = writer
        self._kind = kind

    @property
    def free_count(self) -> int:
        """FreeCount: the number of messages that still fit into the FIFO."""
        return 0 if self._disposed else self._free_count()

    @net_call
    def send_message(self, message: CanMessage | CanMessage2) -> bool:
        """SendMessage: write a message into the FIFO; False if the FIFO is full.

        Raises ArgumentException for CAN FD on an ICanChannel, VciException for CAN FD on a controller without it. A
        message that the line cannot send in its configuration is discarded without an error and counted
        (`hub.line_status`).
        """
        try:
            self._writer.put_data_entry(self._as_taken(message))
        except VciTxQueueFull:
            return False
        return True

    @net_call
    def send_messages(self, messages: Sequence[CanMessage | CanMessage2]) -> int:
        """Write messages until the FIFO is full; returns how many were written. V3 has this, Ixxat.Vci4 does not."""
        return next((at for at, one in enumerate(messages) if not self.send_message(one)), len(messages))

    @net_call
    def _free_count(self) -> int:
        return self._writer.get_free_count()

    def _as_taken(self, message: CanMessage | CanMessage2) -> CanMsg | CanMsg2:
        if not isinstance(message, CanMessage | CanMessage2):
            raise ArgumentException(VCI_E_INVALIDARG, f"an ICanMessage belongs here, not {message!r:.60}")
        raw = message.raw
        if isinstance(raw, self._kind):
            return raw
        made = self._kind(time=raw.time, msg_id=raw.msg_id, msg_info=raw.msg_info)
        made.ab_data[:] = bytes(raw.ab_data[: made.ROOM]).ljust(made.ROOM, b"\0")
        return made
