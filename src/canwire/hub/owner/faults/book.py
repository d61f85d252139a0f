"""All faults on the buses of a hub: setting, listing, waiting and cancelling."""

from __future__ import annotations

from collections.abc import Mapping

from canwire.boards.board import Board
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.faults import LinFaults
from canwire.errors import BadValue, NoSuchBoard, Unsupported
from canwire.hub.owner.faults.can import CanFaults
from canwire.hub.owner.faults.lin import LinBusFaults
from canwire.hub.owner.faults.lines import LinesOf
from canwire.hub.owner.faults.live import LiveFault
from canwire.hub.owner.faults.shorts import Shorts
from canwire.hub.owner.faults.text import kind_of, text_of
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.owner.held.held import Holder
from canwire.hub.owner.held.lin import LinSlot
from canwire.hub.protocol import fault_messages as f
from canwire.timeline import Timeline
from canwire.values.timing.bit_timing import BitTiming

_MOST = 256
_CLOCK_HZ = 80_000_000
_LONGEST_NS = 1 << 60
WHOSE = ("mine", "left", "all")


class FaultBook:
    """Faults by number. The faults of a program end with it unless they are persistent."""

    def __init__(
        self,
        timeline: Timeline,
        buses: Mapping[str, CanBus | LinBus],
        boards: Mapping[int, Board],
        slots: Mapping[tuple[int, int], CanSlot | LinSlot],
        rates: Mapping[str, int],
        scripts: Mapping[str, Faults | LinFaults],
    ) -> None:
        self.shorts = Shorts(buses, slots)
        self._timeline = timeline
        self._buses = buses
        self._boards = boards
        self._slots = slots
        self._rates = rates
        self._scripts = scripts
        self._on: dict[str, CanFaults | LinBusFaults] = {}
        self._faults: dict[int, LiveFault] = {}
        self._last = 0

    def bus_type(self, name: str) -> str:
        """ "CAN" or "LIN"; raises NoSuchBoard, or Unsupported for the bus of a real adapter."""
        if name in self._buses:
            return "CAN" if isinstance(self._buses[name], CanBus) else "LIN"
        for board in self._boards.values():
            for line in board.lines:
                real = line.info.bus not in self._buses and line.info.bus_type == "CAN"
                if name in (line.line.name, line.info.bus, dict(board.info.resources).get("Port")) and real:
                    raise Unsupported(
                        f"{name}: {board.info.hardware_id} is a real adapter on a real bus, where the hub "
                        "cannot set faults; it can on its simulated buses"
                    )
        raise NoSuchBoard(f"no bus {name!r}; there are {', '.join(self._buses) or 'none'}")

    def set(
        self, bus: str, fault: f.Fault, setter: Holder, lasting_ns: int | None, persistent: bool
    ) -> LiveFault:
        """Begin a fault; raises what `bus_type` and the fault itself raise, BadValue if the hub has too many faults."""
        self.bus_type(bus)
        if lasting_ns is not None and not 0 < lasting_ns <= _LONGEST_NS:
            raise BadValue(f"lasting {lasting_ns / 1e9:g} s: longer than 0")
        self._make_room()
        effect = self._faults_on(bus).begin(fault)
        self._last += 1
        now_ns = self._timeline.now_ns
        live = LiveFault(
            self._last, bus, kind_of(fault), text_of(fault), setter, persistent, now_ns, effect, _lines(fault)
        )
        self._faults[live.number] = live
        effect.listener = lambda: self._struck(live)
        if lasting_ns is not None:
            live.timer = self._timeline.at(now_ns + lasting_ns, lambda: live.end("its time was over"))
        return live

    def release(self, live: LiveFault) -> None:
        """The program of this fault has closed it, or has ended."""
        if not live.persistent:
            live.end("its program closed it or ended")
            self._faults.pop(live.number, None)

    def cancel(self, live: LiveFault) -> None:
        """The program of this fault cancels it."""
        live.end("cancelled")
        self._faults.pop(live.number, None)

    def on(self, bus: str) -> tuple[f.FaultInfo, ...]:
        """The faults of one bus, in the order in which they were set."""
        self.bus_type(bus)
        return tuple(live.info() for live in self._faults.values() if live.bus == bus)

    def clear(self, bus: str, whose: str, who: Holder) -> int:
        """End the faults of this program, persistent ones, or all; returns how many had not ended before."""
        self.bus_type(bus)
        if whose not in WHOSE:
            raise BadValue(f"whose {whose!r}: one of {', '.join(WHOSE)}")
        ended = 0
        for live in list(self._faults.values()):
            mine = live.setter is who
            if live.bus == bus and (whose == "all" or (whose == "left" and live.persistent) or mine):
                ended += not live.over
                live.end("cancelled" if mine else f"cleared by {who.name}")
                self._faults.pop(live.number)
        return ended

    def board_gone(self, board: Board) -> None:
        """The board is about to be pulled out: lines that a fault had disconnected return to their bus first."""
        names = {line.line.name for line in board.lines}
        for live in list(self._faults.values()):
            if names & live.lines:
                live.end(f"board {board.info.hardware_id} was unplugged")

    def stubs(self) -> list[CanBus]:
        """The stubs with the CAN lines that a fault has disconnected."""
        return [stub for on in self._on.values() if isinstance(on, CanFaults) for stub in on.stubs()]

    def babbled(self) -> bool:
        """True if a node babbles, which would keep time running without end."""
        return any(isinstance(on, CanFaults) and on.babbled() for on in self._on.values())

    def _struck(self, live: LiveFault) -> None:
        if live.effect.times == 0:  # the bus is in the midst of its step: waits are answered afterwards
            self._timeline.at(self._timeline.now_ns, live.used_up)

    def _faults_on(self, name: str) -> CanFaults | LinBusFaults:
        if name not in self._on:
            bus, lines = self._buses[name], LinesOf(name, self._boards, self._slots)
            script = self._scripts.get(name)
            if isinstance(bus, CanBus):
                usual = BitTiming.for_bit_rate(self._rates.get(name, 500_000), clock_hz=_CLOCK_HZ)
                faults = script if isinstance(script, Faults) else Faults(bus, seed=0)
                self._on[name] = CanFaults(bus, lines, self.shorts, usual, faults)
            else:
                lin_faults = script if isinstance(script, LinFaults) else LinFaults(bus)
                self._on[name] = LinBusFaults(bus, lines, self.shorts, lin_faults)
        return self._on[name]

    def _make_room(self) -> None:
        """If there are too many faults, remove the oldest one that is over."""
        if len(self._faults) >= _MOST:
            oldest = next((live for live in self._faults.values() if live.over), None)
            if oldest is None:
                raise BadValue(f"the hub has {_MOST} faults already; clear some")
            del self._faults[oldest.number]


def _lines(fault: f.Fault) -> frozenset[str]:
    """The lines that this fault needs."""
    named = {getattr(fault, "line", ""), *getattr(fault, "seen_by", ())}
    at = getattr(fault, "at", None)
    if isinstance(at, f.HubPlace):
        named.add(at.line)
    return frozenset(named - {"", "all", "receivers", "sender"})
