"""A first-in first-out ring of 80-byte records: one producer, one consumer, any two processes.

    words   writer     what
    0..3    creator    magic and version, slots, bytes per record, capacity in records (at most the slots)
    8       producer   head: records ever written
    9       producer   lost: records dropped because the ring was full
    16      consumer   tail: records ever taken
    17      both       wanted: head whose writing signals the consumer (0: it wants no signal)
    24      both       the same for the producer: tail whose taking signals it
    32..               records

The consumer sets `wanted`, the producer clears it just before it signals. What is wanted counts from what the
consumer has seen, not from what is there by now, and after setting it the consumer looks once more: so no order
of these steps loses a signal. Records of other sizes than 80 bytes go in and out as bytes only.

Each counter has its own 64-byte line and one writer, and only differences count, so they may wrap.
A word read from the other side is never trusted: a fill level above the capacity means that the
peer is broken, and the ring counts as full for the producer and as empty for the consumer.
"""

from __future__ import annotations

import mmap
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import TYPE_CHECKING, Protocol

from canwire import _mem
from canwire.errors import BadValue, CanwireError
from canwire.values import frame as codec
from canwire.values.arguments import SignatureOf
from canwire.values.frame import Frame
from canwire.values.record import RECORD_SIZE, load_numpy, record_dtype

if TYPE_CHECKING:
    import numpy

MAGIC = 0x0001_4757_4E41_4301  # "\x01CANWG", version 1
HEADER_SIZE = 256
_CAPACITY = 1
_RECORD_BYTES = 2
_LIMIT = 3
_HEAD = 8
_LOST = 9
_TAIL = 16
_WANTED = 17
_FREE_WANTED = 24
_RECORDS = 32
_WORDS = 10
_RECORD_SIZE = RECORD_SIZE
_PLAIN = (
    f"V{RECORD_SIZE}"  # to numpy: bytes; it copies records of several fields field by field, ten times slower
)
_M64 = (1 << 64) - 1  # counters wrap; only their differences count
_LARGEST_CAPACITY = 1 << 24
LARGEST_CAPACITY = _LARGEST_CAPACITY
# interpreted there is no memory fence, so a signal may be missed: a waiting end checks again after this time
RECHECK_S = 0.01 if __file__.endswith(".py") else None


_NOWHERE = memoryview(bytearray(HEADER_SIZE + RECORD_SIZE))


class Signalled(Protocol):
    """What wakes the other end: the EventDescriptor of platform.py, or a substitute."""

    def signal(self) -> None: ...
    def wait_for(self, settled: Callable[[], bool], timeout: float | None, recheck: float | None) -> bool: ...


def _prototype(
    capacity: int, *, exact: bool = False, record_size: int = RECORD_SIZE, buffer: memoryview | None = None
) -> None:
    """The signature of Ring, for help()."""


