"""canwire.toml: which buses a hub has, and which boards are plugged in when it starts.

    [[bus]]
    name = "can0"
    bit_rate = 500000

    [[board]]
    kind = "usb-to-can-fd"
    serial = "HW000001"
    buses = ["can0", "can0", "lin0"]

    [[board]]
    kind = "inducan104"
    base = 0x280

Every option stands once, in the classes below: `options` lists them for documentation. A file without [[bus]] has
the buses can0 and lin0, one without [[board]] no boards until somebody plugs them in; without a file there is
the default world of rulings.md 30.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple, NoReturn

import msgspec
from msgspec import Meta

from canwire.boards import catalogue
from canwire.boards.board import checked_bus_name, checked_hardware_id
from canwire.boards.complaint import complaint
from canwire.boards.inducan104 import KIND as INDUCAN104
from canwire.boards.inducan104 import checked_irq, checked_place
from canwire.boards.isa import IsaPlace, base_conflict, irq_conflict
from canwire.errors import BadConfig, BadValue, NoSuchBoard
from canwire.values.bit_timing import BitTiming
from canwire.values.isa_address import checked_base, port_text
from canwire.values.lin_timing import checked_rate
from canwire.values.timing_limits import FD_DATA, FD_NOMINAL


class BusConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[[bus]]: the copper."""

    name: Annotated[str, Meta(description="name of the bus: no blanks, parentheses or colons")]
    type: Annotated[str, Meta(pattern="^(can|lin)$", description="can or lin")] = "can"
    bit_rate: (
        Annotated[
            int,
            Meta(
                ge=1,
                le=1_000_000,
                description="bit/s that is usual there; left out, 500000 (can) or 19200 (lin)",
            ),
        ]
        | None
    ) = None
    data_bit_rate: (
        Annotated[int, Meta(ge=1, le=20_000_000, description="bit/s that is usual after the bit-rate switch")]
        | None
    ) = None
    length_m: Annotated[
        float, Meta(ge=0, le=10_000, description="length of the cable in metres; 0: ideal")
    ] = 0.0
    node_delay_ns: Annotated[
        float,
        Meta(ge=0, le=100_000, description="extra delay of every node in ns, 75 an opto-coupler; 0: ideal"),
    ] = 0.0
    termination_ohm: Annotated[
        float,
        Meta(
            ge=0, le=1_000_000, description="resistor at each end of the cable in ohms; usual are 120 to 180"
        ),
    ] = 120.0

    @property
    def usual_rate(self) -> int:
        """bit/s"""
        return self.bit_rate or (500_000 if self.type == "can" else 19_200)


class BoardConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[[board]]: a board that is plugged in when the hub starts."""

    kind: Annotated[
        str,
        Meta(description="usb-to-can-fd, usb-to-can, inducan104, pc-i04, or a plug-in's kind"),
    ]
    serial: Annotated[
        str,
        Meta(description='hardware id: "HW" and 1 to 14 printable characters; left out, the hub chooses one'),
    ] = ""
    buses: Annotated[
        tuple[str, ...], Meta(description="a bus for each of its lines; left out, the kind's usual ones")
    ] = ()
    base: (
        Annotated[int, Meta(description="inducan104: its address, 0x100, 0x120 to 0x3E0; left out, 0x280")]
        | None
    ) = None
    irq: (
        Annotated[
            int, Meta(description="inducan104: its interrupt line, 3, 4, 5, 7, 9, 10 or 11; left out, 5")
        ]
        | None
    ) = None
    shared_irq: Annotated[
        bool, Meta(description="inducan104: others that say so too may use its interrupt line")
    ] = False
    access: Annotated[
        str,
        Meta(
            pattern="^(simulated|port)$",
            description="inducan104: simulated, or port for a real one, which takes rights to /dev/port",
        ),
    ] = "simulated"

    @property
    def place(self) -> IsaPlace | None:
        """Address and interrupt line of an inducan104, None of other kinds; raises BadValue for impossible ones."""
        return checked_place(self.base, self.irq, self.shared_irq) if self.kind == INDUCAN104 else None


_INDUCAN104_ONLY = ("base", "irq", "shared_irq", "access")
_TABLES: dict[str, type[BusConfig | BoardConfig]] = {"bus": BusConfig, "board": BoardConfig}


class Option(NamedTuple):
    """An option as documentation shows it; `default` None where it must be given or has none."""

    table: str
    name: str
    type: str
    default: Any
    help: str


class Config(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The whole file, checked: what it names exists, and a hub can run it."""

    bus: tuple[BusConfig, ...] = (
        BusConfig(name=catalogue.USUAL_BUS, data_bit_rate=2_000_000),
        BusConfig(name=catalogue.USUAL_LIN_BUS, type="lin"),
    )
    board: tuple[BoardConfig, ...] = ()

    @classmethod
    def load(cls, path: str | Path) -> Config:
        """The file's configuration; raises BadConfig naming file and place."""
        try:
            text = Path(path).read_bytes().decode("utf-8")
        except OSError as error:
            raise BadConfig(f"{path}: {error.strerror}") from None
        except UnicodeDecodeError as error:
            raise BadConfig(f"{path}: byte {error.start} is no UTF-8: {error.reason}") from None
        return cls.parse(text, str(path))

    @classmethod
    def parse(cls, text: str, source: str = "canwire.toml") -> Config:
        """The text's configuration; `source` is what messages call it. Raises BadConfig."""
        try:
            data = tomllib.loads(text)
        except ValueError as error:
            raise BadConfig(f"{source}: {error}") from None
        except RecursionError:
            raise BadConfig(f"{source}: nested too deep") from None
        try:
            config = msgspec.convert(data, cls, strict=True)
        except msgspec.ValidationError as error:
            tables = {name: kind.__struct_fields__ for name, kind in _TABLES.items()}
            raise BadConfig(f"{source}: {complaint(str(error), data, tables)}") from None
        _Check(config, source).run()
        return config

    @classmethod
    def default(cls) -> Config:
        """The world without a file: one board of each of our own kinds on one bus (source: rulings.md 30)."""
        kinds = enumerate(catalogue.KINDS, 1)
        return cls(board=tuple(BoardConfig(kind=name, serial=f"HW{number:06}") for number, name in kinds))


