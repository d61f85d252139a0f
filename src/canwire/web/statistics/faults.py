"""Faults that are put on a bus from the page: those of `Hub.bus(...).faults`, or the one that every hub knows, a short.

Whatever is set here ends with this server at the latest.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from canwire import BadValue, Hub, NoSuchBoard, Unplugged, every_line

if TYPE_CHECKING:
    from canwire.web.fields import Fields

_SHORT = "short"
_ERRORS = ("stuff", "form", "crc", "bit", "ack")


class Shown(NamedTuple):
    """A fault that is there: `number` takes it back, where it is this server's (else 0)."""

    bus: str
    number: int
    text: str
    setter: str
    struck: str


def _flip(faults: Any, fields: Fields) -> Any:
    bit = fields.whole("bit", 0, 1000)
    times = fields.whole("times", 1, 1_000_000)
    identifier = fields.hexadecimal("id", 0, 0x1FFFFFFF) if fields.text("id") else None
    fields.check()
    return lambda: faults.flip(bit=bit, frame_id=identifier, times=times)


def _inject(faults: Any, fields: Fields) -> Any:
    error = fields.choice("error", _ERRORS)
    times = fields.whole("times", 1, 1_000_000)
    identifier = fields.hexadecimal("id", 0, 0x1FFFFFFF) if fields.text("id") else None
    fields.check()
    return lambda: faults.inject(error, frame_id=identifier, times=times)


def _noise(faults: Any, fields: Fields) -> Any:
    rate = fields.real("noise", 0.0000001, 1)
    fields.check()
    return lambda: faults.noise(rate)


def _pulled(faults: Any, fields: Fields) -> Any:
    line = fields.text("line", empty=False)
    fields.check()
    return lambda: faults.disconnect(line)


def _wrong_rate(faults: Any, fields: Fields) -> Any:
    line, rate = fields.text("line", empty=False), fields.whole("rate", 1000, 1_000_000)
    fields.check()
    return lambda: faults.wrong_rate(line, rate)


def _short(faults: Any, fields: Fields) -> Any:
    fields.check()
    return faults.short


_MENU: dict[str, Callable[[Any, Fields], Any]] = {
    "flip": _flip,
    "inject": _inject,
    "noise": _noise,
    "disconnect": _pulled,
    "wrong-rate": _wrong_rate,
    _SHORT: _short,
}


class Faults:
    """What this server has set; any thread may ask."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._shorted: dict[str, int] = {}
        self._set: dict[int, Any] = {}
        self._next = 1

    def kinds(self, hub: Hub) -> list[str]:
        """What can be chosen."""
        return list(_MENU) if _can_all(hub) else [_SHORT]

    def put(self, hub: Hub, bus: str, kind: str, fields: Fields) -> None:
        """Raises BadFields for wrong values, NoSuchBoard for no such bus."""
        if bus not in {place.info.bus for place in every_line(hub, "CAN")}:
            raise NoSuchBoard(f"{bus}: there is no such bus any more")
        if _can_all(hub):
            fault = _MENU[kind](_faults(hub, bus), fields)()
            with self._lock:
                self._set[self._next] = fault
                self._next += 1
        elif bus not in self._shorted:
            hub.short(bus)
            with self._lock:
                self._shorted[bus], self._next = self._next, self._next + 1

    def shown(self, hub: Hub) -> list[Shown]:
        """All that are on a bus now."""
        with self._lock:
            if not _can_all(hub):
                return [Shown(bus, number, _SHORT, "", "") for bus, number in self._shorted.items()]
            self._set = {number: fault for number, fault in self._set.items() if not fault.over}
            infos = [(number, fault.info()) for number, fault in self._set.items()]
        mine = {info.number: number for number, info in infos if not info.over}
        return [
            Shown(bus, mine.get(info.number, 0), info.text, info.setter, str(info.struck))
            for bus in sorted({place.info.bus for place in every_line(hub, "CAN")} - {""})
            for info in _faults(hub, bus).list()
            if not info.over
        ]

    def cancel(self, hub: Hub, number: int) -> None:
        """Raises BadValue for one that is not this server's."""
        with self._lock:
            if number in self._set:
                self._set.pop(number).cancel()
                return
            for bus, shorted in list(self._shorted.items()):
                if shorted == number:
                    del self._shorted[bus]
                    hub.short(bus, shorted=False)
                    return
        raise BadValue(f"fault {number} is over, or was set by another program")

    def forget(self) -> None:
        """The hub is gone, and every fault with it."""
        with self._lock:
            self._set.clear()
            self._shorted.clear()

    def end(self, hub: Hub) -> None:
        """Take back what would stay: a short that no program holds."""
        with self._lock:
            for bus in self._shorted:
                try:
                    hub.short(bus, shorted=False)
                except (NoSuchBoard, Unplugged):
                    continue
            self._shorted.clear()


def _can_all(hub: Hub) -> bool:
    return hasattr(hub, "bus")


def _faults(hub: Hub, bus: str) -> Any:
    made: Any = hub
    return made.bus(bus).faults
