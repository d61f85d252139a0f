"""The network descriptions of a server: several, each for one bus or for all of them; opened and closed at any time."""

from __future__ import annotations

import threading
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import canwire
from canwire import BadValue
from canwire.web.database import Database

if TYPE_CHECKING:
    from collections.abc import Iterable

MOST = 32
_OTHER_BUSES = "*"  # no bus has that name


class Loaded(NamedTuple):
    """One open file. `bus` is the name of the bus that it describes, "" for every bus."""

    key: str
    name: str
    bus: str
    file: canwire.Database
    path: Path


class Databases:
    """`on(bus)` is the description of a bus. `version` grows with each change. Any thread may use it."""

    def __init__(self, paths: Iterable[str] = ()) -> None:
        """Load the files of `paths`, each of which may have a bus before it: "can0=car.dbc".

        Raises BadDescription, ExtraMissing."""
        self._lock = threading.Lock()
        self._loaded: tuple[Loaded, ...] = ()
        self._made: dict[str, Database] = {}
        self._next = 1
        self.version = 0
        for path in paths:
            bus, equals, rest = path.partition("=")
            self.load(Path(rest if equals else path), bus if equals else "")

    @property
    def loaded(self) -> tuple[Loaded, ...]:
        """The files in their order of precedence."""
        return self._loaded

    def on(self, bus: str) -> Database:
        """The description by the files for this bus, then by those for every bus; "" selects all files."""
        with self._lock:
            if bus not in self._made:
                own = [one.file for one in self._loaded if one.bus == bus]
                others = [one.file for one in self._loaded if one.bus != bus and (not one.bus or not bus)]
                self._made[bus] = Database([*own, *others])
            return self._made[bus]

    def group(self, bus: str) -> str:
        """Return a key of the bus: `on` returns the same description for all buses with one key."""
        return bus if bus and any(one.bus == bus for one in self._loaded) else _OTHER_BUSES

    def of(self, bus: str) -> Database:
        """Return the description of this bus, without the files for other buses; for "", the files for every bus."""
        return self.on(self.group(bus))

    def load(self, path: Path, bus: str = "", name: str = "") -> Loaded:
        """Read a file; raises BadDescription, ExtraMissing, and BadValue if too many are open."""
        file = canwire.load_database(path)
        with self._lock:
            if len(self._loaded) >= MOST:
                raise BadValue(f"{MOST} descriptions are open; close one first")
            made = Loaded(f"db-{self._next}", name or path.name, bus, file, path)
            self._next += 1
            self._set((*self._loaded, made))
        return made

    def close(self, key: str) -> Loaded:
        """Close a file and return it; raises BadValue if it is not open."""
        with self._lock:
            found = self._find(key)
            self._set(tuple(one for one in self._loaded if one.key != key))
        return found

    def assign(self, key: str, bus: str) -> Loaded:
        """Use the file for this bus from now on, "" for every bus; raises BadValue if it is not open."""
        with self._lock:
            changed = self._find(key)._replace(bus=bus)
            self._set(tuple(changed if one.key == key else one for one in self._loaded))
        return changed

    def _find(self, key: str) -> Loaded:
        for one in self._loaded:
            if one.key == key:
                return one
        raise BadValue(f"{key}: this description is not open any more")

    def _set(self, loaded: tuple[Loaded, ...]) -> None:
        self._loaded = loaded
        self._made.clear()
        self.version += 1
