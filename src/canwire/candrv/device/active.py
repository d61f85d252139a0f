"""The drivers that are loaded on a hub, with their settings and ports: a board shows them in [HKLM\\Drivers\\Active].

Source: CANDRV manual, overview and 6.2.
"""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, NamedTuple

from canwire import CanwireError, NoSuchBoard
from canwire.candrv.device.bell import Bell
from canwire.candrv.device.state import KIN, DeviceState, state_of
from canwire.candrv.registry.loading import find_port
from canwire.candrv.registry.registry import Settings

if TYPE_CHECKING:
    from canwire import BoardInfo, Hub
    from canwire.candrv.registry.file import Value

_NOTE = re.compile(r"candrv/([A-Z]{3}[0-9]:)")


class Driver(NamedTuple):
    """A loaded driver: `stored` contains the registry's entries with which it was loaded, without defaults.

    `board` is None if the board was removed, `state` is None if its line is not configured. `is_open` is True if a
    program has a handle.
    """

    name: str
    stored: dict[str, Value]
    board: BoardInfo | None
    line: int
    state: DeviceState | None
    is_open: bool


def active(hub: Hub) -> tuple[Driver, ...]:
    """The loaded drivers, sorted by name. A driver is loaded when its device is first opened, until `unload`."""
    notes = hub.notes("candrv/")
    found = ((name[1], value) for note, value in notes.items() if (name := _NOTE.fullmatch(note)))
    return tuple(_driver(hub, name, json.loads(value)) for name, value in sorted(found))


def _driver(hub: Hub, name: str, stored: dict[str, Value]) -> Driver:
    settings = Settings.of(stored, name.removesuffix(":"))
    try:
        board, line = find_port(hub.boards(), settings)
        status = hub.line_status(board.id, line, kin=KIN)
        state = state_of(status, settings) if status.initialised else None
    except NoSuchBoard:
        return Driver(name, stored, None, 0, None, False)
    except CanwireError:  # its line is searching for a bit rate
        state = None
    bell = Bell.find(hub, f"candrv/{name}/bell")
    if bell is not None:
        bell.close()
    return Driver(name, stored, board, line, state, bell is not None)
