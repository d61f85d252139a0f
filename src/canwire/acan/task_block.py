"""Task blocks: the frames and conditions that an application wants to receive, and those that have arrived.

This module starts no thread and uses no hub: a driver offers frames and conditions, an application retrieves them.
Source: INduCAN104 manual, "Message filters", "Task block", "Notification".
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from canwire import BadValue, Frame, WrongState
from canwire.acan.constants import Action, BlockStatus, Condition
from canwire.acan.filters import Filter

if TYPE_CHECKING:
    from types import TracebackType

WORD = 0xFFFF
BYTE = 0xFF
_NOTIFY, _QUEUE = int(Action.NOTIFY), int(Action.QUEUE)
_SC, _MB, _OVERFLOW = int(BlockStatus.SC), int(BlockStatus.MB), int(BlockStatus.OVERFLOW)

Notifier = Callable[["TaskBlock"], object]


class Status(int):
    """wStatus: what has happened since the last acknowledgement; 0 means nothing."""

    @property
    def flags(self) -> BlockStatus:
        return BlockStatus(self & BYTE)

    @property
    def conditions(self) -> Condition:
        return Condition(self >> 8 & BYTE)

    def __repr__(self) -> str:
        return f"<{self:#06x}: {self.flags!r}, {self.conditions!r}>"


class Occurrence(NamedTuple):
    """Special conditions of the bus, with the newest error counters; `alc` and `ecc` are None if they do not apply."""

    conditions: int
    tec: int
    rec: int
    alc: int | None = None
    ecc: int | None = None


class Keeper(Protocol):
    """What a block needs from the driver that it is registered with."""

    @property
    def lock(self) -> AbstractContextManager[object]:
        """The lock that a thread holds while it changes a block."""

    def wait(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Wait for ready(), `timeout` seconds at most (None: without limit); raises once nothing more can arrive."""

    def deregister(self, block: TaskBlock) -> None: ...


