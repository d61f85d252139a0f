"""CANDRV: the programming interface of F&S's CAN driver for Windows CE, on canwire's boards.

    with candrv.open("CID1:") as handle:
        handle.accept_all()
        print("731 0 4 11 22 33 44", file=handle)
        for event in handle:
            print(event)

`candrv.win32` contains the functions of the manual, which use the same handles.

Source: CANDRV manual V2.06 (CANDRV manual).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.candrv import constants as _constants
from canwire.candrv.constants import *  # noqa: F403
from canwire.candrv.device.active import Driver, active
from canwire.candrv.device.device import Device, unload
from canwire.candrv.errors import CandrvError, format_error, translated
from canwire.candrv.event_queue import Event, EventQueue
from canwire.candrv.filters import Filter
from canwire.candrv.handle.handle import Handle
from canwire.candrv.handle.writing import PartialWrite
from canwire.candrv.program import program_hub
from canwire.candrv.properties import Controller, controller_of
from canwire.candrv.registry.registry import RegistryStore, Settings
from canwire.candrv.structures import (
    CAN_ACCEPTANCE_FILTER,
    CAN_BYTE,
    CAN_DWORD,
    CAN_EVENT,
    CAN_INT,
    CAN_PROPERTIES,
    CAN_TIME,
    CAN_TRANSMIT_DATA,
    CAN_UINT,
    COMMTIMEOUTS,
    DWORD,
    LPCOMMTIMEOUTS,
    PCAN_ACCEPTANCE_FILTER,
    PCAN_EVENT,
    PCAN_PROPERTIES,
    PCAN_TIME,
    PCAN_TRANSMIT_DATA,
)
from canwire.candrv.text import (
    EventReader,
    MalformedMessage,
    Message,
    MessageParser,
    format_event,
    format_message,
    parse_event,
)

if TYPE_CHECKING:
    from canwire import Hub


def open(
    name: str = "CID1:", *, read: bool = True, write: bool = True, hub: Hub | None = None, share: int = 3
) -> Handle:
    """Open a device; the handle has a receive channel (`read`), a send channel (`write`), both or neither.

    `share` says what other handles may do meanwhile: 1 read, 2 write, 3 both. Without `hub` it uses the hub of
    `canwire.connect()`, to which this program then stays connected.
    Raises CandrvError: ERROR_FILE_NOT_FOUND, ERROR_SHARING_VIOLATION, ERROR_NO_SYSTEM_RESOURCES.
    """
    with translated():
        device = Device(program_hub() if hub is None else hub, name)
    return Handle(device, read=read, write=write, share=share)


__all__ = [
    "CAN_ACCEPTANCE_FILTER",
    "CAN_BYTE",
    "CAN_DWORD",
    "CAN_EVENT",
    "CAN_INT",
    "CAN_PROPERTIES",
    "CAN_TIME",
    "CAN_TRANSMIT_DATA",
    "CAN_UINT",
    "COMMTIMEOUTS",
    "DWORD",
    "LPCOMMTIMEOUTS",
    "PCAN_ACCEPTANCE_FILTER",
    "PCAN_EVENT",
    "PCAN_PROPERTIES",
    "PCAN_TIME",
    "PCAN_TRANSMIT_DATA",
    "CandrvError",
    "Controller",
    "Driver",
    "Event",
    "EventQueue",
    "EventReader",
    "Filter",
    "Handle",
    "MalformedMessage",
    "Message",
    "MessageParser",
    "PartialWrite",
    "RegistryStore",
    "Settings",
    "active",
    "controller_of",
    "format_error",
    "format_event",
    "format_message",
    "parse_event",
    "unload",
]
__all__ += sorted(name for name in set(vars(_constants)) - {"IntEnum", "IntFlag"} if name[0].isupper())
