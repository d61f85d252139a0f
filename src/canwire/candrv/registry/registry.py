"""The registry: it stores the entries of chapter 6 for each device.

    store = RegistryStore("canwire.toml")
    store.set("CID1", "Baudrate", 500_000)  # [candrv.CID1] Baudrate = 500000
    store.settings("CID1").baudrate

Settings take effect when the driver is loaded the next time. A file without [candrv] has the pre-installed CID1 with
the manual's defaults; a file with [candrv] has only the devices that it lists. The defaults of Prefix and Index follow
the table's name.
Source: CANDRV manual, chapters 5 and 6; rulings.md 17.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from canwire import BadConfig, BadValue, InUse
from canwire.candrv.registry import file as registry_file
from canwire.candrv.registry.file import Value
from canwire.candrv.registry.settings import (
    DEVICE,
    FIELDS,
    IDENTITY,
    PRE_INSTALLED,
    ROWS,
    Row,
    Settings,
    row_of,
)

__all__ = ["ROWS", "RegistryStore", "Row", "Settings", "check_devices", "check_spi", "row_of"]

SHARE_SPI = frozenset({"picocom1", "picocom2", "picocom4"})
"""Boards whose CAN controller is connected to an SPI port that programs may use, too (chapter 5)."""


class RegistryStore:
    """The devices in a file. Each call reads the file again, so that all programs see the same; no file stays open.

    Raises BadConfig for an invalid file, BadValue for invalid names and values.
    """

    def __init__(self, path: str | Path = "canwire.toml") -> None:
        self.path = Path(path)

    def devices(self) -> list[str]:
        """The names of the devices' tables, in the order in which their drivers are loaded."""
        orders = {name: self.settings(name).order for name in self._tables()}
        return sorted(orders, key=lambda name: (orders[name], name))

    def all_settings(self) -> dict[str, Settings]:
        """Settings by device name (`CID1:`), in loading order; raises BadConfig if two devices have the same name."""
        found: dict[str, Settings] = {}
        for table in self.devices():
            settings = self.settings(table)
            if settings.device in found:
                raise BadConfig(f"{self.path}: [candrv.{table}]: another device is {settings.device}, too")
            found[settings.device] = settings
        return found

    def stored(self, device: str) -> dict[str, Value]:
        """The entries of a device that the file contains."""
        tables = self._tables()
        return dict(tables[_known(device, tables)])

    def settings(self, device: str) -> Settings:
        """The settings with which the device's driver is loaded the next time."""
        try:
            return Settings.of(self.stored(device), _table_name(device))
        except BadValue as error:
            raise BadConfig(f"{self.path}: [candrv.{_table_name(device)}]: {error}") from None

    def get(self, device: str, name: str) -> Value | None:
        """The value of an entry: the stored one, or else its default."""
        return getattr(self.settings(device), FIELDS[row_of(name).name])

    def set(self, device: str, name: str, value: Value) -> None:
        """Store an entry; raises BadValue, and then the file is unchanged."""
        row = row_of(name)
        self._store(device, lambda table: table.__setitem__(_spelled(row, table), row.checked(value)))

    def delete(self, device: str, name: str) -> None:
        """Delete a stored entry, so that its default applies; nothing happens if it is not stored."""
        row = row_of(name)
        self._store(device, lambda table: table.pop(_spelled(row, table), None))

    def defaults(self, device: str) -> None:
        """Delete all entries of a device except those that identify it."""

        def clear(table: dict[str, Value]) -> None:
            for name in [name for name in table if row_of(name).name not in IDENTITY]:
                del table[name]

        self._store(device, clear)

    def merge(self, devices: Mapping[str, Mapping[str, Value | None] | None]) -> None:
        """Store the content of a .reg file (reg_file.py): all of it, or none if it raises BadValue."""

        def merged(tables: dict[str, dict[str, Value]] | None) -> dict[str, dict[str, Value]]:
            after = dict(_present(tables))
            for name, entries in devices.items():
                table = after.pop(name, {})
                if entries is not None:
                    after[name] = _merged(table, entries)
            return after

        self._change(merged)

    def install(self, device: str = PRE_INSTALLED) -> None:
        """Register a device with the manual's defaults; a registered device stays as it is."""
        name = _table_name(device)
        if not DEVICE.fullmatch(name):
            raise BadValue(f"device {device!r:.40}: write three upper-case letters and a digit, like CID1:")

        def add(tables: dict[str, dict[str, Value]] | None) -> dict[str, dict[str, Value]]:
            present = _present(tables)
            if tables is None and name == PRE_INSTALLED:
                return {name: {}}
            return present if name in present else {**present, name: {}}

        self._change(add)

    def remove(self, device: str = PRE_INSTALLED) -> None:
        """Unregister a device; raises BadValue if no device has that name."""

        def drop(tables: dict[str, dict[str, Value]] | None) -> dict[str, dict[str, Value]]:
            present = _present(tables)
            del present[_known(device, present)]
            return present

        self._change(drop)

    def _tables(self) -> dict[str, dict[str, Value]]:
        return _present(registry_file.load(self.path)[1])

    def _store(self, device: str, edit: Any) -> None:
        def edited(tables: dict[str, dict[str, Value]] | None) -> dict[str, dict[str, Value]]:
            present = _present(tables)
            edit(present[_known(device, present)])
            return present

        self._change(edited)

    def _change(self, wanted: registry_file.Change) -> None:
        def checked(tables: dict[str, dict[str, Value]] | None) -> dict[str, dict[str, Value]]:
            after = wanted(tables)
            check_devices({name: _settings(table, name) for name, table in after.items()})
            return after

        registry_file.change(self.path, checked)