class Ring:
    """A ring in this process's memory, or with `over` one end of a ring in memory that processes share.

    `threshold` (1..capacity) is the fill level whose crossing wakes the consumer, `free_threshold` the free
    count whose crossing wakes the producer: in this process by calling `listener` / `free_listener`, across
    processes through the descriptors `event` / `free_event`, where `arm` and `sleep` ask for it.

    A ring of this process that is empty begins again at its first slot: one whose consumer keeps up takes a few
    kilobytes, which stay in the processor's cache.
    `exact` keeps to `capacity` instead of the next power of two; memory is taken for that all the same.
    """

    __signature__ = SignatureOf(_prototype)

    def __cinit__(self, *_: object, **__: object) -> None:
        """Compiled: what was never initialised is a full and empty ring, not a way out of the interpreter."""
        self._words = _mem.words_of(_NOWHERE)

    def __init__(
        self,
        capacity: int,
        *,
        exact: bool = False,
        record_size: int = RECORD_SIZE,
        buffer: memoryview | None = None,
    ) -> None:
        slots = rounded_capacity(capacity)
        self.capacity = capacity if exact else slots
        self.record_size = record_size
        self._mask = slots - 1
        size = ring_size(slots, record_size)
        if buffer is not None and buffer.nbytes < size:
            raise BadValue(f"buffer of {buffer.nbytes} bytes: this ring takes {size}")
        self._buffer = buffer if buffer is not None else own_memory(size)
        self._words = _mem.words_of(self._buffer)
        self._shared = buffer is not None
        self.event: Signalled | None = None
        self.free_event: Signalled | None = None
        self.listener: Callable[[], None] | None = None
        self.free_listener: Callable[[], None] | None = None
        self.threshold = 1
        self.free_threshold = 1
        self._seen_head = self._words[_HEAD]
        self._seen_tail = self._words[_TAIL]
        self._start = 0  # the count whose record lies in the first slot
        if self._words[0] == 0:
            self._words[_CAPACITY] = slots
            self._words[_RECORD_BYTES] = record_size
            self._words[_LIMIT] = self.capacity
            self._words[0] = MAGIC

    @classmethod
    def over(
        cls, descriptor: int, capacity: int, *, exact: bool = False, record_size: int = RECORD_SIZE
    ) -> Ring:
        """One end of the ring in platform.create_memory's memory, whose descriptor stays the caller's to close.

        Raises BadValue for memory that this ring does not fit.
        """
        from canwire.platform import map_memory

        return cls(capacity, exact=exact, record_size=record_size, buffer=map_memory(descriptor))

    def __repr__(self) -> str:
        return f"<ring, {self.contents()} of {self.capacity} records of {self.record_size} bytes>"

    def contents(self) -> int:
        """Number of records in the ring. Unlike `fill` and `free` it does not affect which end is signalled when."""
        count = (_mem.load_acquire(self._words, _HEAD) - _mem.load_acquire(self._words, _TAIL)) & _M64
        return count if count <= self.capacity else 0

    def fill(self) -> int:
        """Records that wait for the consumer."""
        self._seen_head = _mem.load_acquire(self._words, _HEAD)
        count = (self._seen_head - _mem.load_acquire(self._words, _TAIL)) & _M64
        return count if count <= self.capacity else 0

    def free(self) -> int:
        """Records that the producer can still write."""
        self._seen_tail = _mem.load_acquire(self._words, _TAIL)
        count = (_mem.load_acquire(self._words, _HEAD) - self._seen_tail) & _M64
        return self.capacity - count if count <= self.capacity else 0

    @property
    def written(self) -> int:
        return int(self._words[_HEAD])

    @property
    def taken(self) -> int:
        return int(self._words[_TAIL])

    @property
    def wanted(self) -> int:
        """The `written` that the consumer wants to be signalled at, 0: none."""
        return int(self._words[_WANTED])

    @property
    def free_wanted(self) -> int:
        """The `taken` that the producer wants to be signalled at, 0: none."""
        return int(self._words[_FREE_WANTED])

    @property
    def lost(self) -> int:
        """Records dropped because the ring was full."""
        return int(self._words[_LOST])

    def put(self, source: _mem.Words, at: int, time_ns: int, head_word: int) -> bool:
        """Append the record at word `at` of `source`, with this time and id/info word; False if full (counted)."""
        words = self._words
        head = words[_HEAD]
        self._seen_tail = _mem.load_acquire(words, _TAIL)
        fill = (head - self._seen_tail) & _M64
        if fill >= self.capacity:
            words[_LOST] = (words[_LOST] + 1) & _M64
            return False
        if fill == 0 and not self._shared:
            self._start = head
        slot = _RECORDS + (head - self._start & self._mask) * 10  # a literal: the compiler makes shifts of it
        _mem.copy_record(words, slot, source, at)
        words[slot] = time_ns
        words[slot + 1] = head_word
        head = (head + 1) & _M64
        _mem.store_release(words, _HEAD, head)
        if self._shared or self.listener is not None:
            self._told(head, fill, 1)
        return True

    def put_bytes(self, record: bytes | bytearray | memoryview) -> bool:
        """Append one 80-byte record unchanged; False if full (counted)."""
        if len(record) != self.record_size:
            raise BadValue(f"a record has {self.record_size} bytes, not {len(record)}")
        if self.record_size != _RECORD_SIZE:
            return self._put_other(record)
        block = bytearray(record)
        source = _mem.words_of(block)
        return self.put(source, 0, source[0], source[1])

    def put_at(self, record: bytearray, time_ns: int, last: int) -> bool:
        """Append one 80-byte record with this time, and if it fills the ring the bits `last` of its second word."""
        if len(record) != _RECORD_SIZE or self.record_size != _RECORD_SIZE:
            raise BadValue(f"a record has {self.record_size} bytes, not {len(record)}")
        source = _mem.words_of(record)
        word = source[1]
        if self.free() == 1:
            word |= last
        return self.put(source, 0, time_ns, word)

    def front(self) -> int:
        """The word where the oldest record starts, or 0 when the ring is empty."""
        words = self._words
        tail = words[_TAIL]
        self._seen_head = _mem.load_acquire(words, _HEAD)
        count = (self._seen_head - tail) & _M64
        if count == 0 or count > self.capacity:
            return 0
        return _RECORDS + (tail - self._start & self._mask) * _WORDS

    def release(self, count: int) -> None:
        """Give `count` oldest records back to the producer."""
        words = self._words
        tail = (words[_TAIL] + count) & _M64
        _mem.store_release(words, _TAIL, tail)
        if self._shared:
            self._wake_producer(tail)
        if self.free_listener is not None:
            free = self.free()
            if free >= self.free_threshold > free - count:
                self.free_listener()

    def take_frame(self) -> Frame | None:
        """The oldest record as a frame, or None when the ring is empty."""
        if self.record_size != _RECORD_SIZE:
            self._refuse_frames()
        at = self.front()
        if at == 0:
            return None
        frame = codec.frame_at(self._words, at)
        self.release(1)
        return frame

    def take_frames(self, limit: int) -> list[Frame]:
        """Up to `limit` oldest records as frames."""
        if self.record_size != _RECORD_SIZE:
            self._refuse_frames()
        frames = []
        count = max(0, min(limit, self.fill()))
        first = self._words[_TAIL] - self._start
        for k in range(count):
            frames.append(codec.frame_at(self._words, _RECORDS + (first + k & self._mask) * _WORDS))
        if count:
            self.release(count)
        return frames

    def take_bytes(self) -> bytes | None:
        """The oldest record as 80 bytes, or None when the ring is empty."""
        blocks = self.acquire(1)
        if not blocks:
            return None
        record = bytes(blocks[0])
        self.release(1)
        return record

    def acquire(self, limit: int) -> list[memoryview]:
        """Up to `limit` oldest records as one or two blocks of the ring's own memory, nothing copied.

        The blocks are dead once `release` has given the records back.
        """
        count = max(0, min(limit, self.fill()))
        first = int(self._words[_TAIL]) - self._start & self._mask
        until_wrap = min(count, self._mask + 1 - first)
        blocks = []
        for start, length in ((first, until_wrap), (0, count - until_wrap)):
            if length:
                at = HEADER_SIZE + start * self.record_size
                blocks.append(self._buffer[at : at + length * self.record_size])
        return blocks

    def acquire_free(self, limit: int) -> memoryview:
        """Up to `limit` free records, as many as lie in one piece, in the ring's own memory; `commit` hands them on."""
        free = self.free()
        first = self._next_slot(free)
        count = max(0, min(limit, free, self._mask + 1 - first))
        at = HEADER_SIZE + first * self.record_size
        return self._buffer[at : at + count * self.record_size]

    def commit(self, count: int) -> None:
        """Let the consumer have the first `count` records written into what `acquire_free` gave."""
        before = self.capacity - self.free()
        head = (int(self._words[_HEAD]) + count) & _M64
        _mem.store_release(self._words, _HEAD, head)
        self._told(head, before, count)

    def take_array(self, limit: int) -> numpy.ndarray:
        """Up to `limit` oldest records as one numpy array of record_dtype(), copied in one or two moves."""
        if self.record_size != _RECORD_SIZE:
            self._refuse_frames()
        numpy = load_numpy()
        blocks = [numpy.frombuffer(block, _PLAIN) for block in self.acquire(limit)]
        count = sum(map(len, blocks))
        array = numpy.empty(count, record_dtype())
        if count:
            numpy.concatenate(blocks, out=array.view(_PLAIN))
            self.release(count)
        return array

    def put_array(self, records: numpy.ndarray) -> int:
        """Append as many of these records as fit, in one or two moves; returns how many did."""
        if self.record_size != _RECORD_SIZE:
            self._refuse_frames()
        numpy = load_numpy()
        room = self.free()
        count = min(len(records), room)
        first = self._next_slot(room)
        until_wrap = min(count, self._mask + 1 - first)
        slots = numpy.frombuffer(self._buffer, _PLAIN, self._mask + 1, HEADER_SIZE)
        plain = records.view(_PLAIN)
        slots[first : first + until_wrap] = plain[:until_wrap]
        slots[: count - until_wrap] = plain[until_wrap:count]
        del slots
        self.commit(count)
        return count

    def clear(self) -> int:
        """Drop all records in the ring; returns their number."""
        count = self.fill()
        if count:
            self.release(count)
        return count

    def sleep(self, timeout: float | None, ended: Callable[[], bool] | None = None) -> bool:
        """Wait on `event` until at least `threshold` records are there; False on timeout (seconds).

        Each signal of `event` makes it call `ended`, whose True ends the waiting, too.
        """
        return self._sleep(_WANTED, self.event, timeout, ended)

    def sleep_until_free(self, timeout: float | None, ended: Callable[[], bool] | None = None) -> bool:
        """Wait on `free_event` until at least `free_threshold` records fit; False on timeout (seconds)."""
        return self._sleep(_FREE_WANTED, self.free_event, timeout, ended)

    def arm(self) -> None:
        """Have `event` signalled once, at the next write that leaves at least `threshold` records.

        A write since this end last looked (`fill`, or taking) counts as the next and signals immediately.
        """
        waiting = (self._seen_head - self._words[_TAIL]) & _M64
        missing = self.threshold
        if waiting <= self.capacity:
            missing -= waiting
        self._arm(_WANTED, _HEAD, self._seen_head, missing)

    def arm_once(self) -> None:
        """`arm`, unless it is armed already."""
        if self._words[_WANTED] == 0:
            self.arm()

    def arm_free(self) -> None:
        """Have `free_event` signalled once, at the next take that leaves room for `free_threshold` records.

        A take since this end last looked (`free`, or writing) counts as the next and signals immediately.
        """
        waiting = (self._words[_HEAD] - self._seen_tail) & _M64
        missing = self.free_threshold
        if waiting <= self.capacity:
            missing -= self.capacity - waiting
        self._arm(_FREE_WANTED, _TAIL, self._seen_tail, missing)

    def disarm(self) -> None:
        """The consumer is awake: no signal for it."""
        self._words[_WANTED] = 0

    def close(self) -> None:
        """Release the shared memory: this end is then full and empty. A second call does nothing.

        Blocks from `acquire` stay valid while a program holds them.
        """
        if self._shared:
            own = own_memory(ring_size(1, self.record_size))
            before, self._shared = self._buffer, False
            self.capacity = self._mask = 0
            self._words = _mem.words_of(own)
            self._buffer = own
            del before  # last: compiled, another thread may look at the words until now

    def _next_slot(self, free: int) -> int:
        """The slot of the next record written, when so many are free."""
        head = self._words[_HEAD]
        if free == self.capacity and not self._shared:
            self._start = head
        return head - self._start & self._mask

    def _put_other(self, record: bytes | bytearray | memoryview) -> bool:
        room = self.acquire_free(1)
        if not room:
            self._words[_LOST] = (int(self._words[_LOST]) + 1) & _M64
            return False
        room[:] = record
        self.commit(1)
        return True

    def _told(self, head: int, before: int, count: int) -> None:
        if self._shared:
            self._wake_consumer(head)
        if self.listener is not None and before < self.threshold <= before + count:
            self.listener()

    def _refuse_frames(self) -> None:
        raise BadValue(f"this ring holds elements of {self.record_size} bytes: they go in and out as bytes")

    def _arm(self, wanted: int, counter: int, seen: int, missing: int) -> None:
        """Ask for a signal when the other side's counter has gone so far beyond what was seen, one step at least."""
        if missing < 1:
            missing = 1
        goal = (seen + missing) & _M64
        if goal == 0:  # which would mean: no signal; better one too early than none
            goal = _M64
        self._words[wanted] = goal
        _mem.fence()
        if (_mem.load_acquire(self._words, counter) - goal) & _M64 <= _LARGEST_CAPACITY:
            self._signal(wanted)  # it got there before it could see what is wanted

    def _sleep(
        self, wanted: int, event: Signalled | None, timeout: float | None, ended: Callable[[], bool] | None
    ) -> bool:
        if event is None:
            raise CanwireError("this end of the ring has no event descriptor to wait on")
        settled = partial(self._settled, wanted)
        return event.wait_for(settled if ended is None else lambda: settled() or ended(), timeout, RECHECK_S)

    def _settled(self, wanted: int) -> bool:
        """There is nothing to wait for; otherwise the other side knows from now on that somebody waits."""
        if self._ready(wanted):
            self._words[_WANTED if wanted == _WANTED else _FREE_WANTED] = 0
            return True
        if wanted == _WANTED:
            self.arm()
        else:
            self.arm_free()
        return False

    def _ready(self, wanted: int) -> bool:
        return self.fill() >= self.threshold if wanted == _WANTED else self.free() >= self.free_threshold

    def _signal(self, wanted: int) -> None:
        event = self.event if wanted == _WANTED else self.free_event
        if event is not None:
            self._words[wanted] = 0
            event.signal()

    def _wake_consumer(self, head: int) -> None:
        _mem.fence()
        wanted = self._words[_WANTED]
        if wanted and (head - wanted) & _M64 <= _LARGEST_CAPACITY:
            self._signal(_WANTED)

    def _wake_producer(self, tail: int) -> None:
        _mem.fence()
        wanted = self._words[_FREE_WANTED]
        if wanted and (tail - wanted) & _M64 <= _LARGEST_CAPACITY:
            self._signal(_FREE_WANTED)


def own_memory(size: int) -> memoryview:
    """Anonymous memory, which costs nothing until it is written to; a forked child has a separate copy."""
    if not hasattr(mmap, "MAP_PRIVATE"):
        return memoryview(mmap.mmap(-1, size))
    memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    if hasattr(mmap, "MADV_NOHUGEPAGE"):
        with suppress(OSError):  # a kernel without such pages
            memory.madvise(mmap.MADV_NOHUGEPAGE)  # else the first record would cost two megabytes
    return memoryview(memory)


def rounded_capacity(capacity: int) -> int:
    """The next power of two; raises BadValue outside 1..2**24."""
    if not isinstance(capacity, int) or capacity < 1 or capacity > LARGEST_CAPACITY:
        raise BadValue(f"ring capacity {capacity!r}: 1 to {LARGEST_CAPACITY} records")
    return 1 << (capacity - 1).bit_length()


def ring_size(capacity: int, record_size: int = RECORD_SIZE) -> int:
    """Bytes that a ring of this capacity takes, up to whole words."""
    return HEADER_SIZE + (capacity * record_size + 7 & ~7)
