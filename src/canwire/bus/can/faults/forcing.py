"""Disturbances anywhere on the wire: a level held, a glitch, an edge moved, for one node, several or all.

`Forcing` turns a script's disturbances into stimuli: at a time, or when a node reaches a place. Frames that a placed
disturbance can affect run bit by bit; all others are stepped over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext

from canwire.bus.can import station
from canwire.bus.can.bus import CanBus
from canwire.bus.can.clock import Clock
from canwire.bus.can.faults.disturbance import SIGNS, Changes, Disturbance, Timed, level_of, stimulus_of
from canwire.bus.can.faults.places import FRAME, Place, Progress, indices
from canwire.bus.can.node import Mailbox, Node
from canwire.bus.can.stimulus import FREE, Stimulus
from canwire.bus.scripted import Scripted
from canwire.errors import BadValue
from canwire.values.checks import LONGEST_NS, whole
from canwire.values.frame import Frame, frame_of_record

_FOREVER = 1 << 36  # bits: years at any rate
When = Place | int | None


class Forcing:
    """Levels that a script forces on one bus; faults.py and the lab build on it."""

    def __init__(self, bus: CanBus) -> None:
        self._bus = bus
        self._placed: list[Disturbance] = []
        self._progress: dict[Node, Progress] = {}
        self._frame: Frame | None = None
        self._sender: Node | None = None
        self._indices: dict[int, int] = {}

    def place(
        self,
        part: str,
        bit: int = 1,
        *,
        frame_id: int | None = None,
        extended: bool | None = None,
        node: object = None,
    ) -> Place:
        """The start of a bit, for `at`: "frame" (from 0, SOF), a field ("data", "ack", "eof" ...), or "error flag",
        "overload flag", "error delimiter", "overload delimiter", "intermission", "suspend", "idle" (from 1).
        `node` is the node whose bits count, by default the sender.
        """
        return Place(part, bit, frame_id, extended, None if node is None else self._controller(node))

    def hold(
        self,
        level: str,
        *,
        at: When = None,
        bits: int | None = 1,
        seen_by: object = "all",
        times: int | None = 1,
    ) -> Scripted:
        """Hold the bus "dominant" or "recessive" for `bits` bits, from a place or a time in ns on (None: from now).

        `bits` None: until it is cancelled. `seen_by`: "all" (it is on the wire then, and in a trace), "receivers",
        "sender", one node or several. `times`: how often it strikes at the place (None: no limit).
        """
        if bits is not None and (not isinstance(bits, int) or bits < 1):
            raise BadValue(f"bits {bits!r}: at least 1, or None until it is cancelled")
        held, span = level_of(level), _FOREVER if bits is None else bits
        often = None if bits is None else times
        return self._add(at, lambda bit, _: [(0, held), (span * bit, FREE)], seen_by, often)

    def play(
        self, levels: str, *, at: When = None, seen_by: object = "all", times: int | None = 1
    ) -> Scripted:
        """Force one level per bit: "0" dominant, "1" recessive, "-" for the level that the nodes drive."""
        if not levels or set(levels) - set(SIGNS):
            raise BadValue(f"levels {levels!r}: 0, 1 or - for each bit")
        signs = [SIGNS[sign] for sign in levels]

        def shape(bit: int, _: int) -> Changes:
            return [*((k * bit, sign) for k, sign in enumerate(signs)), (len(signs) * bit, FREE)]

        return self._add(at, shape, seen_by, times)

    def glitch(
        self, level: str, *, at: When = None, from_ns: float = 0.0, width_ns: float, seen_by: object = "all",
        times: int | None = 1,
    ) -> Scripted:  # fmt: skip
        """Force a level for less (or more) than a bit: for this duration, `from_ns` after the place or time."""
        if from_ns < 0 or not width_ns > 0:
            raise BadValue(f"from_ns {from_ns}, width_ns {width_ns}: not negative, and wider than 0")
        forced, start_ps, width_ps = level_of(level), round(from_ns * 1000), round(width_ns * 1000)
        return self._add(at, lambda *_: [(start_ps, forced), (start_ps + width_ps, FREE)], seen_by, times)

    def move_edge(
        self, quanta: int, *, at: Place, to: str = "dominant", seen_by: object = "all", times: int | None = 1
    ) -> Scripted:
        """Move the edge at the start of a frame's bit, which leads `to` this level, by `quanta` (> 0 later, < 0
        earlier).

        The bit must have such an edge: only the time between the old place and the new one is forced.
        """
        if (
            not isinstance(at, Place)
            or at.part != FRAME
            or at.bit < 1
            or not isinstance(quanta, int)
            or not quanta
        ):
            raise BadValue(
                f"an edge is moved by quanta (not 0) at a bit of a frame from 1 on, not {quanta!r}, {at!r}"
            )
        new = level_of(to)
        if quanta > 0:
            return self._add(at, lambda _, quantum: [(0, 1 - new), (quanta * quantum, FREE)], seen_by, times)
        before = Place(FRAME, at.bit - 1, at.frame_id, at.extended, at.node)
        return self._add(
            before, lambda bit, quantum: [(bit + quanta * quantum, new), (bit, FREE)], seen_by, times
        )

    def forget_placed(self) -> None:
        """Cancel all disturbances at places."""
        for placed in [*self._placed]:
            placed.cancel()

    # what the lab overrides

    def _controller(self, node: object) -> Node:
        """The controller of the node that a script named; raises BadValue if it is no node."""
        if not isinstance(node, Node):
            raise BadValue(f"{node!r} is no node")
        return node

    def _touch(self) -> AbstractContextManager[object]:
        """A context that is held while the disturbances change."""
        return nullcontext()

    # at work

    def _viewers(self, seen_by: object) -> str | list[Node]:
        if isinstance(seen_by, str):
            if seen_by not in ("all", "receivers", "sender"):
                raise BadValue(f"seen_by {seen_by!r}: nodes, or one of all, receivers, sender")
            return seen_by
        nodes = seen_by if isinstance(seen_by, Iterable) else [seen_by]
        return [self._controller(node) for node in nodes]

    def _add(
        self, at: When, shape: Callable[[int, int], Changes], seen_by: object, times: int | None
    ) -> Scripted:
        viewers = self._viewers(seen_by)
        if times is not None and times < 1:
            raise BadValue(f"times {times}: at least 1, or None for no limit")
        with self._touch():
            if isinstance(at, Place):
                placed = Disturbance(at, shape, viewers, times=times, remove=self._forget_place)
                self._placed.append(placed)
                self._arm()
                return placed
            at_ns = self._bus.timeline.now_ns if at is None else at
            return self._at_time(at_ns, shape, viewers, None if times is None else 1)

    def _at_time(
        self, at_ns: int, shape: Callable[[int, int], Changes], viewers: str | list[Node], times: int | None
    ) -> Timed:
        """Add a disturbance at a time, with the bit time and quantum of the first node on the bus."""
        timeline = self._bus.timeline
        at_ns = whole("at", at_ns, 0, LONGEST_NS)
        if at_ns < timeline.now_ns:
            raise BadValue(f"at {at_ns} ns: the bus's time is {timeline.now_ns} ns already")
        if viewers != "all" and isinstance(viewers, str):
            raise BadValue(f"seen_by {viewers!r} at a time: nodes or all; only at a place somebody sends")
        clock = self._bus.nodes[0] if self._bus.nodes else Node()
        changes = shape(clock.bit_ps, clock.quantum_ps)
        timed = Timed(times=times, remove=self._end)

        def begin() -> None:
            timed.stimulus = stimulus_of(at_ns * 1000, changes, None if isinstance(viewers, str) else viewers)
            self._bus.stimulate(timed.stimulus)
            timed.strike()

        timed.timer = timeline.at(at_ns + changes[0][0] // 1000, begin)
        return timed

    def _end(self, timed: Timed) -> None:
        """End a cancelled disturbance, before it begins or while it lasts."""
        with self._touch():
            if timed.timer is not None:
                timed.timer.cancel()
            stimuli = self._bus.bits.stimuli
            if timed.stimulus in stimuli:
                stimuli.remove(timed.stimulus)
                now_ps = self._bus.timeline.now_ns * 1000
                self._bus.stimulate(Stimulus([now_ps], [FREE], timed.stimulus.nodes))

    def _forget_place(self, placed: Disturbance) -> None:
        with self._touch():
            self._placed = [each for each in self._placed if each is not placed]
            self._arm()

    def _arm(self) -> None:
        """Take note of added or removed places; those in a frame that is already on the wire count, too."""
        bits = self._bus.bits
        if self._placed:
            self._bus.descend()
            self._look_around()
            self._aim()
        bits.watch = self._begin_bit if self._placed else None
        bits.pinned = bits.pinned and bool(self._placed)
        self._choose_frames()

    def _look_around(self) -> None:
        """Find the sender; and the position of all nodes, if their bits were not watched up to now."""
        bits = self._bus.bits
        if bits.watch is None:
            self._progress = {clock.node: Progress(clock) for clock in bits.clocks}
            self._sender = self._frame = None
        for clock in bits.clocks:
            if clock.station.transmitting:
                self._sender = clock.node
                if clock.station.transmits():
                    self._frame = frame_of_record(clock.station.sent.block)

    def _choose_frames(self) -> None:
        """Give the bus the function that decides which frames must run bit by bit."""
        self._bus.scripted = self._awaits if self._placed else None

    def _awaits(self, box: Mailbox) -> bool:
        self._frame = frame = frame_of_record(box.block)
        return any(disturbance.place.admits(frame) for disturbance in self._placed)

    def _begin_bit(self, clock: Clock, at_ps: int) -> None:
        """Process the start of a node's next bit, with the disturbances placed there."""
        machine, node = clock.station, clock.node
        progress = self._progress.setdefault(node, Progress())
        progress.begin_bit(clock)
        sends = machine.state == station.FRAME and machine.transmitting
        if sends and (node is not self._sender or machine.index <= 1):
            self._follow(node)
        if self._bus.bits.undisturbed:
            return
        for disturbance in [*self._placed]:
            if self._reached(disturbance.place, node, progress):
                self._set_off(disturbance, clock, at_ps)
        if self._bus.bits.pinned and not self._pins():
            self._bus.bits.pinned = False

    def _follow(self, sender: Node) -> None:
        """Note that this node is now the sender of the frame."""
        self._sender = sender
        self._frame = None if sender.contending is None else frame_of_record(sender.contending.block)
        self._aim()

    def _aim(self) -> None:
        """Compute at which bits of the sender's frame the places are."""
        self._indices = indices([each.place for each in self._placed], self._frame, self._sender)
        self._bus.bits.pinned = self._pins()

    def _pins(self) -> bool:
        """Whether a disturbance is placed where the bus would already be at rest."""
        if self._sender is None:
            return False
        at = self._progress.get(self._sender)
        return any(
            disturbance.place.outlasts_the_frame()
            and disturbance.place.admits(self._frame)
            and not (at is not None and at.part == "idle" and at.bit > max(disturbance.place.bit, 8))
            for disturbance in self._placed
        )

    def _reached(self, place: Place, node: Node, progress: Progress) -> bool:
        if node is not (place.node or self._sender) or not place.admits(self._frame):
            return False
        if progress.part == FRAME:
            return self._indices.get(id(place), -1) == progress.bit
        return progress.part == place.part and progress.bit == place.bit

    def _set_off(self, disturbance: Disturbance, clock: Clock, at_ps: int) -> None:
        node = clock.node
        bit_ps, quantum_ps = (
            (node.data_bit_ps, node.data_quantum_ps) if clock.data_rate else (node.bit_ps, node.quantum_ps)
        )
        bits = self._bus.bits
        stimulus = stimulus_of(at_ps, disturbance.shape(bit_ps, quantum_ps), self._seen(disturbance.seen_by))
        bits.stimulate(stimulus, at_ps - bits.offset_ps())
        disturbance.strike()
        if disturbance.times == 0:
            self._placed.remove(disturbance)
            if not self._placed:
                bits.watch = None
            self._choose_frames()

    def _seen(self, seen_by: str | list[Node]) -> list[Node] | None:
        if isinstance(seen_by, list):
            return seen_by
        if seen_by == "all":
            return None
        return [node for node in self._bus.nodes if (node is self._sender) == (seen_by == "sender")]
