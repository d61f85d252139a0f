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
from typing import TYPE_CHECKING

from canwire import _mem
from canwire.errors import BadValue, CanwireError
from canwire.values import frame as codec
from canwire.values.frame import Frame
from canwire.values.record import RECORD_SIZE, record_dtype

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


class Ring:
    """A ring in this process's memory; `Ring.create` and `Ring.attach` put it into shared memory.

    `threshold` (1..capacity) is the fill level whose crossing wakes the consumer, `free_threshold`
    the free count whose crossing wakes the producer: by calling `listener` / `free_listener` here,
    or through the event descriptor of `sleep` across processes.
    """

    def __init__(self, capacity: int, *, buffer: memoryview | None = None) -> None:
        if not isinstance(capacity, int) or capacity < 1 or capacity > 1 << 24:
            raise BadValue(f"ring capacity {capacity!r}: 1 to {1 << 24} records")
        self.capacity = 1 << (capacity - 1).bit_length()
        self._mask = self.capacity - 1
        self._buffer = buffer if buffer is not None else memoryview(bytearray(ring_size(self.capacity)))
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
        """A ring in new shared memory of this name; `close` by its creator removes it."""
        from canwire.platform import create_shared_memory

        memory = create_shared_memory(name, ring_size(1 << (capacity - 1).bit_length()))
        ring = cls(capacity, buffer=memory.buf)
        ring._memory = memory
        return ring

    @classmethod
    def attach(cls, name: str) -> Ring:
        """The ring that another process created; raises FileNotFoundError, or BadValue if it is none."""
        from canwire.platform import attach_shared_memory

        memory = attach_shared_memory(name)
        head = memory.buf[:24].cast("Q")
        magic, capacity, words = head
        head.release()
        sane = magic == MAGIC and words == _WORDS and 0 < capacity <= 1 << 24 and capacity & (capacity - 1) == 0
        if not sane or memory.size < ring_size(capacity):
            memory.close()
            raise BadValue(f"shared memory {name!r} holds no ring of this version")
        ring = cls(capacity, buffer=memory.buf)
        ring._memory = memory
        return ring

    def fill(self) -> int:
        """Records that wait for the consumer."""
        count = _mem.load_acquire(self._words, _HEAD) - _mem.load_acquire(self._words, _TAIL)
        return count if 0 <= count <= self.capacity else 0

    def free(self) -> int:
        """Records that the producer can still write."""
        count = _mem.load_acquire(self._words, _HEAD) - _mem.load_acquire(self._words, _TAIL)
        return self.capacity - count if 0 <= count <= self.capacity else 0

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
        fill = head - _mem.load_acquire(words, _TAIL)
        if fill < 0 or fill >= self.capacity:
            words[_LOST] += 1
            return False
        slot = _RECORDS + (head & self._mask) * _WORDS
        _mem.copy_record(words, slot, source, at)
        words[slot] = time_ns
        words[slot + 1] = head_word
        _mem.store_release(words, _HEAD, head + 1)
        if self._shared:
            self._wake_consumer(head + 1)
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
        if _mem.load_acquire(words, _HEAD) - tail <= 0:
            return 0
        return _RECORDS + (tail & self._mask) * _WORDS

    def release(self, count: int) -> None:
        """Give `count` oldest records back to the producer."""
        words = self._words
        tail = words[_TAIL] + count
        _mem.store_release(words, _TAIL, tail)
        if self._shared:
            self._wake_producer(tail)
        if self.free_listener is not None:
            free = self.capacity - (words[_HEAD] - tail)
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
        count = min(limit, self.fill())
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
        count = min(limit, self.fill())
        first = int(self._words[_TAIL]) & self._mask
        until_wrap = min(count, self.capacity - first)
        blocks = []
        for start, length in ((first, until_wrap), (0, count - until_wrap)):
            if length:
                at = HEADER_SIZE + start * RECORD_SIZE
                blocks.append(self._buffer[at : at + length * RECORD_SIZE])
        return blocks

    def take_array(self, limit: int) -> numpy.ndarray:  # type: ignore[type-arg]
        """Up to `limit` oldest records as one numpy array of record_dtype(), copied in one or two moves."""
        import numpy

        blocks = [numpy.frombuffer(block, record_dtype()) for block in self.acquire(limit)]
        if not blocks:
            return numpy.empty(0, record_dtype())
        array = numpy.concatenate(blocks) if len(blocks) > 1 else blocks[0].copy()
        self.release(len(array))
        return array

    def put_array(self, records: numpy.ndarray) -> int:  # type: ignore[type-arg]
        """Append as many of these records as fit, in one or two moves; returns how many did."""
        import numpy

        count = min(len(records), self.free())
        start = int(self._words[_HEAD])
        first = start & self._mask
        until_wrap = min(count, self.capacity - first)
        slots = numpy.frombuffer(self._buffer, record_dtype(), self.capacity, HEADER_SIZE)
        slots[first : first + until_wrap] = records[:until_wrap]
        slots[: count - until_wrap] = records[until_wrap:count]
        del slots
        _mem.store_release(self._words, _HEAD, start + count)
        if self._shared:
            self._wake_consumer(start + count)
        if self.listener is not None and count:
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
        self._buffer = memoryview(bytearray(ring_size(1)))
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
            return max(1, int(self._words[_TAIL]) + self.threshold)
        return max(1, int(self._words[_HEAD]) + self.free_threshold - self.capacity)

    def _wake_consumer(self, head: int) -> None:
        _mem.fence()
        wanted = self._words[_WANTED]
        if wanted and head >= wanted and self.event is not None:
            self.event.signal()

    def _wake_producer(self, tail: int) -> None:
        _mem.fence()
        wanted = self._words[_FREE_WANTED]
        if wanted and tail >= wanted and self.free_event is not None:
            self.free_event.signal()


def ring_size(capacity: int) -> int:
    """Bytes that a ring of this capacity takes."""
    return HEADER_SIZE + capacity * RECORD_SIZE
