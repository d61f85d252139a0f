"""Everything a hub owns: time, buses, boards, FIFOs, and the sessions of its clients. No I/O, one thread at a time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from canwire.boards import catalogue
from canwire.boards.board import Board, BoardLinLine
from canwire.boards.can.connector import CanLine
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BusConfig
from canwire.boards.description import BoardInfo
from canwire.boards.isa import IsaBus, IsaPlace
from canwire.boards.outside import check_unused, identified, when_heard_of
from canwire.bus.can.bus import CanBus
from canwire.bus.lin.bus import LinBus
from canwire.bus.medium import one_way_delay_ps
from canwire.errors import BadValue, NoSuchBoard, Unplugged, Unsupported
from canwire.held_time import HeldTime
from canwire.hub.owner.bench import Bench
from canwire.hub.owner.faults.book import FaultBook
from canwire.hub.owner.held.bells import Bells
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.owner.held.lin import LinSlot
from canwire.hub.owner.held.line import LineSlot
from canwire.hub.owner.held.pipes import Pipes
from canwire.hub.owner.lockstep.keeper import Lockstep
from canwire.hub.owner.lockstep.turns import Turns
from canwire.hub.owner.notes import Notes
from canwire.hub.owner.rates import RateWatch
from canwire.hub.owner.reactor import LaterReactor
from canwire.hub.owner.serials import Serials
from canwire.hub.owner.session import Session
from canwire.hub.protocol.messages import BoardsChanged
from canwire.timeline import NEVER, Timeline
from canwire.values.controller_options import USUAL, ControllerOptions
from canwire.values.timing.bit_timing import BitTiming

if TYPE_CHECKING:
    from canwire.drivers.outside import Identity

_UNHEALTHY_NS = 10_000_000
_MOST_BOARDS = 256  # whose lines are reported in one reply
_CLOCK_HZ = 80_000_000
_SHORTEST_BITS = 20  # nothing on a bus fills a receive queue quicker: the shortest error frame
_LOW_WATER = 4  # a queue with less than its capacity by this much free holds up fast time


class World:
    """The state that all sessions share. With `turns` it is in lockstep time with the programs that take part."""

    def __init__(
        self, config: Config, *, virtual: bool = False, bench: Bench | None = None, turns: Turns | None = None
    ) -> None:
        self._bench = bench or Bench(Timeline(), HeldTime(), {}, {})
        self.timeline, self.held = self._bench.timeline, self._bench.held
        self.virtual = virtual or turns is not None
        self.lockstep = None if turns is None else Lockstep(self.timeline, self.held, turns, self)
        self.buses: dict[str, CanBus | LinBus] = {}
        self.reactor = None if self.virtual else LaterReactor()
        self.machine = catalogue.Machine(self.timeline, self.buses, IsaBus(), self.reactor)
        self._can_buses: list[CanBus] = []
        self.sessions: list[Session] = []
        self.boards: dict[int, Board] = {}
        self.slots: dict[tuple[int, int], CanSlot | LinSlot] = {}
        rates = {bus.name: bus.usual_rate for bus in config.bus}
        self.faults = FaultBook(self.timeline, self.buses, self.boards, self.slots, rates, self._bench.faults)
        self.pipes = Pipes()
        self.warn: Callable[[str], object] = lambda text: None  # gets what people should know, in sentences
        # how many ns bus time is behind the clock, and how many were left out; the pace knows
        self.lateness: Callable[[], tuple[int, int]] = lambda: (0, 0)
        self.bells: Bells | None = None  # of an engine that rings them
        self.clear_until_ns = 0  # until then of bus time no receive queue can overflow; fast time's own
        self.limits = config.limits
        self.notes = Notes(config.limits)
        self._luid = 0
        self.rates = RateWatch()
        self._serials = Serials(board.serial for board in config.board)
        for bus in config.bus:
            self.add_bus(bus)
        for board in config.board:
            self.plug(
                board.kind,
                board.serial,
                board.buses,
                board.place,
                real=board.access == "port",
                port=board.port,
                options=board.options,
            )

    # sessions

    def close_session(self, session: Session) -> None:
        """End a session and all its leases; a second call has no effect."""
        if session in self.sessions:
            self.sessions.remove(session)
            session.close()
            self.notes.leave(session)
            if self.lockstep is not None:
                self.lockstep.gone(session)
            for hardware_id, temporary in session.plugged.items():
                if temporary and hardware_id in self._serials:
                    self.unplug(hardware_id)

    def kick(self, session: Session) -> None:
        """Serve the lines of a client that wrote into its transmit queues, or read from a full receive queue."""
        for line in session.sending_lines():
            line.line.kick()

    def kick_all(self) -> None:
        for session in self.sessions:
            self.kick(session)

    # boards

    def infos(self) -> tuple[BoardInfo, ...]:
        """All boards, in the order of plugging."""
        return tuple(board.info for board in self.boards.values())

    def plug(
        self,
        kind: str,
        serial: str = "",
        buses: tuple[str, ...] = (),
        place: IsaPlace | None = None,
        *,
        real: bool = False,
        port: str = "",
        options: ControllerOptions = USUAL,
    ) -> BoardInfo:
        """Plug a board in; raises NoSuchBoard for an unknown kind or bus, BadValue for a serial that is in use.

        `place` and `real` are for ISA boards, `port` is for adapters, `options` for boards with ideal controllers
        (catalogue.build); raises InUse if another board has this place.
        """
        if port:
            check_unused(port, self.boards.values())
        serial = self._serials.check(serial) if serial else self._serials.free()
        built = catalogue.build(
            catalogue.kind(kind),
            self.next_luid(),
            serial,
            buses,
            self.machine,
            place,
            real=real,
            port=port,
            options=options,
        )
        self.boards[built.info.id] = built
        self._serials.take(serial)
        for number, slot in enumerate(built.lines):
            self.slots[built.info.id, number] = (
                LinSlot(built.info.id, slot.line)
                if isinstance(slot, BoardLinLine)
                else CanSlot(built.info.id, CanLine(slot))
            )
        self.rates.plugged(built)
        when_heard_of(built, partial(self._identified, built.info.id), lambda text: self.warn(text))
        self._changed()
        return built.info

    def unplug(self, hardware_id: str) -> None:
        """Pull a board out: its handles become invalid, and their holders get a notice. Raises NoSuchBoard."""
        board = next((b for b in self.boards.values() if b.info.hardware_id == hardware_id), None)
        if board is None:
            there = ", ".join(info.hardware_id for info in self.infos()) or "none"
            raise NoSuchBoard(f"no board {hardware_id!r} to unplug; plugged in: {there}")
        self.faults.board_gone(board)
        del self.boards[board.info.id]
        self._serials.give_back(hardware_id)
        text = f"board {hardware_id} ({board.info.kind}) was unplugged"
        catalogue.pull(board, self.machine)
        for number in range(len(board.lines)):
            self.slots.pop((board.info.id, number)).close(Unplugged(text))
        self.rates.unplugged(board)
        for session in list(self.sessions):
            session.board_gone(board.info.id, text)
            session.plugged.pop(hardware_id, None)
        self._changed()

    def board(self, board_id: int) -> Board:
        """The board with this id; raises NoSuchBoard."""
        try:
            return self.boards[board_id]
        except KeyError:
            raise NoSuchBoard(f"no board with id {board_id}; it may have been unplugged") from None

    def line_slot(self, board_id: int, line: int) -> LineSlot:
        """A line of any kind with its holders; raises NoSuchBoard."""
        board = self.board(board_id)
        if (board_id, line) not in self.slots:
            raise NoSuchBoard(f"{board.info.hardware_id} has lines 0 to {len(board.lines) - 1}, not {line}")
        return self.slots[board_id, line]

    def slots_of(self, boards: Sequence[int]) -> list[tuple[tuple[int, int], LineSlot]]:
        """All lines of the existing ones of these boards, by board and line; raises BadValue for too many boards."""
        if len(boards) > _MOST_BOARDS:
            raise BadValue(f"the lines of {len(boards)} boards: at most {_MOST_BOARDS} in one request")
        there = (self.boards[board] for board in boards if board in self.boards)
        places = [(board.info.id, line) for board in there for line in range(len(board.lines))]
        return [(place, self.slots[place]) for place in places]

    def can_slot(self, board_id: int, line: int) -> CanSlot:
        """A CAN line; raises NoSuchBoard, or Unsupported for a LIN line."""
        found = self.line_slot(board_id, line)
        if not isinstance(found, CanSlot):
            raise Unsupported(f"{found.name} is a LIN line: it has no channels, filters and cyclic list")
        return found

    def lin_slot(self, board_id: int, line: int) -> LinSlot:
        """A LIN line; raises NoSuchBoard, or Unsupported for a CAN line."""
        found = self.line_slot(board_id, line)
        if not isinstance(found, LinSlot):
            raise Unsupported(f"{found.name} is a CAN line: it has no monitors and schedules")
        return found

    def short(self, name: str, shorted: bool) -> None:
        """Short the two wires of a CAN bus, or a LIN bus to ground; or remove this short. Raises NoSuchBoard."""
        if shorted:
            self.faults.shorts.put(name, self)
        else:
            self.faults.shorts.take(name, self)

    def look_at_rates(self, bus: str) -> None:
        """After a start of a line on this bus, or a fault: warn once about lines that could not work together."""
        slots = (slot for slot in self.slots.values() if isinstance(slot, CanSlot))
        for text in self.rates.news(bus, slots):
            self.warn(text)

    def next_luid(self) -> int:
        """A new number, never returned before."""
        self._luid += 1
        return self._luid

    # for the hub's pace

    def look_anew(self) -> None:
        """A client has begun or ended to receive: discard the results about receive queues."""
        self.clear_until_ns = 0

    def healthy(self) -> bool:
        """True if no bus repeats unacknowledged frames and no node babbles: fast time may run ahead of the clock."""
        if self.faults.babbled():
            return False
        for bus in (*self._can_buses, *self.faults.stubs()):
            if bus.busy():
                last_ns = max(bus.tally.last_success_ns, bus.busy_since_ns())
                if self.timeline.now_ns - last_ns >= _UNHEALTHY_NS:
                    return False
        return True

    def stalled(self) -> bool:
        """True if a receive queue is nearly full; its reader signals the doorbell when it has made room."""
        found = False
        for session in self.sessions:
            for ring in session.receive_rings():
                if ring.free() * _LOW_WATER < ring.capacity:
                    ring.free_threshold = max(1, ring.capacity // 2)
                    ring.arm_free()
                    found = True
        return found

    def horizon_ns(self) -> int:
        """Bus time that can pass before any receive queue could overflow; NEVER without receive queues."""
        room = [ring.free() for session in self.sessions for ring in session.receive_rings()]
        if not room:
            return NEVER
        quickest = min((node.bit_ps for bus in self._can_buses for node in bus.nodes), default=1_000_000)
        return max(1, min(room)) * _SHORTEST_BITS * quickest // 1000

    def add_bus(self, config: BusConfig) -> None:
        given = self._bench.buses.get(config.name)
        if given is not None:
            self.buses[config.name] = given
            self._can_buses += [given] if isinstance(given, CanBus) else []
            return
        if config.type == "lin":
            self.buses[config.name] = LinBus(self.timeline, config.name)
            return
        bus = CanBus(self.timeline, config.name)
        timing = BitTiming.for_bit_rate(config.usual_rate, clock_hz=_CLOCK_HZ)
        bus.delay_ps = one_way_delay_ps(timing, config.length_m, config.node_delay_ns)
        self.buses[config.name] = bus
        self._can_buses.append(bus)

    def _identified(self, board_id: int, identity: Identity) -> None:
        """An adapter has reported its identity."""
        if (board := self.boards.get(board_id)) is not None:
            self.boards[board_id] = replace(board, info=identified(board.info, identity))
            self._changed()

    def _changed(self) -> None:
        for session in self.sessions:
            if session.watching:
                session.notify(BoardsChanged())
