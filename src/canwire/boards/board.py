"""A board that is plugged in, and the kind it was made after."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import NamedTuple
from uuid import UUID

from canwire.boards.description import BoardInfo, Capabilities, LineInfo
from canwire.boards.line import Line
from canwire.bus.node import Bus
from canwire.errors import BadValue

MANUFACTURER = "canwire (simulated)"
CAN = "CAN"
_HARDWARE_ID = re.compile(r"HW[!-'*-~]{1,14}", re.ASCII)
_BUS_NAME = re.compile(r"[^\s():]{1,64}")


class Connector(NamedTuple):
    """One connector of a kind: the type of its bus ("CAN"), what it can do, where it goes unless told otherwise."""

    bus_type: str
    capabilities: Capabilities
    bus: str


@dataclass(frozen=True, slots=True)
class BoardKind:
    """A row of the catalogue, and what a package brings that adds one by the entry point group `canwire.boards`.

    `device_class` is a GUID. Versions as in BoardInfo. Raises BadValue for a row that no board could be made after.
    """

    name: str
    device_class: str
    description: str
    connectors: tuple[Connector, ...]
    manufacturer: str = MANUFACTURER
    driver_version: tuple[int, int, int, int] = (4, 0, 0, 0)
    hardware_version: tuple[int, int, int, int] = (1, 0, 0, 0)
    firmware_version: tuple[int, int] = (1, 0)

    def __post_init__(self) -> None:
        try:
            UUID(self.device_class)
        except (ValueError, AttributeError, TypeError):
            raise BadValue(
                f"board kind {self.name!r}: device_class {self.device_class!r} is no GUID"
            ) from None
        if not self.connectors:
            raise BadValue(f"board kind {self.name!r}: a board has one connector at least")

    def line_infos(self, buses: tuple[str, ...]) -> tuple[LineInfo, ...]:
        """Its lines on these buses, one each; none: the usual ones. Raises BadValue for another number of buses."""
        if buses and len(buses) != len(self.connectors):
            raise BadValue(
                f"{self.name} has {len(self.connectors)} lines, not {len(buses)}; name a bus for each"
            )
        counts: dict[str, int] = {}
        lines = []
        for connector, bus in zip(self.connectors, buses or self.usual_buses, strict=True):
            number = counts[connector.bus_type] = counts.get(connector.bus_type, 0) + 1
            name = f"{connector.bus_type}-{number}"
            lines.append(LineInfo(name, bus, connector.bus_type, connector.capabilities))
        return tuple(lines)

    def info(self, board_id: int, hardware_id: str, buses: tuple[str, ...] = ()) -> BoardInfo:
        """The description of one board of this kind; raises BadValue."""
        return BoardInfo(
            id=board_id,
            kind=self.name,
            hardware_id=checked_hardware_id(hardware_id),
            device_class=self.device_class,
            description=self.description,
            manufacturer=self.manufacturer,
            driver_version=self.driver_version,
            hardware_version=self.hardware_version,
            firmware_version=self.firmware_version,
            lines=self.line_infos(buses),
        )

    @property
    def usual_buses(self) -> tuple[str, ...]:
        """Where its lines go unless told otherwise."""
        return tuple(connector.bus for connector in self.connectors)


@dataclass(frozen=True, slots=True)
class BoardLine:
    """One connector of a board that is plugged in. `bus` stays known after the board was pulled out."""

    info: LineInfo
    line: Line
    bus: Bus


@dataclass(frozen=True, slots=True)
class Board:
    """A board that is plugged in; catalogue.build makes it, catalogue.pull takes it out. No I/O."""

    info: BoardInfo
    lines: tuple[BoardLine, ...]


def checked_hardware_id(text: str) -> str:
    """The text, if a board can have it as hardware id (16 characters overlay a GUID); raises BadValue."""
    if not isinstance(text, str) or not _HARDWARE_ID.fullmatch(text):
        raise BadValue(
            f"hardware id {text!r}: HW and 1 to 14 printable characters, no blanks or parentheses: HW000001 perhaps"
        )
    return text


def checked_bus_name(text: str) -> str:
    """The text, if a bus can have it as name; raises BadValue. Logs put blanks around it, addresses a colon behind."""
    if not isinstance(text, str) or not _BUS_NAME.fullmatch(text):
        raise BadValue(f"bus name {text!r}: 1 to 64 characters, no blanks, parentheses or colons")
    return text
