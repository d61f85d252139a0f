"""Checks of canwire.toml beyond its types: existing names, free places, possible rates."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Any, NoReturn

import msgspec

from canwire.boards import catalogue
from canwire.boards.board import checked_bus_name, checked_hardware_id
from canwire.boards.inducan104 import KIND as INDUCAN104
from canwire.boards.inducan104 import checked_irq
from canwire.boards.isa import base_conflict, irq_conflict
from canwire.boards.outside import checked_port
from canwire.errors import BadConfig, BadValue, NoSuchBoard
from canwire.values.isa_address import checked_base, port_text
from canwire.values.lin.timing import checked_rate
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import FD_DATA, FD_NOMINAL

if TYPE_CHECKING:
    from canwire.boards.config.tables import BoardConfig, BusConfig

_IDEAL_ONLY = ("loop_delay_ns", "delay_compensation", "edge_filter", "protocol_exception", "fd_tolerant")
_INDUCAN104_ONLY = ("base", "irq", "shared_irq", "access")


class Check:
    """Checks a whole file, which messages call `source`; `run` raises BadConfig with the place."""

    def __init__(self, buses: Sequence[BusConfig], boards: Sequence[BoardConfig], source: str) -> None:
        self._buses = buses
        self._boards = boards
        self._source = source

    def run(self) -> None:
        self._once([bus.name for bus in self._buses], "bus", "name")
        self._once([board.serial for board in self._boards], "board", "serial")
        for index, bus in enumerate(self._buses):
            self._bus(f"bus[{index}]", bus)
        for index, board in enumerate(self._boards):
            self._board(f"board[{index}]", board)
            self._isa(index, board)
            self._port(index, board)
            self._options(f"board[{index}]", board)

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
        there = {bus.name: bus.type for bus in self._buses}
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
        """Check the jumpers of an inducan104, and that no earlier board uses the same ones."""
        if board.kind != INDUCAN104:
            self._default(
                f"board[{index}]", board, _INDUCAN104_ONLY, f"{board.kind} has none; {INDUCAN104} has"
            )
            return
        if board.base is not None:
            self._accept(f"board[{index}].base", checked_base, board.base)
        if board.irq is not None:
            self._accept(f"board[{index}].irq", checked_irq, board.irq)
        for number in range(index):
            self._apart(index, number)

    def _port(self, index: int, board: BoardConfig) -> None:
        """Check `port`: adapters need one, other boards have none."""
        self._accept(f"board[{index}].port", lambda port: checked_port(board.kind, port), board.port)
        for number, other in enumerate(self._boards[:index] if board.port else ()):
            if other.port == board.port:
                self._refuse(f"board[{index}].port", f"{board.port!r} twice; board[{number}] has it too")

    def _options(self, place: str, board: BoardConfig) -> None:
        """Check the options that only ideal controllers have."""
        if not catalogue.kind(board.kind).ideal:
            self._default(place, board, _IDEAL_ONLY, f"{board.kind} has none; USB-to-CAN boards have")
        self._accept(f"{place}.fd_tolerant", lambda _: board.options, board.fd_tolerant)

    def _default(self, place: str, board: BoardConfig, names: Sequence[str], why: str) -> None:
        for name, default in _defaults(type(board)).items():
            if name in names and getattr(board, name) != default:
                self._refuse(f"{place}.{name}", why)

    def _apart(self, index: int, before: int) -> None:
        """Check that two boards have different addresses, and interrupt lines that do not conflict."""
        board, other = self._boards[index], self._boards[before]
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
        seen: dict[str, int] = {}
        for index, name in enumerate(names):
            if name and name in seen:
                self._refuse(f"{table}[{index}].{key}", f"{name!r} twice; {table}[{seen[name]}] has it too")
            seen[name] = index

    def _accept(self, place: str, check: Callable[[Any], object], value: object) -> None:
        try:
            check(value)
        except (BadValue, NoSuchBoard) as error:
            self._refuse(place, str(error))

    def _refuse(self, place: str, why: str) -> NoReturn:
        raise BadConfig(f"{self._source}: {place}: {why}")


@cache
def _defaults(table: type[msgspec.Struct]) -> dict[str, object]:
    """The default of each field; cached, since msgspec evaluates every annotation for them."""
    return {field.name: field.default for field in msgspec.structs.fields(table)}


def _check_rate(bit_rate: int) -> None:
    BitTiming.for_bit_rate(bit_rate, limits=FD_NOMINAL)


def _check_data_rate(bit_rate: int) -> None:
    BitTiming.for_bit_rate(bit_rate, limits=FD_DATA)
