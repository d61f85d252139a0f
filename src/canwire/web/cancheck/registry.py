"""The registry dialog: all entries of a port, written on OK; they take effect once the driver is loaded again.

Source: CANDRV manual, 10.4, registry settings dialog; chapter 6.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from canwire import BadValue
from canwire.candrv import RegistryStore
from canwire.candrv.properties import RATES
from canwire.candrv.registry.file import Value
from canwire.candrv.registry.loading import usual_store
from canwire.candrv.registry.settings import FIELDS, ROWS, Row

HEXADECIMAL = ("AcceptanceCode", "AcceptanceMask")
_MOST_CHOICES = 8


@dataclass(frozen=True)
class Entry:
    """A field of the dialog: `value` as text. Only `choices` are valid if there are any; `suggestions` are examples."""

    name: str
    value: str
    effect: str
    text: bool
    hexadecimal: bool
    low: int
    high: int
    choices: tuple[str, ...] = ()
    suggestions: tuple[str, ...] = ()

    @property
    def optional(self) -> bool:
        return "" in self.choices


class RegistryDialog:
    """The dialog of the port for which it was opened. Only `ok` writes. Raises BadConfig for an invalid file."""

    def __init__(self, port: str, store: RegistryStore | None = None) -> None:
        self.port = port
        self.store = store or usual_store()

    def entries(self) -> list[Entry]:
        """Return all entries with their stored values."""
        settings = self.store.settings(self._table())
        return [_entry(row, getattr(settings, FIELDS[row.name])) for row in ROWS.values()]

    def ok(self, values: Mapping[str, Value | None]) -> list[str]:
        """Write the entries that differ, all or none; returns their names. Raises BadValue for impossible values."""
        table = self._table()
        settings = self.store.settings(table)
        changed = {name: value for name, value in values.items() if value != getattr(settings, FIELDS[name])}
        for name, value in changed.items():
            if value is not None:
                ROWS[name].checked(value)
        if changed:
            self.store.merge({table: changed})
        return list(changed)

    def _table(self) -> str:
        for table in self.store.devices():
            if self.store.settings(table).device == self.port:
                return table
        raise BadValue(f"{self.port} is not registered any more")


def ports(store: RegistryStore | None = None) -> list[str]:
    """Return the names of the registered devices."""
    return list((store or usual_store()).all_settings())


def _entry(row: Row, value: Value | None) -> Entry:
    hexadecimal = row.name in HEXADECIMAL
    text = row.type != "DWORD"
    shown = "" if value is None else f"{value:08X}" if hexadecimal else str(value)
    choices: tuple[str, ...] = ()
    if not text and row.high - row.low < _MOST_CHOICES:
        choices = tuple(str(number) for number in range(row.low, row.high + 1))
        if row.default is None:
            choices = ("", *choices)
    rates = tuple(str(rate) for rate in RATES) if row.name == "Baudrate" else ()
    return Entry(row.name, shown, row.effect, text, hexadecimal, row.low, row.high, choices, rates)
