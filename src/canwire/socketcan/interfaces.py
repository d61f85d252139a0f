"""The interfaces that a program sees, and the lines of the hub that they mean.

can0, can1      the name of a bus: an unused line there, else a shared one
HW000104_0      one line of a board: line 0 of HW000104
vcan0=can0      another name for one of these, as requested
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING

from canwire import BadValue, NoSuchBoard, every_line, find_lines
from canwire.socketcan.constants import CAN_MTU, CANFD_MTU
from canwire.socketcan.table import GONE, OFF, UP, Table

if TYPE_CHECKING:
    from collections.abc import Callable

    from canwire import Hub, LinePlace, WantedMode

# why frames were dropped
WENT, FULL = "sent when the interface went", "sent when its queue was full"
NOT_BOUND, REFUSED = (
    "sent from a socket that is not bound",
    "refused, but sent without the C library, so that no call failed",
)
NOT_FRAMES = "no frames that a controller can send (CAN_ERR_FLAG)"
_NAME = re.compile(r"[^/\s:]{1,15}")


@dataclass
class Interface:
    """One interface; `target` is what `find_lines` knows. `of_all`: sockets bound to all of them receive from it."""

    name: str
    target: str
    index: int
    place: int  # in the table
    of_all: bool
    mtu: int
    line: LinePlace  # one that it may mean
    flags: int = UP
    restart_ms: int = 0  # after bus-off, as netlink has set it; 0: it stays there
    returns: bool = False  # it was up when the hub went
    wanted: WantedMode | None = None  # as netlink has set it; None: the options of `canwire run`


def parse_mapping(text: str) -> tuple[str, str]:
    """The name and the line of "vcan0=can0"; raises BadValue."""
    name, equals, target = text.partition("=")
    if not equals or not target or not _NAME.fullmatch(name):
        raise BadValue(
            f"--interface {text}: NAME=LINE, the name with 1 to 15 characters, no blanks, colons, slashes"
        )
    return name, target


class Interfaces:
    """The present interfaces, which are also in the table."""

    def __init__(self, hub: Hub, table: Table, mappings: dict[str, str]) -> None:
        """Raises NoSuchBoard for a mapping to a line that does not exist."""
        self.hub = hub  # replaced by one that came back
        self._table = table
        self._mapped = bool(mappings)
        self.by_index: dict[int, Interface] = {}
        self._names: dict[int, str] = {}
        self.dropped: Counter[tuple[str, str]] = Counter()  # by name and reason: sent, and did not go out
        self.changed: Callable[[Interface], object] = lambda interface: None  # it came, went, is up or down
        self.unplaced: set[str] = set()  # names that the table has no place for
        for name, target in mappings.items():
            self._add(name, target, find_lines(hub, target, "CAN"), of_all=True)
        self.refresh()

    def refresh(self) -> list[Interface]:
        """Add interfaces for lines that are new, and return the interfaces whose lines no longer exist."""
        lines = every_line(self.hub, "CAN")
        there: set[str] = set()
        for bus in dict.fromkeys(place.info.bus for place in lines if place.info.bus):
            there.add(bus)
            self._know(bus, bus, [place for place in lines if place.info.bus == bus], of_all=not self._mapped)
        for place in lines:
            there.add(place.address)
            self._know(f"{place.board.hardware_id}_{place.line}", place.address, [place], of_all=False)
        return [
            one for one in self.by_index.values() if one.target not in there and not self._finds(one.target)
        ]

    def _finds(self, target: str) -> bool:
        """Whether a mapping's target, such as "usb-to-can-fd:1", still means a line."""
        try:
            return bool(find_lines(self.hub, target, "CAN"))
        except NoSuchBoard:
            return False

    def remove(self, interface: Interface) -> None:
        """Remove an interface."""
        if self.by_index.pop(interface.index, None) is not None:
            self.show(interface, GONE)
            self._table.remove_interface(interface.place)

    def show(self, interface: Interface, flags: int) -> None:
        """Show these flags of an interface to the programs: UP, STUCK."""
        changed = (interface.flags ^ flags) & (UP | OFF | GONE)
        interface.flags = flags
        self._table.set_flags(interface.place, flags)
        if changed:
            self.changed(interface)

    def take_down(self, interface: Interface) -> None:
        """Its hub is gone: it is down, and up again once the hub is back."""
        interface.returns |= bool(interface.flags & UP)
        self.show(interface, 0)

    def drop(self, index: int, count: int, why: str = WENT) -> None:
        """Count frames of a program that cannot be sent; Linux calls this tx_dropped."""
        if count:
            self.dropped[self._names.get(index, f"interface {index}"), why] += count

    def dropped_by(self, name: str) -> int:
        """The number of frames that this interface has dropped."""
        return sum(count for (dropper, _), count in self.dropped.items() if dropper == name)

    def losses(self) -> list[str]:
        """A sentence for each interface that has dropped frames, including removed ones."""
        return [
            f"{name}: {count} frames were dropped, {why} (tx_dropped)"
            for (name, why), count in self.dropped.items()
        ]

    def of_all(self) -> list[Interface]:
        return [one for one in self.by_index.values() if one.of_all]

    def _know(self, name: str, target: str, lines: list[LinePlace], *, of_all: bool) -> None:
        if _NAME.fullmatch(name) and all(one.name != name for one in self.by_index.values()):
            self._add(name, target, lines, of_all=of_all)

    def _add(self, name: str, target: str, lines: list[LinePlace], *, of_all: bool) -> None:
        fd = any(place.info.capabilities.data is not None for place in lines)
        mtu = CANFD_MTU if fd else CAN_MTU
        found = self._table.add_interface(name, mtu, UP)
        if found is None:
            self.unplaced.add(name)
            return
        place, index = found
        self.unplaced.discard(name)
        self._names[index] = name
        made = self.by_index[index] = Interface(name, target, index, place, of_all, mtu, lines[0])
        self.changed(made)
