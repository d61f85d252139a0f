"""CANDRV: the interface of F&S's CAN driver for Windows CE, on canwire's boards.

    with candrv.open("CID1:") as handle:
        handle.accept_all()
        print("731 0 4 11 22 33 44", file=handle)
        for event in handle:
            print(event)

`candrv.win32` has the manual's own functions over the same handles.
Source: CANDRV manual V2.06 (seed 000).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from canwire.candrv.constants import CanbusEvent, CanMode, Command, ControlCode, FrameFormat, Win32Error
from canwire.candrv.device import Device, unload
from canwire.candrv.errors import CandrvError, translated
from canwire.candrv.event_queue import Event
from canwire.candrv.handle import Handle, PartialWrite
from canwire.candrv.program import program_hub
from canwire.candrv.structures import CAN_ACCEPTANCE_FILTER, CAN_EVENT, CAN_TRANSMIT_DATA, COMMTIMEOUTS

if TYPE_CHECKING:
    from canwire import Hub


def open(
    name: str = "CID1:", *, read: bool = True, write: bool = True, hub: Hub | None = None, share: int = 3
) -> Handle:
    """A handle on a device, with a receive channel (`read`), a send channel (`write`), both or neither.

    `share`: what others may do meanwhile, 1 read, 2 write. Without `hub` the one of `canwire.connect()`, which this
    program keeps. Raises CandrvError: ERROR_FILE_NOT_FOUND, ERROR_SHARING_VIOLATION, ERROR_NO_SYSTEM_RESOURCES.
    """
    with translated():
        device = Device(program_hub() if hub is None else hub, name)
    return Handle(device, read=read, write=write, share=share)


__all__ = [
    "CAN_ACCEPTANCE_FILTER",
    "CAN_EVENT",
    "CAN_TRANSMIT_DATA",
    "COMMTIMEOUTS",
    "CanMode",
    "CanbusEvent",
    "CandrvError",
    "Command",
    "ControlCode",
    "Event",
    "FrameFormat",
    "Handle",
    "PartialWrite",
    "Win32Error",
    "open",
    "unload",
]
