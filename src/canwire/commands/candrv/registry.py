"""`canwire candrv registry`, `install`, `remove`: the entries of the CANDRV manual's chapter 6, as rows of TOML."""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import TYPE_CHECKING

from canwire.commands.console import complain

if TYPE_CHECKING:
    from canwire.candrv.device.active import Driver
    from canwire.candrv.registry.registry import RegistryStore

_IN_HEX = ("AcceptanceCode", "AcceptanceMask")
_WIDTH = 36


def install(arguments: argparse.Namespace) -> int:
    """Register a device; what is there stays as it is."""
    store = _store(arguments)
    store.install(arguments.device)
    print(f"{_name(arguments.device)} installed in {store.path}")
    return 0


def remove(arguments: argparse.Namespace) -> int:
    """Unregister a device."""
    store = _store(arguments)
    store.remove(arguments.device)
    print(f"{_name(arguments.device)} removed from {store.path}")
    return 0


def list_entries(arguments: argparse.Namespace) -> int:
    """All entries; an entry that is not stored is printed after a #, with its default."""
    from canwire.candrv.registry.registry import ROWS

    store = _store(arguments)
    for number, device in enumerate([arguments.device] if arguments.device else store.devices()):
        stored = {name.lower(): value for name, value in store.stored(device).items()}
        print(f"{chr(10) if number else ''}[candrv.{device.removesuffix(':')}]")
        for name, row in ROWS.items():
            value = stored.get(name.lower())
            shown = value if value is not None else store.get(device, name)
            line = f"{'' if value is not None else '# '}{name} = {_shown(name, shown)}"
            print(f"{line:<{_WIDTH}} # {row.effect}")
    return 0


def get_entries(arguments: argparse.Namespace) -> int:
    """Print the value of one entry."""
    value = _store(arguments).get(arguments.device, arguments.entry)
    print("" if value is None else value)
    return 0


def set_entries(arguments: argparse.Namespace) -> int:
    """Store the value of an entry."""
    from canwire.candrv.registry.registry import row_of

    value = row_of(arguments.entry).parsed(arguments.value)
    _store(arguments).set(arguments.device, arguments.entry, value)
    return _tell(arguments)


def delete_entries(arguments: argparse.Namespace) -> int:
    """Delete the stored value of an entry, so that its default applies."""
    _store(arguments).delete(arguments.device, arguments.entry)
    return _tell(arguments)


def defaults_entries(arguments: argparse.Namespace) -> int:
    """Delete all stored values of a device except those that identify it, so that the defaults apply."""
    _store(arguments).defaults(arguments.device)
    return _tell(arguments)


def import_entries(arguments: argparse.Namespace) -> int:
    """Store what a .reg file has; what has no place here is named."""
    from canwire.candrv.registry import reg_file

    store, found = _store(arguments), reg_file.load(Path(arguments.file))
    store.merge(found.devices)
    for device, entries in found.devices.items():
        print(f"{device}: {'removed' if entries is None else f'{len(entries)} entries'}")
    if found.skipped:
        complain(f"skipped: {', '.join(found.skipped)}")
    complain("drivers take it when they are loaded the next time: `canwire candrv restart`")
    return 0


def shown_driver(driver: Driver) -> str:
    """A loaded driver: where it is, how it is set up now, and the entries it was loaded with."""
    lines = [rf"{driver.name} Drivers\BuiltIn\{driver.name.removesuffix(':')}"]
    if driver.board is None:
        lines.append("  its board is not plugged in")
    else:
        lines.append(f"  {driver.board.hardware_id} ({driver.board.kind}), line {driver.line}")
    if driver.state is not None:
        mode = ("CAN2.0A", "CAN2.0B")[driver.state.mode]
        lines.append(f"  {driver.state.rate} bit/s, {mode}, {'open' if driver.is_open else 'not open'}")
    lines += [f"  {name} = {_shown(name, value)}" for name, value in driver.stored.items()]
    return "\n".join(lines)


def _tell(arguments: argparse.Namespace) -> int:
    device = _name(arguments.device)
    complain(f"{device} takes it when its driver is loaded the next time: `canwire candrv restart {device}`")
    return 0


def _store(arguments: argparse.Namespace) -> RegistryStore:
    from canwire.candrv.registry.registry import RegistryStore

    return RegistryStore(arguments.config or os.environ.get("CANWIRE_CONFIG") or "canwire.toml")


def _name(device: str) -> str:
    return f"{device.removesuffix(':')}:"


def _shown(name: str, value: int | str | None) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return f'"{value}"'
    return f"0x{value:08X}" if name in _IN_HEX else str(value)