def _merged(table: dict[str, Value], entries: Mapping[str, Value | None]) -> dict[str, Value]:
    """The table with these entries changed; None restores the default."""
    lower = {name.lower() for name in entries}
    kept = {name: value for name, value in table.items() if name.lower() not in lower}
    return kept | {name: value for name, value in entries.items() if value is not None}


def _settings(table: Mapping[str, Value], name: str) -> Settings:
    try:
        return Settings.of(table, name)
    except BadValue as error:
        raise BadValue(f"[candrv.{name}]: {error}") from None


def _present(tables: dict[str, dict[str, Value]] | None) -> dict[str, dict[str, Value]]:
    return {PRE_INSTALLED: {}} if tables is None else tables


def _table_name(device: str) -> str:
    return device.removesuffix(":")


def _known(device: str, tables: Mapping[str, Any]) -> str:
    name = _table_name(device)
    if name not in tables:
        raise BadValue(f"no device {device!r:.40}; registered are {', '.join(tables) or 'none'}")
    return name


def _spelled(row: Row, table: Mapping[str, Value]) -> str:
    """The entry's name as the file spells it."""
    return next((name for name in table if name.lower() == row.name.lower()), row.name)


# checks across devices


def check_devices(devices: Mapping[str, Settings]) -> None:
    """Raises BadValue if two devices have the same name."""
    owners: dict[str, str] = {}
    for table, settings in devices.items():
        other = owners.setdefault(settings.device, table)
        if other != table:
            raise BadValue(f"{settings.device} is the name of [candrv.{other}] and [candrv.{table}]")


def check_spi(kind: str, settings: Settings, others: Iterable[Settings] = ()) -> None:
    """Raises InUse if two devices use the same SPI port and one of them does not share it (DirectInterface 1).

    `others` are the devices loaded on the same board. This applies only to boards that share the port between CAN and
    SPI programs.
    """
    if kind not in SHARE_SPI:
        return
    port = settings.spi_device
    for other in others:
        direct = settings.direct_interface or other.direct_interface
        if other.spi_device == port and other.device != settings.device and direct:
            raise InUse(
                f"{settings.device}: {other.device} uses {port}, too; set DirectInterface to 0 for both"
            )
