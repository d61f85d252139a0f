"""A FIFO of messages, and its reading end.

Source: VCI V3 .NET manual 3.1, 4.2.3.1 and 4.3.3.1; reference/vci.md section 7a; rulings.md 8.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Generic, TypeVar, overload

from canwire.vci.arguments import UINT16
from canwire.vci.fifo.fifo import FifoEnd, FifoReader
from canwire.vci.structures.errors import VciRxQueueEmpty
from canwire.vci.v3.disposable import Disposable, net_call
from canwire.vci.v3.errors import checked

if TYPE_CHECKING:
    from canwire import Event

Raw = TypeVar("Raw")
Message = TypeVar("Message")
_EVERYTHING = 1 << 31  # more than any FIFO holds


class MessageFifo(Disposable, Generic[Raw]):
    """The common part of a reader and a writer.

    After `dispose` its counts and its threshold are 0, and calls raise ObjectDisposedException.
    """

    def __init__(self, end: FifoEnd[Raw]) -> None:
        """For channels and monitors."""
        super().__init__()
        self._end = self._hold(end)

    @property
    def capacity(self) -> int:
        """Capacity: the number of messages that the FIFO can contain, at least the number given to Initialize."""
        return 0 if self._disposed else self._capacity()

    @property
    def threshold(self) -> int:
        """Threshold: the number of messages (reader) or free places (writer) that signals the event, 1 to Capacity.

        It is 1 at first; a number above Capacity means Capacity, 0 means 1.
        """
        return 0 if self._disposed else self._threshold()

    @threshold.setter
    @net_call
    def threshold(self, count: int) -> None:
        self._end.set_threshold(checked("threshold", count, UINT16))

    @net_call
    def assign_event(self, event: Event | None) -> None:
        """AssignEvent: signal this event at the threshold; it replaces the previous event, None removes that.

        A reader's event is signalled when a message arrives and at least `threshold` messages then wait; a writer's
        event when a message leaves and at least `threshold` places are then free.
        """
        self._end.assign_event(event)

    @net_call
    def _threshold(self) -> int:
        return self._end.get_threshold()

    @net_call
    def _capacity(self) -> int:
        return self._end.get_capacity()


class MessageReader(MessageFifo[Raw], Generic[Raw, Message]):
    """Reads received messages from a receive FIFO."""

    def __init__(self, reader: FifoReader[Raw]) -> None:
        super().__init__(reader)
        self._reader = reader

    @property
    def fill_count(self) -> int:
        """FillCount: the number of messages that wait."""
        return 0 if self._disposed else self._fill_count()

    @overload
    def read_message(self) -> Message | None: ...
    @overload
    def read_message(self, out: Message) -> bool: ...
    def read_message(self, out: Message | None = None) -> Message | bool | None:
        """ReadMessage: the oldest message, or None; with `out`, write it into `out` and return whether one waited."""
        raw = self._take()
        if out is None:
            return None if raw is None else self._received(raw)
        if raw is not None:
            self._received(raw, out)
        return raw is not None

    @overload
    def read_messages(self, messages: int = _EVERYTHING) -> list[Message]: ...
    @overload
    def read_messages(self, messages: list[Any]) -> int: ...
    def read_messages(self, messages: list[Any] | int = _EVERYTHING) -> list[Message] | int:
        """ReadMessages: for a list, fill it from its start and return the number of messages read.

        For a number, return a list of up to that many messages; without an argument, as in today's .NET interface, a
        list of all messages that wait.
        """
        if isinstance(messages, int):
            return [
                self._received(raw) for raw in self._take_many(checked("messages", messages, _EVERYTHING))
            ]
        count = 0
        for raw in self._take_many(len(messages)):
            messages[count] = self._received(raw)
            count += 1
        return count

    def _received(self, raw: Raw, out: Message | None = None) -> Message:
        """V3's message for V4's message, in `out` if that is given."""
        raise NotImplementedError

    @net_call
    def _fill_count(self) -> int:
        return self._reader.get_fill_count()

    @net_call
    def _take(self) -> Raw | None:
        try:
            return self._reader.get_data_entry()
        except VciRxQueueEmpty:
            return None

    @net_call
    def _take_many(self, limit: int) -> list[Raw]:
        return list(self._blocks(limit))

    def _blocks(self, limit: int) -> Iterator[Raw]:
        """The messages in the FIFO, which are in two blocks if they reach over the end of its memory."""
        while limit:
            try:
                block, waiting = self._reader.acquire_read()
            except VciRxQueueEmpty:
                return
            count = min(waiting, limit)
            yield from block[:count]
            self._reader.release_read(count)
            limit -= count


class Lockable(MessageFifo[Raw], Generic[Raw]):
    """An end that threads can share."""

    @net_call
    def lock(self) -> None:
        """Lock: wait until no other thread holds the lock, which `unlock` releases. Calls nest."""
        self._end.lock()

    @net_call
    def unlock(self) -> None:
        """Unlock; raises VciException if the calling thread does not hold the lock."""
        self._end.unlock()
