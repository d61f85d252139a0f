"""Creates the faults of one CAN bus that programs request."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from canwire.boards.can.connector import CanLine
from canwire.boards.catalogue import plug, unplug
from canwire.boards.islands import Islands
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.bus.can.faults.places import Place
from canwire.bus.can.node import Node
from canwire.bus.medium import one_way_delay_ps
from canwire.bus.scripted import Scripted
from canwire.drivers.driver import LineSettings
from canwire.errors import BadValue, NotInitialised, Unsupported
from canwire.hub.owner.faults.babble import Babbler
from canwire.hub.owner.faults.lines import LinesOf
from canwire.hub.owner.faults.shorts import Shorts
from canwire.hub.protocol import fault_messages as f
from canwire.values.frame import frame_of_record
from canwire.values.timing.bit_timing import BitTiming

_LARGEST_PPM = 100_000


class CanFaults:
    """The faults of one bus. `begin` raises BadValue, NoSuchBoard or Unsupported for an impossible fault.

    `usual` is the bit timing to use while no line runs. If several faults disconnect one line, or replace the cable,
    each has its effect until it is cancelled.
    """

    def __init__(self, bus: CanBus, lines: LinesOf, shorts: Shorts, usual: BitTiming, faults: Faults) -> None:
        self._bus = bus
        self._lines = lines
        self._shorts = shorts
        self._usual = usual
        self._faults = faults
        self._islands: Islands[Any, CanBus] = Islands(bus.timeline, CanBus, plug, unplug)
        self._pulled: list[CanLine] = []
        self._delays = [bus.delay_ps]
        self._babbling: list[Scripted] = []
        self._makers: dict[type[object], Callable[[Any], Scripted]] = {
            f.Flip: self._flip,
            f.Noise: lambda fault: self._faults.add_noise(fault.bit_error_rate),
            f.Hold: self._hold,
            f.Play: self._play,
            f.Glitch: self._glitch,
            f.MoveEdge: self._move_edge,
            f.Short: self._short,
            f.Disconnect: self._disconnect,
            f.Drift: self._drift,
            f.WrongRate: self._wrong_rate,
            f.Cable: self._cable,
            f.Babble: self._babble,
        }

    def begin(self, fault: f.Fault) -> Scripted:
        """Begin a fault; `cancel` of the result undoes it."""
        make = self._makers.get(type(fault))
        if make is None:
            raise Unsupported(f"{self._bus.name} is a CAN bus: it knows no {type(fault).__name__}")
        return make(fault)

    def stubs(self) -> list[CanBus]:
        """The stubs with the lines that a fault has disconnected."""
        return self._islands.stubs()

    def babbled(self) -> bool:
        """True if a node babbles."""
        return any(each.times != 0 for each in self._babbling)

    # on the wire

    def _node(self, line: str) -> Node:
        node: Node = self._lines.can(line).line.controller
        return node

    def _seen_by(self, names: f.SeenBy) -> str | list[Node]:
        if len(names) == 1 and names[0] in ("all", "receivers", "sender"):
            return names[0]
        if not names:
            raise BadValue("seen_by (): all, receivers, sender, or lines of this bus")
        return [self._node(name) for name in names]

    def _at(self, at: f.At) -> Place | int | None:
        return self._place(at) if isinstance(at, f.HubPlace) else at

    def _place(self, at: f.HubPlace) -> Place:
        return Place(at.part, at.bit, at.frame_id, at.extended, self._node(at.line) if at.line else None)

    def _flip(self, fault: f.Flip) -> Scripted:
        viewers = self._seen_by(fault.seen_by)
        if isinstance(viewers, list) and len(viewers) > 1:
            raise BadValue(f"seen_by {', '.join(fault.seen_by)}: one line, or all, receivers or sender")
        seen_by = viewers if isinstance(viewers, str) else viewers[0]
        return self._faults.flip(
            bit=fault.bit,
            frame_id=fault.frame_id,
            extended=fault.extended,
            times=fault.times,
            seen_by=seen_by,
        )

    def _hold(self, fault: f.Hold) -> Scripted:
        return self._faults.hold(
            fault.level,
            at=self._at(fault.at),
            bits=fault.bits,
            seen_by=self._seen_by(fault.seen_by),
            times=fault.times,
        )

    def _play(self, fault: f.Play) -> Scripted:
        return self._faults.play(
            fault.levels, at=self._at(fault.at), seen_by=self._seen_by(fault.seen_by), times=fault.times
        )

    def _glitch(self, fault: f.Glitch) -> Scripted:
        return self._faults.glitch(
            fault.level,
            at=self._at(fault.at),
            from_ns=fault.from_ns,
            width_ns=fault.width_ns,
            seen_by=self._seen_by(fault.seen_by),
            times=fault.times,
        )

    def _move_edge(self, fault: f.MoveEdge) -> Scripted:
        return self._faults.move_edge(
            fault.quanta,
            at=self._place(fault.at),
            to=fault.to,
            seen_by=self._seen_by(fault.seen_by),
            times=fault.times,
        )

    # the copper

    def _short(self, fault: f.Short) -> Scripted:
        by = object()
        self._shorts.put(self._bus.name, by, fault.to)
        return _state(lambda _: self._shorts.take(self._bus.name, by))

    def _cable(self, fault: f.Cable) -> Scripted:
        running = self._lines.running()
        timing = self._usual
        if running is not None and running.mode is not None and running.mode.timing is not None:
            timing = running.mode.timing
        delay_ps = one_way_delay_ps(timing, fault.length_m, fault.node_delay_ns)
        self._delays.append(delay_ps)
        self._lay_cable()

        def take_back(_: Scripted) -> None:
            self._delays.remove(delay_ps)
            self._lay_cable()

        return _state(take_back)

    def _lay_cable(self) -> None:
        self._bus.interrupt()
        self._bus.delay_ps = self._bus.bits.delay_ps = self._delays[-1]
        self._bus.changed()

    # single lines

    def _disconnect(self, fault: f.Disconnect) -> Scripted:
        can = self._lines.can(fault.line)
        self._pulled.append(can)
        can.bus = self._islands.pull(can.line, can.line.name)

        def put_back(_: Scripted) -> None:
            self._pulled.remove(can)
            if can not in self._pulled:
                self._islands.put_back(can.line, lambda line: self._go_home(can))

        return _state(put_back)

    def _go_home(self, can: CanLine) -> None:
        can.bus = self._bus
        plug(can.line, self._bus)
        can.line.driver.rejoin(self._bus.timeline.now_ns)
        can.coupling_changed()

    def _drift(self, fault: f.Drift) -> Scripted:
        if not -_LARGEST_PPM <= fault.ppm <= _LARGEST_PPM:
            raise BadValue(f"ppm {fault.ppm}: from -{_LARGEST_PPM} to {_LARGEST_PPM}")
        return self._pull(self._lines.can(fault.line), 1.0 + fault.ppm * 1e-6)

    def _wrong_rate(self, fault: f.WrongRate) -> Scripted:
        can = self._lines.can(fault.line)
        if not 1_000 <= fault.bit_rate <= 1_000_000:
            raise BadValue(f"bit_rate {fault.bit_rate}: from 1,000 to 1,000,000 bit/s")
        if can.mode is None or can.mode.timing is None:
            raise NotInitialised(f"{fault.line} has no bit rate yet that another could take the place of")
        return self._pull(can, float(fault.bit_rate / can.mode.timing.exact_bit_rate))

    def _pull(self, can: CanLine, factor: float) -> Scripted:
        node = can.line.controller
        can.crystal.pull(node, factor)
        return _state(lambda _: can.crystal.release(node, factor))

    def _babble(self, fault: f.Babble) -> Scripted:
        if fault.gap_ns < 0 or (fault.times is not None and fault.times < 1):
            raise BadValue(f"gap_ns {fault.gap_ns}, times {fault.times}: not negative, and at least once")
        frame = frame_of_record(fault.record)
        running = self._lines.running()
        mode = None if running is None else running.mode
        timing = self._usual if mode is None or mode.timing is None else mode.timing
        data = None if mode is None else mode.data_timing
        settings = LineSettings(timing, (data or timing) if frame.fd else data, mode is None or mode.iso_fd)
        babbler = Babbler(self._bus, self._bus.timeline, settings, frame, fault.gap_ns, fault.times)
        self._babbling = [each for each in self._babbling if each.times != 0] + [babbler.babbling]
        return babbler.babbling


def _state(undo: Callable[[Scripted], object]) -> Scripted:
    """A fault that is a lasting condition until it is undone."""
    return Scripted(times=None, struck=1, remove=undo)
