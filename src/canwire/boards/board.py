"""A board that is plugged in, and the board kind from which it was made."""

from __future__ import annotations

import re
from collections.abc import Container, Sequence
from dataclasses import dataclass
from typing import NamedTuple
from uuid import UUID

from canwire.boards.can.line import Line
from canwire.boards.description import NO_CAN, BoardInfo, Capabilities, LinCapabilities, LineInfo
from canwire.boards.inducan104 import InduCan104
from canwire.boards.isa import IsaPlace
from canwire.boards.lin.line import LinLine
from canwire.bus.can.node import Bus
from canwire.errors import BadValue
from canwire.values.controller_options import USUAL, ControllerOptions

MANUFACTURER = "canwire (simulated)"
CAN = "CAN"
LIN = "LIN"
IDEAL, SJA1000, MCP2515 = "ideal", "sja1000", "mcp2515"
_HARDWARE_ID = re.compile(r"HW[!-'*-~]{1,14}", re.ASCII)
_BUS_NAME = re.compile(r"[^\s():]{1,64}")


class Connector(NamedTuple):
    """One connector of a board kind: the type of its bus, its capabilities, its default bus.

    `controller` is that of a CAN line: IDEAL, SJA1000 or MCP2515. The numbers of channels are limits, 0: no limit.
    """

    bus_type: str
    capabilities: Capabilities | LinCapabilities
    bus: str
    controller: str = IDEAL
    receive_channels: int = 0
    send_channels: int = 0

    def line_info(self, name: str, bus: str) -> LineInfo:
        """The description of the line with this name on that bus."""
        if isinstance(self.capabilities, LinCapabilities):
            return LineInfo(name, bus, self.bus_type, NO_CAN, self.capabilities)
        channels = self.receive_channels, self.send_channels
        return LineInfo(name, bus, self.bus_type, self.capabilities, None, *channels)


@dataclass(frozen=True, slots=True)
class BoardKind:
    """A row of the catalogue; a package adds one by the entry point group `canwire.boards`.

    `device_class` is a GUID. Versions as in BoardInfo. Raises BadValue for a row from which no board can be made.
    """

    name: str
    device_class: str
    description: str
    connectors: tuple[Connector, ...]
    manufacturer: str = MANUFACTURER
    driver_version: tuple[int, int, int, int] = (4, 0, 0, 0)
    hardware_version: tuple[int, int, int, int] = (1, 0, 0, 0)
    firmware_version: tuple[int, int] = (1, 0)
    isa: bool = False  # it has an address and an interrupt line
    outside: bool = False  # a real adapter, on a bus that is not the hub's, reached through a port

    def __post_init__(self) -> None:
        try:
            UUID(self.device_class)
        except (ValueError, AttributeError, TypeError):
            raise BadValue(
                f"board kind {self.name!r}: device_class {self.device_class!r} is no GUID"
            ) from None
        if not self.connectors:
            raise BadValue(f"board kind {self.name!r}: a board has one connector at least")

    @property
    def ideal(self) -> bool:
        """Whether all its CAN lines have the ideal controller, the only one with options."""
        can = [one.controller for one in self.connectors if one.bus_type == CAN]
        return not self.outside and can != [] and set(can) == {IDEAL}

    def bus_names(self, named: Sequence[str], there: Container[str]) -> tuple[str, ...]:
        """A bus for each connector: the named buses, then the default ones; "" leaves a connector unconnected.

        Only LIN connectors, which come last, may be left out; they are unconnected where their default bus does not
        exist. Raises BadValue for too few or too many names.
        """
        if named and self.outside:
            raise BadValue(f"{self.name}: an adapter is on a private bus, not on {named[0]}; name none")
        needed = sum(connector.bus_type != LIN for connector in self.connectors)
        if named and not needed <= len(named) <= len(self.connectors):
            raise BadValue(
                f"{self.name} has {len(self.connectors)} lines, not {len(named)}; name a bus for each"
            )
        rest = self.connectors[len(named) :]
        usual = ("" if one.bus_type == LIN and one.bus not in there else one.bus for one in rest)
        return (*named, *usual)

    def line_infos(self, buses: tuple[str, ...]) -> tuple[LineInfo, ...]:
        """The description of each line, on the buses that `bus_names` returns."""
        counts: dict[str, int] = {}
        lines = []
        for connector, bus in zip(self.connectors, buses, strict=True):
            number = counts[connector.bus_type] = counts.get(connector.bus_type, 0) + 1
            name = f"{connector.bus_type}-{number}"
            lines.append(connector.line_info(name, bus))
        return tuple(lines)

    def info(
        self, board_id: int, hardware_id: str, buses: tuple[str, ...], place: IsaPlace | None = None
    ) -> BoardInfo:
        """The description of one board of this kind, on these buses (`bus_names`); raises BadValue."""
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
            resources=() if place is None else place.resources,
        )

    @property
    def usual_buses(self) -> tuple[str, ...]:
        """The default bus of each line."""
        return tuple(connector.bus for connector in self.connectors)


@dataclass(frozen=True, slots=True)
class BoardLine:
    """One CAN connector of a board that is plugged in. `bus` stays known after the board was unplugged.

    `options` are those of its controller unless a program sets others.
    """

    info: LineInfo
    line: Line
    bus: Bus
    options: ControllerOptions = USUAL


@dataclass(frozen=True, slots=True)
class BoardLinLine:
    """One LIN connector of a board that is plugged in."""

    info: LineInfo
    line: LinLine


@dataclass(frozen=True, slots=True)
class Board:
    """A board that is plugged in; catalogue.build makes it, catalogue.pull removes it. No I/O."""

    info: BoardInfo
    lines: tuple[BoardLine | BoardLinLine, ...]
    card: InduCan104 | None = None


def checked_hardware_id(text: str) -> str:
    """Return the text if it is a valid hardware id (16 characters overlay a GUID); raises BadValue."""
    if not isinstance(text, str) or not _HARDWARE_ID.fullmatch(text):
        raise BadValue(
            f"hardware id {text!r}: HW and 1 to 14 printable characters, no blanks or parentheses: HW000001 perhaps"
        )
    return text


def checked_bus_name(text: str) -> str:
    """The text if it is a valid bus name; raises BadValue.

    Logs put blanks around a name, addresses a colon after it.
    """
    if not isinstance(text, str) or not _BUS_NAME.fullmatch(text):
        raise BadValue(f"bus name {text!r}: 1 to 64 characters, no blanks, parentheses or colons")
    return text
