"""Loading the driver of a device: its registry entries, its CAN port, its controller.

A driver is loaded once: the program that opens its device first stores the registry's entries in a note of the hub, and
they apply to all programs until `unload`.
Source: CANDRV manual, chapter 6, 8.1; rulings.md 17.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from contextlib import suppress
from typing import TYPE_CHECKING

from canwire import NoSuchBoard
from canwire.candrv.properties import CONTROLLERS, SJA1000, Controller
from canwire.candrv.registry.registry import RegistryStore, Settings, check_spi

if TYPE_CHECKING:
    from canwire import BoardInfo, Hub, LineInfo

CAN_CTRL_SJA1000 = 5  # reference/vci.md section 3


def usual_store() -> RegistryStore:
    """The registry in the file that CANWIRE_CONFIG names, or in canwire.toml of the current directory."""
    return RegistryStore(os.environ.get("CANWIRE_CONFIG") or "canwire.toml")


def find_port(boards: tuple[BoardInfo, ...], settings: Settings) -> tuple[BoardInfo, int]:
    """The board and the number of the line that a device drives.

    The entry DeviceArrayIndex is an index into the CAN lines of the board that the entry Board names by its hardware
    id or kind, or else of all boards of CANDRV's kinds in the order in which they were plugged in. Raises NoSuchBoard.
    """
    wanted = settings.board
    chosen = [
        board
        for board in boards
        if (wanted in (board.hardware_id, board.kind) if wanted else board.kind in CONTROLLERS)
    ]
    ports = [
        (board, number)
        for board in chosen
        for number, line in enumerate(board.lines)
        if line.bus_type == "CAN"
    ]
    if settings.device_array_index >= len(ports):
        what = f"board {wanted!r}" if wanted else f"board of the kinds {', '.join(CONTROLLERS)}"
        there = ", ".join(f"{board.hardware_id} ({board.kind})" for board in boards) or "none"
        raise NoSuchBoard(
            f"{settings.device} needs CAN port {settings.device_array_index} of a {what}; plugged in: {there}"
        )
    return ports[settings.device_array_index]


def loaded(hub: Hub, name: str, store: RegistryStore) -> Settings:
    """The settings with which the driver was loaded; loads it if necessary. Raises NoSuchBoard, InUse."""
    note = hub.note(settings_note(name))
    if note:
        return Settings.of(json.loads(note), name.removesuffix(":"))
    devices = store.all_settings()
    if name not in devices:
        raise NoSuchBoard(f"no device {name!r:.40}; registered are {', '.join(devices) or 'none'}")
    settings = devices[name]
    board, _ = find_port(hub.boards(), settings)
    check_spi(board.kind, settings, _loaded_on(board, hub, devices.values()))
    table = next(table for table in store.devices() if store.settings(table) == settings)
    stored = {**store.stored(table), "Prefix": settings.prefix, "Index": settings.index}
    hub.set_note(settings_note(name), json.dumps(stored, separators=(",", ":")).encode())
    return settings


def _loaded_on(board: BoardInfo, hub: Hub, devices: Iterable[Settings]) -> list[Settings]:
    """The settings of the devices on this board whose drivers are loaded: each board has its own SPI port."""
    boards, found = hub.boards(), []
    for other in devices:
        if hub.note(settings_note(other.device)):
            with suppress(NoSuchBoard):
                if find_port(boards, other)[0].id == board.id:
                    found.append(other)
    return found


def settings_note(name: str) -> str:
    return f"candrv/{name}"


def controller_on(board: BoardInfo, line: LineInfo) -> Controller:
    """The controller on a board of CANDRV; on another board a controller with the capabilities of the line."""
    if board.kind in CONTROLLERS:
        return CONTROLLERS[board.kind]
    can = line.capabilities
    if can.controller_type == CAN_CTRL_SJA1000:
        return SJA1000
    return Controller(board.kind, can.clock_hz, can.nominal.limits(board.kind), registers=0)
