"""Which line of a bus a verb listens on once its hub is back: none of a board that another program used before.

After a hub's restart no program is there yet, and the first one would take any board.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire import find_lines, lines_now
from canwire.commands.console import complain
from canwire.commands.shared_hub import find_line

if TYPE_CHECKING:
    from canwire import Hub, LinePlace
    from canwire.commands.reconnecting import Watch


def same_line(hub: Hub, name: str, watch: Watch | None) -> LinePlace:
    """The line of that name, the same as before if this program had started it; a line says so if it is another one.

    Raises NoSuchBoard.
    """
    if watch is None:
        return find_line(hub, name)
    now = {place.address: (place, status) for place, status in lines_now(hub, find_lines(hub, name, "CAN"))}
    before = watch.lines.get(name)
    if before is None:
        place = find_line(hub, name)
        others = frozenset(used.board.hardware_id for used, status in now.values() if not status.unused)
        watch.lines[name] = place.address, others
        return place
    address, others = before
    if address in now and (now[address][0].board.hardware_id not in others or not now[address][1].unused):
        return now[address][0]
    free = next((place for place, _ in now.values() if place.board.hardware_id not in others), None)
    if free is None:
        complain(f"{name}: all boards were other programs' before; this one may start a line before they do")
        return now[address][0] if address in now else find_line(hub, name)
    why = "was another program's before" if address in now else "is not there any more"
    complain(f"{name}: {address} {why}; listening on {free.address}")
    return free
