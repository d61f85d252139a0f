"""The tables of canwire.toml: each option with its type, default and help."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, NamedTuple

import msgspec
from msgspec import Meta

from canwire.boards.inducan104 import KIND as INDUCAN104
from canwire.boards.inducan104 import checked_place
from canwire.boards.isa import IsaPlace
from canwire.values.controller_options import LONGEST_LOOP_NS, ControllerOptions, DelayCompensation


class BusConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[[bus]]: a bus."""

    name: Annotated[str, Meta(description="name of the bus: no blanks, parentheses or colons")]
    type: Annotated[str, Meta(pattern="^(can|lin)$", description="can or lin")] = "can"
    bit_rate: (
        Annotated[
            int,
            Meta(
                ge=1,
                le=1_000_000,
                description="default bit rate in bit/s; if omitted, 500000 (can) or 19200 (lin)",
            ),
        ]
        | None
    ) = None
    data_bit_rate: (
        Annotated[int, Meta(ge=1, le=20_000_000, description="default data bit rate in bit/s, after BRS")]
        | None
    ) = None
    length_m: Annotated[
        float, Meta(ge=0, le=10_000, description="length of the cable in metres; 0: ideal")
    ] = 0.0
    node_delay_ns: Annotated[
        float,
        Meta(
            ge=0, le=100_000, description="extra delay of each node in ns, 75 for one opto-coupler; 0: ideal"
        ),
    ] = 0.0
    termination_ohm: Annotated[
        float,
        Meta(
            ge=0, le=1_000_000, description="resistor at each end of the cable in ohms; typically 120 to 180"
        ),
    ] = 120.0

    @property
    def usual_rate(self) -> int:
        """The default bit rate of the bus in bit/s."""
        return self.bit_rate or (500_000 if self.type == "can" else 19_200)


class BoardConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[[board]]: a board that is plugged in when the hub starts."""

    kind: Annotated[
        str,
        Meta(
            description="usb-to-can-fd, usb-to-can, inducan104, pc-i04, netdcu, picocom1, picocom2, picocom4, "
            "picomod3, canbus-dongle, slcan, slcan-fd, python-can, or a plug-in's kind"
        ),
    ]
    serial: Annotated[
        str,
        Meta(
            description='hardware id: "HW" and 1 to 14 printable characters; if omitted, the hub chooses one'
        ),
    ] = ""
    buses: Annotated[
        tuple[str, ...], Meta(description="one bus for each line; if omitted, the default buses of the kind")
    ] = ()
    base: (
        Annotated[int, Meta(description="inducan104: address, 0x100, 0x120 to 0x3E0; if omitted, 0x280")]
        | None
    ) = None
    irq: (
        Annotated[int, Meta(description="inducan104: interrupt line, 3, 4, 5, 7, 9, 10 or 11; if omitted, 5")]
        | None
    ) = None
    shared_irq: Annotated[
        bool,
        Meta(description="inducan104: share the interrupt line with boards that set this option too"),
    ] = False
    access: Annotated[
        str,
        Meta(
            pattern="^(simulated|port)$",
            description="inducan104: simulated, or port for a real board, which needs access to /dev/port",
        ),
    ] = "simulated"
    port: Annotated[
        str,
        Meta(description="slcan: /dev/ttyUSB0, COM3 or socket://host:port; python-can: interface/channel"),
    ] = ""

    loop_delay_ns: Annotated[
        float,
        Meta(
            ge=0,
            le=LONGEST_LOOP_NS,
            description="loop delay of the transceivers in ns, typically 50 to 255; 0: ideal",
        ),
    ] = 0.0
    delay_compensation: Annotated[
        bool,
        Meta(description="compensate the loop delay in the data phase, unless a program sets it"),
    ] = False
    edge_filter: Annotated[
        bool, Meta(description="ignore dominant levels under two time quanta while waiting for an idle bus")
    ] = False
    protocol_exception: Annotated[
        bool,
        Meta(description="an FD line ignores frames of an unknown format; else they are form errors"),
    ] = True
    fd_tolerant: Annotated[
        bool, Meta(description="a line set up for classic CAN ignores FD frames; else it destroys them")
    ] = False

    @property
    def options(self) -> ControllerOptions:
        """Default options of its controllers; raises BadValue if they contradict each other."""
        return ControllerOptions(
            self.loop_delay_ns,
            DelayCompensation() if self.delay_compensation else None,
            self.edge_filter,
            protocol_exception=self.protocol_exception,
            fd_tolerant=self.fd_tolerant,
        )

    @property
    def place(self) -> IsaPlace | None:
        """Address and interrupt line of an inducan104, None for other kinds; raises BadValue."""
        return checked_place(self.base, self.irq, self.shared_irq) if self.kind == INDUCAN104 else None


TABLES: dict[str, type[BusConfig | BoardConfig]] = {"bus": BusConfig, "board": BoardConfig}


class Option(NamedTuple):
    """An option for the documentation; `default` is None if it is required or has no default."""

    table: str
    name: str
    type: str
    default: Any
    help: str


def options(tables: Mapping[str, type[msgspec.Struct]] = TABLES) -> list[Option]:
    """All options of these tables, in the order of their classes."""
    rows = []
    for table, kind in tables.items():
        properties = msgspec.json.schema(kind)["$defs"][kind.__name__]["properties"]
        for field in msgspec.structs.fields(kind):
            shown = properties[field.name]
            shown = {**shown, **next(iter(shown.get("anyOf", [])), {})}
            default = None if field.required else field.default
            rows.append(Option(table, field.name, _type_name(shown), default, shown["description"]))
    return rows


def _type_name(schema: dict[str, Any]) -> str:
    if schema["type"] == "array":
        return f"list of {schema['items']['type']}s"
    return str(schema["type"])
