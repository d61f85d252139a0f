"""canwire.toml: which buses a hub has, and which boards are plugged in when it starts.

    [[bus]]
    name = "can0"
    bit_rate = 500000

    [[board]]
    kind = "usb-to-can-fd"
    serial = "HW000001"
    buses = ["can0", "can0", "lin0"]

Every option stands once, in the classes below: `options` lists them for documentation. A file without [[bus]] has
the buses can0 and lin0, one without [[board]] no boards until somebody plugs them in; without a file there is
the default world of rulings.md 30.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple, NoReturn

import msgspec
from msgspec import Meta

from canwire.boards import catalogue
from canwire.boards.board import checked_bus_name, checked_hardware_id
from canwire.errors import BadConfig, BadValue, NoSuchBoard
from canwire.values.bit_timing import BitTiming
from canwire.values.lin_timing import checked_rate
from canwire.values.timing_limits import FD_DATA, FD_NOMINAL

_PLACE = re.compile(r" - at `\$(.*)`\Z", re.DOTALL)
_STEP = re.compile(r"\.?([^.\[]+)|\[(\d+)\]")
_UNKNOWN = re.compile(r"Object contains unknown field `(.*)`", re.DOTALL)
_MISSING = re.compile(r"Object missing required field `(\w+)`")
_WORDS = {
    "`array`": "a list",
    "`object`": "a table",
    "`str`": "text",
    "`int`": "a whole number",
    "`int | null`": "a whole number",
    "`float`": "a number",
    "`bool`": "true or false",
}
_LONGEST_VALUE = 60


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

    @property
    def usual_rate(self) -> int:
        """bit/s"""
        return self.bit_rate or (500_000 if self.type == "can" else 19_200)


class BoardConfig(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """[[board]]: a board that is plugged in when the hub starts."""

    kind: Annotated[str, Meta(description="kind of the board: usb-to-can-fd, usb-to-can, or a plug-in's")]
    serial: Annotated[
        str,
        Meta(description='hardware id: "HW" and 1 to 14 printable characters; left out, the hub chooses one'),
    ] = ""
    buses: Annotated[
        tuple[str, ...], Meta(description="a bus for each of its lines; left out, the kind's usual ones")
    ] = ()


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
            raise BadConfig(f"{source}: {_complaint(str(error), data)}") from None
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


def _complaint(message: str, data: dict[str, Any]) -> str:
    """What msgspec has against the data, with the place first and the value there."""
    found = _PLACE.search(message)
    place, what = (found[1].removeprefix("."), message[: found.start()]) if found else ("", message)
    if unknown := _UNKNOWN.fullmatch(what):
        keys = ", ".join(_TABLES[place.partition("[")[0]].__struct_fields__ if place else _TABLES)
        return f"{f'{place}.' if place else ''}{unknown[1]}: no such key; there are {keys}"
    if missing := _MISSING.fullmatch(what):
        return f"{place}.{missing[1]}: missing"
    for word, plain in _WORDS.items():
        what = what.replace(word, plain)
    hint = f"; write [[{place}]], with two brackets" if place in _TABLES else ""
    return f"{place}{_value_at(place, data)}: {what[0].lower()}{what[1:]}{hint}"


def _value_at(place: str, data: Any) -> str:
    """` = value` for what can be shown in a line."""
    for key, index in _STEP.findall(place):
        data = data[int(index)] if index else data[key]
    if isinstance(data, dict | list):
        return ""
    shown = repr(data)
    return f" = {shown if len(shown) <= _LONGEST_VALUE else shown[:_LONGEST_VALUE] + '...'}"


def _check_rate(bit_rate: int) -> None:
    BitTiming.for_bit_rate(bit_rate, limits=FD_NOMINAL)


def _check_data_rate(bit_rate: int) -> None:
    BitTiming.for_bit_rate(bit_rate, limits=FD_DATA)
