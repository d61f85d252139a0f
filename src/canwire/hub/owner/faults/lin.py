"""Creates the faults of one LIN bus that programs request."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from canwire.boards.catalogue import plug_lin, unplug_lin
from canwire.boards.islands import Islands
from canwire.boards.lin.line import LinLine
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.faults import LinFaults
from canwire.bus.scripted import Scripted
from canwire.errors import BadValue, Unsupported
from canwire.hub.owner.faults.lines import LinesOf
from canwire.hub.owner.faults.shorts import Shorts
from canwire.hub.protocol import fault_messages as f

_NUMBERS = {"checksum": 0, "no_response": 0, "cut": 1, "stop_bit": 1, "flip": 2, "parity": 0, "short_break": 1,
            "sync": 1}  # fmt: skip


class LinBusFaults:
    """The faults of one bus. `begin` raises BadValue, NoSuchBoard or Unsupported for an impossible fault."""

    def __init__(self, bus: LinBus, lines: LinesOf, shorts: Shorts, faults: LinFaults) -> None:
        self._bus = bus
        self._lines = lines
        self._shorts = shorts
        self._faults = faults
        self._islands: Islands[LinLine, LinBus] = Islands(bus.timeline, LinBus, plug_lin, unplug_lin)
        self._pulled: list[LinLine] = []
        self._makers: dict[type[object], Callable[[Any], Scripted]] = {
            f.LinFrames: self._frames,
            f.Short: self._short,
            f.Disconnect: self._disconnect,
        }

    def begin(self, fault: f.Fault) -> Scripted:
        """Begin a fault; `cancel` of the result undoes it."""
        make = self._makers.get(type(fault))
        if make is None:
            raise Unsupported(f"{self._bus.name} is a LIN bus: it knows no {type(fault).__name__}")
        return make(fault)

    def _frames(self, fault: f.LinFrames) -> Scripted:
        if len(fault.numbers) != _NUMBERS.get(fault.kind, -1):
            raise BadValue(f"LIN fault {fault.kind!r} with {fault.numbers}: one of {', '.join(_NUMBERS)}")
        make = getattr(self._faults, fault.kind)
        made: Scripted = make(*fault.numbers, frame_id=fault.frame_id, times=fault.times)
        return made

    def _short(self, fault: f.Short) -> Scripted:
        by = object()
        self._shorts.put(self._bus.name, by, fault.to)
        return Scripted(times=None, struck=1, remove=lambda _: self._shorts.take(self._bus.name, by))

    def _disconnect(self, fault: f.Disconnect) -> Scripted:
        line = self._lines.lin(fault.line)
        self._pulled.append(line)
        self._islands.pull(line, line.name)

        def put_back(_: Scripted) -> None:
            self._pulled.remove(line)
            if line not in self._pulled:
                self._islands.put_back(line, lambda each: plug_lin(each, self._bus))

        return Scripted(times=None, struck=1, remove=put_back)
