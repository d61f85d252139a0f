"""Board kinds by name, and the code that puts chips on buses (for a chip whose outputs float: transceiver.py).

A package adds a kind by an entry point of the group `canwire.boards` that names a BoardKind:

    [project.entry-points."canwire.boards"]
    my-board = "my_package.boards:MY_BOARD"

It is loaded when that kind is first used; the kinds of kinds.py cannot be replaced.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

from canwire.boards.board import CAN, IDEAL, LIN, MCP2515, SJA1000, Board, BoardKind, BoardLine, BoardLinLine
from canwire.boards.can.line import Line
from canwire.boards.description import BoardInfo, LineInfo
from canwire.boards.inducan104 import OSCILLATOR_HZ, BoardPorts, InduCan104, checked_place
from canwire.boards.isa import IsaBus, IsaPlace
from canwire.boards.kinds import KINDS as KINDS
from canwire.boards.lin.line import LinLine
from canwire.boards.transceiver import Transceiver
from canwire.bus.can.bus import CanBus
from canwire.bus.can.node import Bus, Node
from canwire.bus.lin.bus import LinBus
from canwire.chips.ideal.can_fd import CanFdController
from canwire.chips.mcp2515.controller import Mcp2515
from canwire.chips.sja1000.controller import Sja1000
from canwire.drivers.can_fd import CanFdDriver
from canwire.drivers.lin import LinControllerDriver
from canwire.drivers.mcp2515.driver import Mcp2515Driver
from canwire.drivers.outside import Reactor
from canwire.drivers.sja1000.driver import Sja1000Driver
from canwire.drivers.sja1000.polled import port_driver
from canwire.errors import BadValue, NoSuchBoard, Unsupported
from canwire.timeline import Timeline
from canwire.values.controller_options import USUAL, ControllerOptions

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint, EntryPoints

GROUP = "canwire.boards"
_BUS_CLASSES: dict[str, type[CanBus] | type[LinBus]] = {CAN: CanBus, LIN: LinBus}


def kind_names() -> list[str]:
    """The names of all kinds; this does not load the kinds of other packages."""
    return sorted({*KINDS, *(point.name for point in _plug_ins())})


def kind(name: str) -> BoardKind:
    """The kind of that name; raises NoSuchBoard with the known names, or with the reason why it cannot be loaded."""
    if name in KINDS:
        return KINDS[name]
    for point in _plug_ins():
        if point.name == name:
            return _loaded(point)
    raise NoSuchBoard(f"no board kind {name!r}; there are {', '.join(kind_names())}")


def _plug_ins() -> EntryPoints:
    from importlib.metadata import entry_points  # it takes as long as all of the lab, and few need it

    return entry_points(group=GROUP)


def _loaded(point: EntryPoint) -> BoardKind:
    try:
        found = point.load()
    except Exception as error:  # somebody else's code: anything may come
        raise NoSuchBoard(
            f"board kind {point.name!r}: its plug-in {point.value} does not load "
            f"({type(error).__name__}: {error}); repair or remove the package that provides it"
        ) from error
    if not isinstance(found, BoardKind) or found.name != point.name:
        what = f"the kind {found.name!r}" if isinstance(found, BoardKind) else repr(found)
        raise NoSuchBoard(
            f"board kind {point.name!r}: its plug-in {point.value} is {what}, not a BoardKind of that name"
        )
    return found


class Machine(NamedTuple):
    """What boards are plugged into: a timeline, buses by name, ISA slots, and a reactor, which adapters need."""

    timeline: Timeline
    buses: Mapping[str, CanBus | LinBus]
    isa: IsaBus
    reactor: Reactor | None = None


def build(
    kind: BoardKind,
    board_id: int,
    hardware_id: str,
    bus_names: Sequence[str],
    machine: Machine,
    place: IsaPlace | None = None,
    *,
    real: bool = False,
    port: str = "",
    options: ControllerOptions = USUAL,
) -> Board:
    """A board of this kind with its controllers on these buses, one per line (none named: the kind's default ones).

    `place` is the address and IRQ that an ISA board's jumpers select (None: as delivered); a `real` board is driven
    through /dev/port. `port` is an adapter's port. `options` configure its controllers, and only ideal ones.
    Nothing is running yet. Raises BadValue, NoSuchBoard for a bus that does not exist, Unsupported for a line of
    a type that no bus has, InUse for a place that another board has; nothing is plugged in then.
    """
    if (place is not None or real) and not kind.isa:
        raise BadValue(f"{kind.name} has no address, interrupt line and ports")
    buses = machine.buses
    if kind.isa:
        place = place or checked_place()
        machine.isa.check(hardware_id, place)
    info = kind.info(board_id, hardware_id, kind.bus_names(bus_names, buses), place)
    if kind.outside or port:
        return _outside_board(info, port, machine)
    for line in info.lines:
        if line.bus:
            _check_bus(kind, line, buses)
    names = [f"{hardware_id}:{index}" for index in range(len(info.lines))]
    if place is not None:
        return _isa_board(names[0], info, place, machine, real)
    return Board(
        info,
        tuple(
            _plugged(name, line, connector.controller, machine, options)
            for name, line, connector in zip(names, info.lines, kind.connectors, strict=True)
        ),
    )


def _outside_board(info: BoardInfo, port: str, machine: Machine) -> Board:
    from canwire.boards import outside  # sockets, serial ports, python-can: nothing that a lab needs

    outside.checked_port(info.kind, port)
    return outside.outside_board(info, port, machine.timeline, machine.reactor)


def _check_bus(kind: BoardKind, line: LineInfo, buses: Mapping[str, CanBus | LinBus]) -> None:
    if line.bus not in buses:
        there = ", ".join(buses) or "none"
        raise NoSuchBoard(f"{kind.name}: no bus {line.bus!r} for {line.name}; there are {there}")
    if not isinstance(buses[line.bus], _BUS_CLASSES.get(line.bus_type, ())):
        raise Unsupported(f"{kind.name}: {line.name} needs a {line.bus_type} bus, which {line.bus!r} is not")


def _plugged(
    name: str, info: LineInfo, controller: str, machine: Machine, options: ControllerOptions
) -> BoardLine | BoardLinLine:
    """Make a line for this connector, on its bus."""
    timeline, bus = machine.timeline, machine.buses.get(info.bus)
    if bus is None:  # alone on a private bus, which is removed with the line
        bus = LinBus(timeline) if info.bus_type == LIN else CanBus(timeline)
    if isinstance(bus, LinBus):
        lin = ideal_lin_line(name, timeline)
        plug_lin(lin, bus)
        return BoardLinLine(info, lin)
    line = LINE_MAKERS[controller](name, timeline)
    plug(line, bus)
    return BoardLine(info, line, bus, options)


def _isa_board(name: str, info: BoardInfo, place: IsaPlace, machine: Machine, real: bool) -> Board:
    """An INduCAN104: its driver reaches the chip through the machine's ports, or a real one through the real ports."""
    line = Line(name, machine.timeline)
    if real:
        line.connect(port_driver(line, place.base, machine.timeline), Node())
        return Board(info, (BoardLine(info.lines[0], line, Bus()),))
    chip = Sja1000(None, OSCILLATOR_HZ)
    Transceiver(chip, machine.timeline)
    card = InduCan104(place.base, place.irq, chip, shared_irq=place.shared_irq)
    machine.isa.plug(info.hardware_id, card)
    driver = Sja1000Driver(
        line, BoardPorts(machine.isa, place.base), lambda: machine.timeline.now_ns, peek=chip.peek
    )
    machine.isa.connect(place.irq, driver.service)
    line.connect(driver, chip)
    bus = machine.buses[info.lines[0].bus]
    assert isinstance(bus, CanBus)
    plug(line, bus)
    return Board(info, (BoardLine(info.lines[0], line, bus),), card)


def pull(board: Board, machine: Machine) -> None:
    """Unplug the board, if necessary in the middle of a frame; a second call does nothing."""
    for slot in board.lines:
        home = slot.bus if isinstance(slot, BoardLine) else slot.line.controller.bus
        if isinstance(slot, BoardLinLine):
            unplug_lin(slot.line)
        elif slot.line.controller.bus is not None:
            unplug(slot.line)
            slot.line.driver.stop(slot.line.timeline.now_ns)
        else:
            slot.line.driver.close()
        if not slot.info.bus and isinstance(home, (CanBus, LinBus)):
            machine.timeline.remove(home)
    if board.card is not None and board.info.hardware_id in machine.isa.cards:
        driver = board.lines[0].line.driver
        assert isinstance(driver, Sja1000Driver)
        machine.isa.disconnect(board.card.place.irq, driver.service)
        machine.isa.unplug(board.info.hardware_id)


def sja1000_line(name: str, timeline: Timeline, *, ppm: float = 0.0) -> Line:
    """A line with an SJA1000 at 16 MHz (off by `ppm`) and its driver, not yet on any bus."""
    line = Line(name, timeline)
    chip = Sja1000(None, OSCILLATOR_HZ)
    chip.oscillator_ppm = ppm
    chip.name = name
    Transceiver(chip, timeline)
    driver = Sja1000Driver(line, chip, lambda: timeline.now_ns, peek=chip.peek)
    chip.on_interrupt = driver.service
    line.connect(driver, chip)
    return line


def ideal_line(name: str, timeline: Timeline) -> Line:
    """A line with the ideal CAN FD controller and its driver, not yet on any bus."""
    line = Line(name, timeline)
    controller = CanFdController(line)
    line.connect(CanFdDriver(line, controller), controller)
    return line


def mcp2515_line(name: str, timeline: Timeline, *, ppm: float = 0.0) -> Line:
    """A line with an MCP2515 at 16 MHz and its driver, not yet on any bus."""
    line = Line(name, timeline)
    chip = Mcp2515(None, OSCILLATOR_HZ)
    chip.oscillator_ppm = ppm
    chip.name = name
    driver = Mcp2515Driver(line, chip, lambda: timeline.now_ns, oscillator_hz=OSCILLATOR_HZ, peek=chip.peek)
    chip.on_interrupt = driver.service
    line.connect(driver, chip)
    return line


def ideal_lin_line(name: str, timeline: Timeline) -> LinLine:
    """A line with the ideal LIN controller and its driver, not yet on any bus."""
    line = LinLine(name, timeline)
    line.controller.name = name
    line.driver = LinControllerDriver(line.controller)
    return line


def plug_lin(line: LinLine, bus: LinBus) -> None:
    """Put a LIN line's controller on a bus."""
    bus.attach(line.controller)


def unplug_lin(line: LinLine) -> None:
    """Remove a LIN line's controller from its bus, whichever bus that is."""
    bus = line.controller.bus
    if isinstance(bus, LinBus):
        bus.detach(line.controller)


def listener(name: str, bus: Bus, timeline: Timeline) -> Line:
    """An ideal line on this bus that listens; `unplug` removes it. Raises Unsupported if the bus is no CAN bus."""
    if not isinstance(bus, CanBus):
        raise Unsupported(f"{name}: there is no CAN bus to listen to")
    line = ideal_line(name, timeline)
    plug(line, bus)
    return line


def is_shorted(bus: Bus) -> bool:
    """Whether the two wires of a CAN bus are shorted."""
    return isinstance(bus, CanBus) and bool(bus.bits.shorted)


def load_of(bus: Bus, now_ns: int) -> float:
    """Busy bit times over elapsed ones in the last second, 0..100 %."""
    return bus.account().percent(now_ns) if isinstance(bus, CanBus) else 0.0


def plug(line: Line, bus: CanBus) -> None:
    """Put a line's controller on a bus."""
    bus.attach(line.controller)


def unplug(line: Line) -> None:
    """Remove a line's controller from its bus, whichever bus that is."""
    if isinstance(line.controller, Sja1000) and line.controller.transceiver is not None:
        line.controller.transceiver.go_home()
    bus = line.controller.bus
    if isinstance(bus, CanBus):
        bus.detach(line.controller)


LINE_MAKERS: dict[str, Callable[[str, Timeline], Line]] = {
    IDEAL: ideal_line,
    SJA1000: sja1000_line,
    MCP2515: mcp2515_line,
}
"""By what a connector has: a line with that controller and its driver, not yet on any bus."""
