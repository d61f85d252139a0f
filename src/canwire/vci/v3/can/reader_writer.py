"""ICanMessageReader and ICanMessageWriter: the two ends of a channel.

Source: VCI V3 .NET manual 3.1, 4.2.3.1 and 4.2.3.2; reference/vci.md section 7a; rulings.md 8.
"""

from __future__ import annotations

from collections.abc import Sequence

from canwire.vci.can.message import CanMsg
from canwire.vci.fifo.fifo import FifoWriter
from canwire.vci.structures.errors import VCI_E_INVALIDARG, VciTxQueueFull
from canwire.vci.v3.can.message import CanMessage, received
from canwire.vci.v3.disposable import net_call
from canwire.vci.v3.errors import ArgumentException
from canwire.vci.v3.message_fifo import Lockable, MessageReader


class CanMessageReader(MessageReader[CanMsg, CanMessage], Lockable[CanMsg]):
    """ICanMessageReader: reads received messages from the channel's receive FIFO."""

    def _received(self, raw: CanMsg, out: CanMessage | None = None) -> CanMessage:
        return received(raw, out)

    # as the manual spells them
    get_message = MessageReader.read_message
    get_messages = MessageReader.read_messages


class CanMessageWriter(Lockable[CanMsg]):
    """ICanMessageWriter: writes messages into the channel's transmit FIFO."""

    def __init__(self, writer: FifoWriter[CanMsg]) -> None:
        super().__init__(writer)
        self._writer = writer

    @property
    def free_count(self) -> int:
        """FreeCount: the number of messages that still fit into the FIFO."""
        return 0 if self._disposed else self._free_count()

    @net_call
    def send_message(self, message: CanMessage) -> bool:
        """SendMessage: write a message into the FIFO; False if the FIFO is full.

        A message that the line cannot send, such as one with a FrameType other than DATA, is discarded without an
        error and counted (`hub.line_status`).
        """
        return self._put(message)

    @net_call
    def send_messages(self, messages: Sequence[CanMessage]) -> int:
        """SendMessages: write messages until the FIFO is full; returns how many were written."""
        for count, message in enumerate(messages):
            if not self._put(message):
                return count
        return len(messages)

    def _put(self, message: CanMessage) -> bool:
        if not isinstance(message, CanMessage):
            raise ArgumentException(VCI_E_INVALIDARG, f"a CanMessage belongs here, not {message!r:.60}")
        try:
            self._writer.put_data_entry(message.raw)
        except VciTxQueueFull:
            return False
        return True

    @net_call
    def _free_count(self) -> int:
        return self._writer.get_free_count()

    # as the manual spells them
    write_message = send_message
    write_messages = send_messages
