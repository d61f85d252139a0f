"""ICanMessageReader and ICanMessageWriter: the two ends of a channel.

Source: VCI V3 .NET manual (seed 002) 3.1, 4.2.3.1 and 4.2.3.2; reference/vci.md section 7a; rulings.md 8.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, overload

from canwire.vci.arguments import UINT16
from canwire.vci.can_message import CanMsg
from canwire.vci.errors import VCI_E_INVALIDARG, VciRxQueueEmpty, VciTxQueueFull
from canwire.vci.fifo import FifoEnd, FifoReader, FifoWriter
from canwire.vci.v3.disposable import Disposable, net_call
from canwire.vci.v3.errors import ArgumentException, checked
from canwire.vci.v3.message import CanMessage, received

if TYPE_CHECKING:
    from canwire import Event


class MessageFifo(Disposable):
    """What a reader and a writer share. A disposed one counts 0; its other calls raise ObjectDisposedException."""

    def __init__(self, end: FifoEnd[CanMsg]) -> None:
        """For ICanChannel."""
        super().__init__()
        self._end = self._hold(end)

    @property
    def capacity(self) -> int:
        """Capacity: how many messages there is room for, at least as many as Initialize was asked for."""
        return 0 if self._disposed else self._capacity()

    @property
    @net_call
    def threshold(self) -> int:
        """Threshold: messages (reader) or free places (writer) at which the event is signalled, 1 to Capacity.

        It is 1 at first; more than Capacity counts as Capacity, 0 as 1.
        """
        return self._end.get_threshold()

    @threshold.setter
    @net_call
    def threshold(self, count: int) -> None:
        self._end.set_threshold(checked("threshold", count, UINT16))

    @net_call
    def assign_event(self, event: Event | None) -> None:
        """AssignEvent: signal this event when the threshold is met, in place of the one before; None: no event.

        A reader's is signalled when a message comes in and at least `threshold` wait then; a writer's when one
        leaves and at least `threshold` places are free then.
        """
        self._end.assign_event(event)

    @net_call
    def lock(self) -> None:
        """Lock: keep other threads that call this out until `unlock`; it nests."""
        self._end.lock()

    @net_call
    def unlock(self) -> None:
        """Unlock; raises VciException if the calling thread does not hold the lock."""
        self._end.unlock()

    @net_call
    def _capacity(self) -> int:
        return self._end.get_capacity()


class CanMessageReader(MessageFifo):
    """ICanMessageReader: takes received messages out of the channel's receive FIFO."""

    def __init__(self, reader: FifoReader[CanMsg]) -> None:
        super().__init__(reader)
        self._reader = reader

    @property
    def fill_count(self) -> int:
        """FillCount: messages that wait."""
        return 0 if self._disposed else self._fill_count()

    @overload
    def read_message(self) -> CanMessage | None: ...
    @overload
    def read_message(self, out: CanMessage) -> bool: ...
    def read_message(self, out: CanMessage | None = None) -> CanMessage | bool | None:
        """ReadMessage: the oldest message, None if there is none; with `out` into that one, and whether it was."""
        raw = self._take()
        if out is None:
            return None if raw is None else received(raw)
        if raw is not None:
            received(raw, out)
        return raw is not None

    @overload
    def read_messages(self, messages: int) -> list[CanMessage]: ...
    @overload
    def read_messages(self, messages: list[Any]) -> int: ...
    def read_messages(self, messages: list[Any] | int) -> list[CanMessage] | int:
        """ReadMessages: fill a list from its beginning and return how many came; or give up to so many as a list."""
        if isinstance(messages, int):
            return [received(raw) for raw in self._take_many(checked("messages", messages, 1 << 31))]
        count = 0
        for raw in self._take_many(len(messages)):
            messages[count] = received(raw)
            count += 1
        return count

    @net_call
    def _fill_count(self) -> int:
        return self._reader.get_fill_count()

    @net_call
    def _take(self) -> CanMsg | None:
        try:
            return self._reader.get_data_entry()
        except VciRxQueueEmpty:
            return None

    @net_call
    def _take_many(self, limit: int) -> list[CanMsg]:
        return list(self._blocks(limit))

    def _blocks(self, limit: int) -> Iterator[CanMsg]:
        """What waits lies in two pieces where the FIFO's memory ends."""
        while limit:
            try:
                block, waiting = self._reader.acquire_read()
            except VciRxQueueEmpty:
                return
            count = min(waiting, limit)
            yield from block[:count]
            self._reader.release_read(count)
            limit -= count

    # as the manual spells them
    get_message = read_message
    get_messages = read_messages


class CanMessageWriter(MessageFifo):
    """ICanMessageWriter: puts messages into the channel's transmit FIFO."""

    def __init__(self, writer: FifoWriter[CanMsg]) -> None:
        super().__init__(writer)
        self._writer = writer

    @property
    def free_count(self) -> int:
        """FreeCount: messages that still fit."""
        return 0 if self._disposed else self._free_count()

    @net_call
    def send_message(self, message: CanMessage) -> bool:
        """SendMessage: False if there is no room.

        What the line cannot send, any FrameType but DATA among it, it refuses silently and counts (`hub.line_status`).
        """
        return self._put(message)

    @net_call
    def send_messages(self, messages: Sequence[CanMessage]) -> int:
        """SendMessages: how many of them there was room for, from the first on."""
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
