"""Faults that the page sets on a bus, `Hub.bus(...).faults`; they end at the latest with this server."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

from canwire import BadValue, CanBusFaults, Hub, HubFault, every_line

if TYPE_CHECKING:
    from canwire.web.fields import Fields

_ERRORS = ("stuff", "form", "crc", "bit", "ack")


class Shown(NamedTuple):
    """A fault on a bus: `number` cancels it if this server set it (else 0)."""

    bus: str
    number: int
    text: str
    setter: str
    struck: str


def _flip(faults: CanBusFaults, fields: Fields) -> HubFault:
    bit = fields.whole("bit", 0, 1000)
    identifier, times = _which(fields)
    fields.check()
    return faults.flip(bit=bit, frame_id=identifier, times=times)


def _inject(faults: CanBusFaults, fields: Fields) -> HubFault:
    error = fields.choice("error", _ERRORS)
    identifier, times = _which(fields)
    fields.check()
    return faults.inject(error, frame_id=identifier, times=times)


def _which(fields: Fields) -> tuple[int | None, int]:
    """Return the identifier (None: any) and the number of times."""
    identifier = fields.hexadecimal("id", 0, 0x1FFFFFFF) if fields.text("id") else None
    return identifier, fields.whole("times", 1, 1_000_000)


def _noise(faults: CanBusFaults, fields: Fields) -> HubFault:
    rate = fields.real("noise", 0.0000001, 1)
    fields.check()
    return faults.noise(rate)


def _disconnect(faults: CanBusFaults, fields: Fields) -> HubFault:
    line = fields.text("line", empty=False)
    fields.check()
    return faults.disconnect(line)


def _wrong_rate(faults: CanBusFaults, fields: Fields) -> HubFault:
    line, rate = fields.text("line", empty=False), fields.whole("rate", 1000, 1_000_000)
    fields.check()
    return faults.wrong_rate(line, rate)


def _short(faults: CanBusFaults, fields: Fields) -> HubFault:
    fields.check()
    return faults.short()


KINDS: dict[str, Callable[[CanBusFaults, Fields], HubFault]] = {
    "flip": _flip,
    "inject": _inject,
    "noise": _noise,
    "disconnect": _disconnect,
    "wrong-rate": _wrong_rate,
    "short": _short,
}


class Faults:
    """The faults that this server has set, for use by any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._set: dict[int, HubFault] = {}
        self._next = 1

    def put(self, hub: Hub, bus: str, kind: str, fields: Fields) -> None:
        """Set a fault. Raises BadFields for wrong values, NoSuchBoard for an unknown bus, BadValue for an impossible
        fault."""
        fault = KINDS[kind](hub.bus(bus).faults, fields)
        with self._lock:
            self._set[self._next] = fault
            self._next += 1

    def shown(self, hub: Hub) -> list[Shown]:
        """Return all present faults of all buses, set by any program."""
        with self._lock:
            self._set = {number: fault for number, fault in self._set.items() if not fault.over}
            mine = {fault.info().number: number for number, fault in self._set.items()}
        return [
            Shown(bus, mine.get(info.number, 0), info.text, info.setter, str(info.struck))
            for bus in sorted({place.info.bus for place in every_line(hub, "CAN")} - {""})
            for info in hub.bus(bus).faults.list()
            if not info.over
        ]

    def cancel(self, number: int) -> None:
        """Cancel a fault; raises BadValue if this server did not set it, or it has ended."""
        with self._lock:
            if number not in self._set:
                raise BadValue(f"fault {number} is over, or was set by another program")
            self._set.pop(number).cancel()

    def forget(self) -> None:
        """Forget all faults, which ended with the hub."""
        with self._lock:
            self._set.clear()