class TaskBlock:
    """Filters, a FIFO of `size` frames (0..65535, wRMBSize) and one notification at a time.

    A frame that passes several filters is in the FIFO once. If the FIFO is full, a frame is discarded, sets
    TBS_OVERFLOW and counts in `lost`. `conditions` (bSCFilter) are the special conditions that are reported.

    `notify` is used once, and then not again before `acknowledge`: a callable is called with the block, on the
    driver's thread; for an event `set()` is called; into a queue the block is `put`.
    Raises BadValue with the field's name here and in the manual.
    """

    def __init__(
        self,
        filters: Iterable[Filter] = (),
        *,
        conditions: Condition | int = 0,
        size: int = 64,
        notify: Any = None,
    ) -> None:
        self.filters = tuple(filters)
        self.conditions = Condition(_within("conditions (bSCFilter)", conditions, BYTE))
        self.size = _within("size (wRMBSize)", size, WORD)
        self._notify = _notifier(notify)
        self._table = _table(self.filters, size)
        self._fifo: deque[Frame] = deque()
        self._keeper: Keeper | None = None
        self._lock: AbstractContextManager[object] = nullcontext()
        self._status = self.lost = 0
        self._reset()

    # for applications

    @property
    def registered(self) -> bool:
        return self._keeper is not None

    @property
    def status(self) -> Status:
        """The status that `acknowledge` would return; reading it changes nothing."""
        return Status(self._status)

    @property
    def occupation(self) -> int:
        """The number of frames in the FIFO."""
        return len(self._fifo)

    def acknowledge(self) -> Status:
        """Return what has happened since the last call; the application is notified of the next event again."""
        with self._lock:
            status, self._status = self._status, 0
            self._notified = self._due = False
            self.changed()
        return Status(status)

    def retrieve(self, limit: int | None = None) -> list[Frame]:
        """Remove the oldest frames from the FIFO and return them, at most `limit` (None: all), the oldest first."""
        with self._lock:
            count = len(self._fifo) if limit is None else max(0, min(limit, len(self._fifo)))
            frames = [self._fifo.popleft() for _ in range(count)]
            self.changed()
        return frames

    def wait(self, timeout: float | None = None) -> bool:
        """Wait for something to acknowledge or to retrieve, `timeout` seconds at most (None: without limit).

        Returns whether it arrived. Raises WrongState if the block is not registered or is deregistered meanwhile,
        HubLost or Unplugged if nothing more can arrive.
        """
        return self._keep().wait(self._outstanding, timeout)

    def __iter__(self) -> Iterator[Frame]:
        """Yields frames as they arrive; it ends once the block is deregistered and its FIFO empty."""
        while True:
            found = self.retrieve(1)
            if found:
                yield found[0]
            elif self._keeper is None:
                return
            else:
                self._keeper.wait(self._filled_or_free, None)

    def __enter__(self) -> TaskBlock:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._keeper is not None:
            self._keeper.deregister(self)

    def __repr__(self) -> str:
        state = "registered" if self.registered else "not registered"
        return f"<task block, {len(self.filters)} filters, {self.occupation} of {self.size} frames, {state}>"

    # for drivers, which hold the keeper's lock

    def attach(self, keeper: Keeper) -> None:
        """Register with a driver, with an empty FIFO and status 0; raises BadValue, or WrongState if registered."""
        if self._keeper is not None:
            raise WrongState("the task block is registered already; deregister it first")
        for one in self.filters:
            one.check()
        self._reset()
        self._keeper, self._lock = keeper, keeper.lock
        self.changed()

    def detach(self) -> None:
        """Deregister; the frames in the FIFO can still be retrieved."""
        self._keeper, self._lock = None, nullcontext()

    def offer(self, frame: Frame, word: int) -> list[Frame]:
        """Handle a frame from the bus, with `word` as its ACAN identifier; returns the answers of channels."""
        actions, replies = 0, []
        for and_mask, xor_value, wanted, channel in self._table:
            if (word & and_mask) ^ xor_value == 0:
                actions |= wanted
                if channel is not None:
                    reply = channel.transfer(frame)
                    if reply is not None:
                        replies.append(reply)
        if actions & _QUEUE:
            self._queue(frame)
        if actions & _NOTIFY:
            self._due = True
        return replies

    def answers(self, word: int) -> bool:
        """Whether a frame with this identifier would make a channel send."""
        return any(one.actions & Action.CHANSND and one.matches(word) for one in self.filters)

    def occurred(self, what: Occurrence) -> None:
        """Handle special conditions; the error counters are stored for all conditions, selected or not."""
        self.tec, self.rec = min(what.tec, BYTE), min(what.rec, BYTE)
        if what.alc is not None:
            self.alc = what.alc & BYTE
        if what.ecc is not None:
            self.ecc = what.ecc & BYTE
        wanted = what.conditions & int(self.conditions)
        if wanted:
            self._status |= wanted << 8 | _SC
            self._due = True
        self.changed()

    def take_notification(self) -> bool:
        """Whether `notify` is due now; then it is not due again before `acknowledge`."""
        if not self._due or self._notified:
            return False
        self._notified, self._due = True, False
        return True

    def notify(self) -> None:
        """Notify the application; called without the lock."""
        if self._notify is not None:
            self._notify(self)

    # for subclasses that show the block in another place, too; called with the lock held

    def stored(self, frame: Frame) -> None:
        """A frame went into the FIFO."""

    def changed(self) -> None:
        """Status word, counters or FIFO changed."""

    # its own

    def _queue(self, frame: Frame) -> None:
        if len(self._fifo) < self.size:
            self._fifo.append(frame)
            self._status |= _MB
            self.stored(frame)
        else:
            self.lost += 1
            self._status |= _OVERFLOW
        self.changed()

    def _reset(self) -> None:
        self._fifo.clear()
        self._status = self.lost = 0
        self.tec = self.rec = self.alc = self.ecc = 0
        self._notified = self._due = False

    def _outstanding(self) -> bool:
        self._keep()
        return bool(self._fifo) or self._status != 0 or self._notified

    def _filled_or_free(self) -> bool:
        return bool(self._fifo) or self._keeper is None

    def _keep(self) -> Keeper:
        if self._keeper is None:
            raise WrongState("the task block is not registered")
        return self._keeper


def _within(name: str, value: int, largest: int) -> int:
    if not isinstance(value, int) or not 0 <= value <= largest:
        raise BadValue(f"{name} {value!r}: a whole number from 0 to {largest}")
    return value


def _table(filters: tuple[Filter, ...], size: int) -> list[tuple[int, int, int, Filter | None]]:
    """What `offer` compares for each frame, as plain numbers: mask, value, actions, and a channel's filter."""
    if len(filters) > BYTE:
        raise BadValue(f"filters (bNId) {len(filters)}: a task block has at most {BYTE}")
    if not size and any(one.actions & Action.QUEUE for one in filters):
        raise BadValue("size (wRMBSize) 0: a filter that queues messages needs room for at least one")
    return [
        (one.and_mask, one.xor_value, int(one.actions), one if one.variable is not None else None)
        for one in filters
    ]


def _notifier(notify: Any) -> Notifier | None:
    if notify is None:
        return None
    if callable(getattr(notify, "put", None)):
        return lambda block: notify.put(block)
    if callable(getattr(notify, "set", None)):
        return lambda _: notify.set()
    if callable(notify):
        return lambda block: notify(block)
    raise BadValue(f"notify (bNotType) {notify!r}: a callable, or something with set() or put()")
