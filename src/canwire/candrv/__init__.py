"""CANDRV: the interface of F&S's CAN driver for Windows CE, on canwire's boards.

Source: CANDRV manual V2.06 (seed 000).
"""

from __future__ import annotations

from canwire.candrv import constants as _constants
from canwire.candrv.constants import *  # noqa: F403
from canwire.candrv.errors import CandrvError, format_error
from canwire.candrv.event_queue import Event, EventQueue
from canwire.candrv.filters import Filter
from canwire.candrv.properties import Controller, controller_of
from canwire.candrv.registry import RegistryStore, Settings
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
    "Event",
    "EventQueue",
    "EventReader",
    "Filter",
    "MalformedMessage",
    "Message",
    "MessageParser",
    "RegistryStore",
    "Settings",
    "controller_of",
    "format_error",
    "format_event",
    "format_message",
    "parse_event",
]
__all__ += sorted(name for name in set(vars(_constants)) - {"IntEnum", "IntFlag"} if name[0].isupper())
