"""The cyclic transmit list of a line: frames that the line sends again and again by itself, one slot per tick.

Source: VCI V4 manual 5.2.5, 6.6.7 and 7.3.17, VCI .NET manual 4.2.5; rulings.md 9.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from canwire.boards.can.channel import Channel
from canwire.boards.can.cyclic_object import CyclicObject, CyclicState, Increment, growing, successor
from canwire.boards.can.line import Line
from canwire.errors import BadValue, Closed, LineError, WrongState
from canwire.timeline import Timeline, Timer
from canwire.values.frame import Frame
from canwire.values.record import HIGH_PRIORITY, SELF_RECEPTION, SINGLE_SHOT

_QUEUE = 64
_LONGEST_NS = 1 << 62  # of the longest cycle: 146 years
_FLAGS = SINGLE_SHOT | HIGH_PRIORITY | SELF_RECEPTION
_NO_TICK = -1


class CyclicList:
    """Up to 16 frames sent cyclically; at most one of them in each tick.

    Tick 0 is the moment of `resume`. An object started in tick s is due in the ticks s + cycle, s + 2 * cycle, ...
    If several are due in the same tick, the one added first is sent; the others use the next free ticks, and
    their later due ticks do not move: cycles 2 and 3 give 2, 4, 6, 8, ... and 3, 7, 9, 13, 15, 19, ...
    An occurrence that the line refuses is discarded and counted in `skipped`; the tick stays used. While the line is
    stopped nothing is due, and nothing of that time comes later (source: rulings.md 38): growing data, counts and
    `skipped` do not change.
    The list is stopped until `resume`. Between its ticks it costs nothing: one background timer waits for the next
    tick in which an object is due. On a paced timeline hold the pacer's lock, and wake it after `resume` and `start`.
    """

    SLOTS = 16

    def __init__(
        self, line: Line, timeline: Timeline, tick_ns: int, max_ticks: int, *, kin: str = ""
    ) -> None:
        """`tick_ns` is a slot's length in ns, from 1; cycles are at most `max_ticks` ticks and 146 years long.

        `kin` is the interface of its program.
        """
        if tick_ns < 1 or max_ticks < 1 or tick_ns * max_ticks > _LONGEST_NS:
            raise BadValue(f"{max_ticks} ticks of {tick_ns} ns: both from 1, together at most 146 years")
        self._line = line
        self._timeline = timeline
        self._tick_ns = tick_ns
        self._max_ticks = max_ticks
        self._kin = kin
        self._objects: dict[
            int, CyclicObject
        ] = {}  # by index, in the order of adding: who comes first in a tick
        self._running = False
        self._closed = False
        self._late = 0
        self._skipped = 0
        self._origin_ns = 0
        self._used = 0
        self._armed = _NO_TICK
        self._timer: Timer | None = None
        self._channels: dict[Channel | None, Channel] = {}  # by whom they send for

    # the objects

    def add(
        self,
        frame: Frame,
        cycle: int,
        *,
        increment: Increment = Increment.NONE,
        byte_index: int = 0,
        flags: int = 0,
        owner: Channel | None = None,
    ) -> int:
        """Put a frame on the list, idle until `start`; returns its index, the lowest one free.

        `cycle` is 1..max_ticks ticks. `byte_index` is where a byte or word to increment begins (the word's
        low byte): 0..length - 1 or 0..length - 2. `flags` are info bits: single shot, high priority, self-reception.
        The frames count as frames of the channel `owner`.
        Raises BadValue for a value out of range and if the sum of 1/cycle over the list would exceed 1,
        LineError for a full list and a frame that the line as it is set up cannot send, Closed.
        """
        self._check_open()
        free = [index for index in range(self.SLOTS) if index not in self._objects]
        if not free:
            raise LineError(f"{self._line.name}: the cyclic transmit list is full; remove an object")
        self._check_cycle(cycle)
        if flags & ~_FLAGS:
            raise BadValue(f"flags {flags:#x}: only single shot, high priority and self-reception")
        grows = growing(frame, increment, byte_index)
        self._check_sendable(frame)
        self._objects[free[0]] = CyclicObject(frame, cycle, flags, grows, self._channel(owner))
        return free[0]

    def replace(self, index: int, frame: Frame) -> None:
        """Send this frame from now on, in the same ticks. Raises BadValue, LineError, Closed like `add`."""
        item = self._object(index)
        if item.growing is not None:
            raise BadValue(
                f"{self._line.name}: the frame at index {index} grows; remove it and add another one"
            )
        self._check_sendable(frame)
        item.frame = frame

    def remove(self, index: int) -> None:
        """Stop an object and remove it from the list; the index is free. Raises BadValue, Closed."""
        self._object(index)
        del self._objects[index]
        self._arm()

    def start(self, index: int, count: int = 0) -> None:
        """Send an object `count` times (1..65535), endlessly for 0; one that is busy starts from the beginning.

        In a stopped list it begins with `resume`. The incremented frame is not reset. An occurrence that
        the line refuses does not count. Raises BadValue, Closed.
        """
        item = self._object(index)
        if not isinstance(count, int) or not 0 <= count <= 65535:
            raise BadValue(f"count {count!r}: from 1 to 65535, or 0 for endless")
        item.state = CyclicState.BUSY
        item.left = count
        if self._running:
            item.due = (self._timeline.now_ns - self._origin_ns) // self._tick_ns + item.cycle
            self._arm()

    def start_in_turn(self, indices: Sequence[int], counts: Sequence[int], step: int) -> None:
        """Send the first object in the next tick, each further one `step` ticks after the one before, then as `start`.

        `counts` is how often each is sent, 0: endlessly. Raises WrongState for a stopped list, BadValue, Closed.
        """
        items = [self._object(index) for index in indices]
        if not self._running:
            raise WrongState(f"{self._line.name}: the cyclic transmit list is stopped; let it run")
        if len(counts) != len(items) or step < 0 or min(counts, default=0) < 0:
            raise BadValue(
                f"counts {counts!r}, step {step}: whole numbers from 0 up, one count for each object"
            )
        first = (self._timeline.now_ns - self._origin_ns) // self._tick_ns + 1
        for place, (item, count) in enumerate(zip(items, counts, strict=True)):
            item.state, item.left, item.due = CyclicState.BUSY, count, first + place * step
        self._arm()

    def stop(self, index: int) -> None:
        """Stop sending an object: it is DONE. Raises BadValue, Closed."""
        self._object(index).state = CyclicState.DONE
        self._arm()

    # the list as a whole

    def resume(self) -> None:
        """Let the list run: all started objects begin in this tick, 0. Does nothing if it runs. Raises Closed."""
        self._check_open()
        if self._running:
            return
        self._running = True
        self._origin_ns = self._timeline.now_ns
        self._used = 0
        for item in self._objects.values():
            item.due = item.cycle
        self._arm()

    def suspend(self) -> None:
        """Stop all objects immediately; frames in the line's queue are still sent. Raises Closed.

        Started objects stay BUSY with the rest of their counts, and start again with `resume`.
        """
        self._check_open()
        self._running = False
        self._arm()

    def reset(self) -> None:
        """Stop the list and empty it; `late` and `skipped` keep their values. Raises Closed."""
        self.suspend()
        self._objects.clear()

    def close(self) -> None:
        """Empty the list and leave the line; a second call does nothing.

        A frame in the controller is still sent; those queued after it are discarded and count as skipped.
        """
        if not self._closed:
            self.reset()
            self._closed = True
            for channel in self._channels.values():
                self._skipped += channel.transmit.fill()
                channel.drop_queued(self._timeline.now_ns)
                self._line.close(channel)

    @property
    def running(self) -> bool:
        """Whether the list runs: after `resume`, until `suspend`."""
        return self._running

    @property
    def late(self) -> int:
        """Occurrences so far that were sent in a later tick than their own, because earlier objects used it."""
        return self._late

    @property
    def skipped(self) -> int:
        """Occurrences so far that never reached the bus: the transmit queue was full, or the line refused them."""
        return self._skipped

    def states(self) -> tuple[int, ...]:
        """CyclicState of all 16 indices. EMPTY: no object, or not started yet; DONE: stopped, or all sent."""
        known = {index: item.state for index, item in self._objects.items()}
        return tuple(int(known.get(index, CyclicState.EMPTY)) for index in range(self.SLOTS))

    # ticks

    def _arm(self) -> None:
        """Set the timer to the next tick in which an object is due."""
        busy = self._busy() if self._running else []
        tick = max(min(item.due for item in busy), self._used + 1) if busy else _NO_TICK
        if tick == self._armed:
            return
        if self._timer is not None:
            self._timer.cancel()
        self._armed = tick
        if busy:
            at_ns = self._origin_ns + tick * self._tick_ns
            self._timer = self._timeline.at(at_ns, self._turn, background=True)

    def _turn(self) -> None:
        tick = self._used = self._armed
        self._armed = _NO_TICK
        self._transmit(next(item for item in self._busy() if item.due <= tick), tick)
        self._arm()

    def _channel(self, owner: Channel | None) -> Channel:
        """The channel that sends for this owner; a channel whose owner has no more objects is used again."""
        if owner not in self._channels:
            wanted = [item.channel for item in self._objects.values()]
            spare = next((old for old, channel in self._channels.items() if channel not in wanted), owner)
            if spare is owner:
                new = Channel(receive_capacity=1, transmit_capacity=_QUEUE, frames=False)
                new.kin = self._kin
                self._channels[owner] = self._line.open(new)
            else:
                self._channels[owner] = self._channels.pop(spare)
            self._channels[owner].stands_for = owner
        return self._channels[owner]

    def _busy(self) -> list[CyclicObject]:
        """The started objects, in the order in which they were added."""
        return [item for item in self._objects.values() if item.state is CyclicState.BUSY]

    def _transmit(self, item: CyclicObject, tick: int) -> None:
        """Send the object's oldest occurrence; an error of the line must not stop the timeline."""
        late = item.due < tick
        item.due += item.cycle
        if not self._line.driver.running:
            return
        try:
            self._line.send(item.channel, item.frame, item.flags)
        except LineError:
            self._skipped += 1
            return
        self._late += late
        if item.growing is not None:
            item.frame = successor(item.frame, *item.growing)
        if item.left:
            item.left -= 1
            if item.left == 0:
                item.state = CyclicState.DONE

    def _check_open(self) -> None:
        if self._closed:
            raise Closed(f"the cyclic transmit list of {self._line.name}")

    def _object(self, index: int) -> CyclicObject:
        self._check_open()
        item = self._objects.get(index)
        if item is None:
            raise BadValue(f"{self._line.name}: nothing at index {index!r} of the cyclic transmit list")
        return item

    def _check_cycle(self, cycle: int) -> None:
        if not isinstance(cycle, int) or not 1 <= cycle <= self._max_ticks:
            raise BadValue(f"cycle {cycle!r}: from 1 to {self._max_ticks} ticks")
        load = sum((Fraction(1, item.cycle) for item in self._objects.values()), Fraction(1, cycle))
        if load > 1:
            raise BadValue(f"cycle {cycle}: the sum of 1/cycle would be {load}, and 1 is all there is")

    def _check_sendable(self, frame: Frame) -> None:
        """Raise errors here for a frame that `Line.send` would refuse in every tick."""
        if self._line.driver.listen_only:
            raise LineError(
                f"{self._line.name}: a listen-only line, or one in restricted operation, sends nothing"
            )
        if frame.fd and self._line.driver.fd == 0:
            raise LineError(f"{self._line.name}: the line is not set up for FD frames; give it a data timing")
        self._line.check(frame, self._kin)
