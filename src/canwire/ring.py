"""A first-in first-out ring of 80-byte records: one producer, one consumer, any two processes.

    words   writer     what
    0..2    creator    magic and version, capacity in records, words per record
    8       producer   head: records ever written
    9       producer   lost: records dropped because the ring was full
    16      consumer   tail: records ever taken
    17      both       wanted: head at which the consumer sleeps until (0: it is awake)
    24..    both       the same for the producer: tail at which it sleeps until (0: awake)
    32..               records

Each counter has its own 64-byte line and one writer, and only differences count, so they may wrap.
A word read from the other side is never trusted: a fill level above the capacity means that the
peer is broken, and the ring counts as full for the producer and as empty for the consumer.
"""

from __future__ import annotations

from collections.abc import Callable
from mmap import mmap
from typing import TYPE_CHECKING

from canwire import _mem
from canwire.errors import BadValue, CanwireError
from canwire.values import frame as codec
from canwire.values.frame import Frame
from canwire.values.record import RECORD_SIZE, load_numpy, record_dtype

if TYPE_CHECKING:
    from multiprocessing.shared_memory import SharedMemory

    import numpy

    from canwire.platform import EventDescriptor

MAGIC = 0x0001_4757_4E41_4301  # "\x01CANWG", version 1
HEADER_SIZE = 256
_CAPACITY = 1
_RECORD_WORDS = 2
_HEAD = 8
_LOST = 9
_TAIL = 16
_WANTED = 17
_FREE_WANTED = 24
_RECORDS = 32
_WORDS = 10
_M64 = (1 << 64) - 1  # counters wrap; only their differences count
LARGEST_CAPACITY = 1 << 24