def options() -> list[Option]:
    """Every option of the file, in the order of the classes above."""
    rows = []
    for table, kind in _TABLES.items():
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


class _Check:
    """What the types do not say: names that exist, names that are given once, rates that can be made."""

    def __init__(self, config: Config, source: str) -> None:
        self._config = config
        self._source = source

    def run(self) -> None:
        self._once([bus.name for bus in self._config.bus], "bus", "name")
        self._once([board.serial for board in self._config.board], "board", "serial")
        for index, bus in enumerate(self._config.bus):
            self._bus(f"bus[{index}]", bus)
        for index, board in enumerate(self._config.board):
            self._board(f"board[{index}]", board)
            self._isa(index, board)

    def _bus(self, place: str, bus: BusConfig) -> None:
        self._accept(f"{place}.name", checked_bus_name, bus.name)
        if bus.type == "lin":
            self._accept(f"{place}.bit_rate", checked_rate, bus.usual_rate)
            if bus.data_bit_rate is not None:
                self._refuse(f"{place}.data_bit_rate", "a LIN bus has one bit rate")
            return
        self._accept(f"{place}.bit_rate", _check_rate, bus.usual_rate)
        if bus.data_bit_rate is not None:
            if bus.data_bit_rate < bus.usual_rate:
                self._refuse(
                    f"{place}.data_bit_rate", f"{bus.data_bit_rate} is below bit_rate {bus.usual_rate}"
                )
            self._accept(f"{place}.data_bit_rate", _check_data_rate, bus.data_bit_rate)

    def _board(self, place: str, board: BoardConfig) -> None:
        if board.serial:
            self._accept(f"{place}.serial", checked_hardware_id, board.serial)
        try:
            kind = catalogue.kind(board.kind)
        except NoSuchBoard as error:
            self._refuse(f"{place}.kind", str(error))
        there = {bus.name: bus.type for bus in self._config.bus}
        self._accept(f"{place}.buses", lambda named: kind.bus_names(named, there), board.buses)
        for index, name in enumerate(kind.bus_names(board.buses, there)):
            where = f"{place}.buses[{index}]" if index < len(board.buses) else f"{place}.buses, left out"
            wanted = kind.connectors[index].bus_type.lower()
            if name and name not in there:
                self._refuse(where, f"no bus {name!r}; there are {', '.join(there) or 'none'}")
            if name and there[name] != wanted:
                self._refuse(
                    where, f"{name!r} is a {there[name]} bus; line {index} of {kind.name} is {wanted}"
                )

    def _isa(self, index: int, board: BoardConfig) -> None:
        """What the jumpers of an inducan104 say, and whether the boards before it leave that free."""
        if board.kind != INDUCAN104:
            for field in msgspec.structs.fields(BoardConfig):
                if field.name in _INDUCAN104_ONLY and getattr(board, field.name) != field.default:
                    self._refuse(f"board[{index}].{field.name}", f"{board.kind} has none; {INDUCAN104} has")
            return
        if board.base is not None:
            self._accept(f"board[{index}].base", checked_base, board.base)
        if board.irq is not None:
            self._accept(f"board[{index}].irq", checked_irq, board.irq)
        for number in range(index):
            self._apart(index, number)

    def _apart(self, index: int, before: int) -> None:
        """Neither board is in the other's way."""
        board, other = self._config.board[index], self._config.board[before]
        mine, theirs = board.place, other.place
        if mine is None or theirs is None:
            return
        who = f"board[{before}] {other.serial}".rstrip()
        if base_conflict(mine, theirs):
            place = f"board[{index}].base{', left out' if board.base is None else ''}"
            self._refuse(place, f"{port_text(mine.base)} twice; {who} is there too")
        if irq_conflict(mine, theirs):
            place = f"board[{index}].irq{', left out' if board.irq is None else ''}"
            why = f"IRQ {mine.irq} twice; {who} has it too"
            self._refuse(place, f"{why}; boards that share it all say shared_irq = true")

    def _once(self, names: Sequence[str], table: str, key: str) -> None:
        for index, name in enumerate(names):
            if name and name in names[:index]:
                self._refuse(
                    f"{table}[{index}].{key}", f"{name!r} twice; {table}[{names.index(name)}] has it too"
                )

    def _accept(self, place: str, check: Callable[[Any], object], value: object) -> None:
        try:
            check(value)
        except (BadValue, NoSuchBoard) as error:
            self._refuse(place, str(error))

    def _refuse(self, place: str, why: str) -> NoReturn:
        raise BadConfig(f"{self._source}: {place}: {why}")


def _check_rate(bit_rate: int) -> None:
    BitTiming.for_bit_rate(bit_rate, limits=FD_NOMINAL)


def _check_data_rate(bit_rate: int) -> None:
    BitTiming.for_bit_rate(bit_rate, limits=FD_DATA)
