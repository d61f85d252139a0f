"""Task blocks: which frames and conditions an application wants to hear of, and what has come of them.

Nothing here starts threads or asks a hub: a driver offers frames and conditions, an application takes them.
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
    """wStatus: what has happened since it was acknowledged last; 0: nothing."""

    @property
    def flags(self) -> BlockStatus:
        return BlockStatus(self & BYTE)

    @property
    def conditions(self) -> Condition:
        return Condition(self >> 8 & BYTE)

    def __repr__(self) -> str:
        return f"<{self:#06x}: {self.flags!r}, {self.conditions!r}>"


class Occurrence(NamedTuple):
    """Something special on the bus, with the newest counters; `alc` and `ecc` None where they mean nothing."""

    conditions: int
    tec: int
    rec: int
    alc: int | None = None
    ecc: int | None = None


class Keeper(Protocol):
    """What a block asks of the driver that it is registered with."""

    @property
    def lock(self) -> AbstractContextManager[object]:
        """Held by whoever changes a block."""

    def wait(self, ready: Callable[[], bool], timeout: float | None) -> bool:
        """Until ready() or `timeout` seconds are over (None: for ever); raises once nothing more can come."""

    def deregister(self, block: TaskBlock) -> None: ...


class TaskBlock:
    """Filters, a FIFO of `size` frames (0..65535, wRMBSize) and one notification at a time.

    A frame that several filters let through stands in the FIFO once. One that finds it full is dropped, sets
    TBS_OVERFLOW and counts as `lost`. `conditions` (bSCFilter) are the special conditions that matter.

    `notify` is told once, and then not again until `acknowledge`: a callable gets the block, on the driver's
    thread; an event has its `set` called; a queue has the block `put` into it.
    Raises BadValue, naming the field here and in the manual.
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
        """As `acknowledge` would return it; takes nothing."""
        return Status(self._status)

    @property
    def occupation(self) -> int:
        """Frames that wait in the FIFO."""
        return len(self._fifo)

    def acknowledge(self) -> Status:
        """What has happened since the last time; from now on the next event is notified again."""
        with self._lock:
            status, self._status = self._status, 0
            self._notified = self._due = False
            self.changed()
        return Status(status)

    def retrieve(self, limit: int | None = None) -> list[Frame]:
        """The oldest frames in the order of their arrival, at most `limit`; they leave the FIFO."""
        with self._lock:
            count = len(self._fifo) if limit is None else max(0, min(limit, len(self._fifo)))
            frames = [self._fifo.popleft() for _ in range(count)]
            self.changed()
        return frames

    def wait(self, timeout: float | None = None) -> bool:
        """Until there is something to acknowledge or to retrieve, at most `timeout` seconds (None: for ever).

        Raises WrongState if the block is not registered by then, HubLost or Unplugged if no more can come.
        """
        return self._keep().wait(self._outstanding, timeout)

    def __iter__(self) -> Iterator[Frame]:
        """Frames as they come, for ever: it ends once the block is deregistered and empty."""
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

    # for drivers, who hold the keeper's lock

    def attach(self, keeper: Keeper) -> None:
        """Registered from now on, as good as new; raises WrongState if it is registered already, BadValue."""
        if self._keeper is not None:
            raise WrongState("the task block is registered already; deregister it first")
        for one in self.filters:
            one.check()
        self._reset()
        self._keeper, self._lock = keeper, keeper.lock
        self.changed()

    def detach(self) -> None:
        """Registered no more; frames that wait can still be retrieved."""
        self._keeper, self._lock = None, nullcontext()

    def offer(self, frame: Frame, word: int) -> list[Frame]:
        """A frame from the bus, `word` its ACAN identifier; returns what channels answer to it."""
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
        """Special conditions; counters are kept even of those that the block did not ask for."""
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
        """Whether `notify` is due now; it is not again until somebody has acknowledged."""
        if not self._due or self._notified:
            return False
        self._notified, self._due = True, False
        return True

    def notify(self) -> None:
        """Tell the application; without the lock."""
        if self._notify is not None:
            self._notify(self)

    # for those who show the block elsewhere, too; called with the lock held

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
    """What `offer` asks of every frame, in plain numbers."""
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