class Ring:
    """A ring in this process's memory; `Ring.create` and `Ring.attach` put it into shared memory.

    `threshold` (1..capacity) is the fill level whose crossing wakes the consumer, `free_threshold`
    the free count whose crossing wakes the producer: by calling `listener` / `free_listener` here,
    or through the event descriptor of `sleep` across processes.
    """

    def __init__(self, capacity: int, *, buffer: memoryview | None = None) -> None:
        self.capacity = rounded_capacity(capacity)
        self._mask = self.capacity - 1
        if buffer is not None and buffer.nbytes < ring_size(self.capacity):
            raise BadValue(f"buffer of {buffer.nbytes} bytes: this ring takes {ring_size(self.capacity)}")
        self._buffer = buffer if buffer is not None else memoryview(mmap(-1, ring_size(self.capacity)))
        # anonymous memory costs nothing until it is written to
        self._words = _mem.words_of(self._buffer)
        self._memory: SharedMemory | None = None
        self._shared = buffer is not None
        self.event: EventDescriptor | None = None
        self.free_event: EventDescriptor | None = None
        self.listener: Callable[[], None] | None = None
        self.free_listener: Callable[[], None] | None = None
        self.threshold = 1
        self.free_threshold = 1
        if self._words[0] == 0:
            self._words[_CAPACITY] = self.capacity
            self._words[_RECORD_WORDS] = _WORDS
            self._words[0] = MAGIC

    @classmethod
    def create(cls, name: str, capacity: int) -> Ring:
        """A ring in new shared memory of this name; `close(remove=True)` by its creator removes it."""
        from canwire.platform import create_shared_memory

        memory = create_shared_memory(name, ring_size(rounded_capacity(capacity)))
        ring = cls(capacity, buffer=memory.buf)
        ring._memory = memory
        return ring

    @classmethod
    def attach(cls, name: str) -> Ring:
        """The ring that another process created; raises FileNotFoundError, or BadValue if it is none."""
        from canwire.platform import attach_shared_memory

        memory = attach_shared_memory(name)
        capacity = capacity_of(memoryview(memory.buf))  # type: ignore[arg-type]
        if capacity == 0:
            memory.close()
            raise BadValue(f"shared memory {name!r} holds no ring of this version")
        ring = cls(capacity, buffer=memory.buf)
        ring._memory = memory
        return ring

    def fill(self) -> int:
        """Records that wait for the consumer."""
        count = (_mem.load_acquire(self._words, _HEAD) - _mem.load_acquire(self._words, _TAIL)) & _M64
        return count if count <= self.capacity else 0

    def free(self) -> int:
        """Records that the producer can still write."""
        count = (_mem.load_acquire(self._words, _HEAD) - _mem.load_acquire(self._words, _TAIL)) & _M64
        return self.capacity - count if count <= self.capacity else 0

    @property
    def written(self) -> int:
        return int(self._words[_HEAD])

    @property
    def taken(self) -> int:
        return int(self._words[_TAIL])

    @property
    def lost(self) -> int:
        """Records dropped because the ring was full."""
        return int(self._words[_LOST])

    def put(self, source: _mem.Words, at: int, time_ns: int, head_word: int) -> bool:
        """Append the record at word `at` of `source`, with this time and id/info word; False if full (counted)."""
        words = self._words
        head = words[_HEAD]
        fill = (head - _mem.load_acquire(words, _TAIL)) & _M64
        if fill >= self.capacity:
            words[_LOST] = (words[_LOST] + 1) & _M64
            return False
        slot = _RECORDS + (head & self._mask) * 10  # a literal: the compiler makes shifts of it
        _mem.copy_record(words, slot, source, at)
        words[slot] = time_ns
        words[slot + 1] = head_word
        head = (head + 1) & _M64
        _mem.store_release(words, _HEAD, head)
        if self._shared:
            self._wake_consumer(head)
        if self.listener is not None and fill + 1 == self.threshold:
            self.listener()
        return True

    def put_bytes(self, record: bytes | bytearray | memoryview) -> bool:
        """Append one 80-byte record as it stands; False if full (counted)."""
        if len(record) != RECORD_SIZE:
            raise BadValue(f"a record has {RECORD_SIZE} bytes, not {len(record)}")
        block = bytearray(record)
        source = _mem.words_of(block)
        return self.put(source, 0, source[0], source[1])

    def front(self) -> int:
        """The word where the oldest record starts, or 0 when the ring is empty."""
        words = self._words
        tail = words[_TAIL]
        count = (_mem.load_acquire(words, _HEAD) - tail) & _M64
        if count == 0 or count > self.capacity:
            return 0
        return _RECORDS + (tail & self._mask) * _WORDS

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
        at = self.front()
        if at == 0:
            return None
        frame = codec.frame_at(self._words, at)
        self.release(1)
        return frame

    def take_frames(self, limit: int) -> list[Frame]:
        """Up to `limit` oldest records as frames."""
        frames = []
        tail = self._words[_TAIL]
        count = max(0, min(limit, self.fill()))
        for k in range(count):
            frames.append(codec.frame_at(self._words, _RECORDS + ((tail + k) & self._mask) * _WORDS))
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
        first = int(self._words[_TAIL]) & self._mask
        until_wrap = min(count, self.capacity - first)
        blocks = []
        for start, length in ((first, until_wrap), (0, count - until_wrap)):
            if length:
                at = HEADER_SIZE + start * RECORD_SIZE
                blocks.append(self._buffer[at : at + length * RECORD_SIZE])
        return blocks

    def take_array(self, limit: int) -> numpy.ndarray:
        """Up to `limit` oldest records as one numpy array of record_dtype(), copied in one or two moves."""
        numpy = load_numpy()
        blocks = [numpy.frombuffer(block, record_dtype()) for block in self.acquire(limit)]
        if not blocks:
            return numpy.empty(0, record_dtype())
        array = numpy.concatenate(blocks) if len(blocks) > 1 else blocks[0].copy()
        self.release(len(array))
        return array

    def put_array(self, records: numpy.ndarray) -> int:
        """Append as many of these records as fit, in one or two moves; returns how many did."""
        numpy = load_numpy()
        room = self.free()
        count = min(len(records), room)
        before = self.capacity - room
        start = int(self._words[_HEAD])
        first = start & self._mask
        until_wrap = min(count, self.capacity - first)
        slots = numpy.frombuffer(self._buffer, record_dtype(), self.capacity, HEADER_SIZE)
        slots[first : first + until_wrap] = records[:until_wrap]
        slots[: count - until_wrap] = records[until_wrap:count]
        del slots
        head = (start + count) & _M64
        _mem.store_release(self._words, _HEAD, head)
        if self._shared:
            self._wake_consumer(head)
        if self.listener is not None and before < self.threshold <= before + count:
            self.listener()
        return count

    def clear(self) -> int:
        """Drop everything that waits; returns how many records that were."""
        count = self.fill()
        if count:
            self.release(count)
        return count

    def sleep(self, timeout: float | None) -> bool:
        """Wait on `event` until at least `threshold` records are there; False on timeout (seconds)."""
        return self._sleep(_WANTED, self.event, timeout)

    def sleep_until_free(self, timeout: float | None) -> bool:
        """Wait on `free_event` until at least `free_threshold` records fit; False on timeout (seconds)."""
        return self._sleep(_FREE_WANTED, self.free_event, timeout)

    def close(self, *, remove: bool = False) -> None:
        """Let go of shared memory; its creator passes `remove`. Blocks from `acquire` must be gone."""
        if self._memory is not None:
            memory, self._memory = self._memory, None
            self._detach()
            memory.close()
            if remove:
                memory.unlink()

    def _detach(self) -> None:
        self._buffer = memoryview(mmap(-1, ring_size(1)))
        self._words = _mem.words_of(self._buffer)
        self.capacity = 1
        self._mask = 0
        self._shared = False

    def _sleep(self, wanted: int, event: EventDescriptor | None, timeout: float | None) -> bool:
        if event is None:
            raise CanwireError("this end of the ring has no event descriptor to wait on")
        if self._ready(wanted):
            return True
        self._words[wanted] = self._goal(wanted)
        _mem.fence()
        if self._ready(wanted):
            self._words[wanted] = 0
            return True
        event.wait(timeout)
        self._words[wanted] = 0
        return self._ready(wanted)

    def _ready(self, wanted: int) -> bool:
        return self.fill() >= self.threshold if wanted == _WANTED else self.free() >= self.free_threshold

    def _goal(self, wanted: int) -> int:
        """The counter value of the other side that a sleeper waits for; never 0, which means awake."""
        if wanted == _WANTED:
            goal = int(self._words[_TAIL]) + self.threshold
        else:
            goal = int(self._words[_HEAD]) + self.free_threshold - self.capacity
        return goal & _M64 or 1

    def _wake_consumer(self, head: int) -> None:
        _mem.fence()
        wanted = self._words[_WANTED]
        if wanted and (head - wanted) & _M64 <= LARGEST_CAPACITY and self.event is not None:
            self.event.signal()

    def _wake_producer(self, tail: int) -> None:
        _mem.fence()
        wanted = self._words[_FREE_WANTED]
        if wanted and (tail - wanted) & _M64 <= LARGEST_CAPACITY and self.free_event is not None:
            self.free_event.signal()


def rounded_capacity(capacity: int) -> int:
    """The next power of two; raises BadValue outside 1..2**24."""
    if not isinstance(capacity, int) or capacity < 1 or capacity > LARGEST_CAPACITY:
        raise BadValue(f"ring capacity {capacity!r}: 1 to {LARGEST_CAPACITY} records")
    return 1 << (capacity - 1).bit_length()


def capacity_of(block: memoryview) -> int:
    """The capacity of the ring in this block, or 0 if it holds none of this version that fits."""
    with block:
        if block.nbytes < HEADER_SIZE:
            return 0
        size = block.nbytes
        with block[:24] as first, first.cast("Q") as head:
            magic, capacity, words = head
    sane = magic == MAGIC and words == _WORDS and 0 < capacity <= LARGEST_CAPACITY
    return int(capacity) if sane and not capacity & (capacity - 1) and ring_size(capacity) <= size else 0


def ring_size(capacity: int) -> int:
    """Bytes that a ring of this capacity takes."""
    return HEADER_SIZE + capacity * RECORD_SIZE
