"""BalResource: one connector of a board.

Source: VCI V3 .NET manual 4.1; reference/vci.md section 7a.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from canwire.vci.controller_types import vci_bus_type
from canwire.vci.v3.bus_type import VciBusType
from canwire.vci.v3.disposable import Disposable
from canwire.vci.v3.errors import checked


class BalResource(Disposable):
    """A connector: its number from 0, its kind of bus, and its name, such as "CAN-1", numbered from 1 for each kind.

    They can also be read after `dispose`.
    """

    def __init__(self, bus_port: int, bus_type: VciBusType, bus_name: str) -> None:
        super().__init__()
        self._place = bus_port, bus_type, bus_name

    @property
    def bus_port(self) -> int:
        return self._place[0]

    @property
    def bus_type(self) -> VciBusType:
        return self._place[1]

    @property
    def bus_name(self) -> str:
        return self._place[2]

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.bus_port}: {self.bus_name}>"


class BalResourceCollection:
    """The connectors of a board: a sequence with `count` items."""

    def __init__(self, resources: Sequence[BalResource]) -> None:
        self._resources = tuple(resources)

    @property
    def count(self) -> int:
        """Count."""
        return len(self._resources)

    def __len__(self) -> int:
        return len(self._resources)

    def __getitem__(self, index: int) -> BalResource:
        return self._resources[checked("index", index, len(self._resources) - 1)]

    def __iter__(self) -> Iterator[BalResource]:
        return iter(self._resources)


def resources_of(types: Sequence[int]) -> BalResourceCollection:
    """The connectors of these types (words of controller_types.py)."""
    made: list[BalResource] = []
    for port, word in enumerate(types):
        bus_type = VciBusType(vci_bus_type(word))
        number = 1 + sum(before.bus_type == bus_type for before in made)
        made.append(BalResource(port, bus_type, f"{bus_type.name}-{number}"))
    return BalResourceCollection(made)
