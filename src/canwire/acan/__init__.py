"""ACAN: the programming interface of I+ME ACTIA's INduCAN104 boards, implemented on canwire's.

Source: INduCAN104 manual.
"""

from __future__ import annotations

from canwire.acan import constants as _constants
from canwire.acan.c_types import (
    ACANCBFN,
    BOOL,
    BYTE,
    DWORD,
    HANDLE,
    HWND,
    LPBYTE,
    LPVOID,
    UINT,
    WORD,
)
from canwire.acan.constants import *  # noqa: F403
from canwire.acan.driver import Driver, open_driver
from canwire.acan.filters import Filter
from canwire.acan.hard_config import HardConfig
from canwire.acan.identifiers import BROADCAST, MachineField, acan_word, plain_identifier
from canwire.acan.install import DriverAbsent, Installation
from canwire.acan.int2d import Int2d, find_driver
from canwire.acan.real_mode import ByteMemory, FarPointer, Registers
from canwire.acan.services import Services
from canwire.acan.structures import (
    ACANHI,
    ACANHISZ,
    ACANID,
    ACANIDSZ,
    ACANMB,
    ACANMBSZ,
    ACANTB,
    ACANTBSZ,
    LPACANHI,
    LPACANMB,
    LPACANTB,
    PACANHI,
    PACANID,
    PACANMB,
    PACANTB,
)
from canwire.acan.task_block import Status, TaskBlock

open = open_driver  # `acan.open()`; a star import leaves Python's own alone

__all__ = [
    "ACANCBFN",
    "ACANHI",
    "ACANHISZ",
    "ACANID",
    "ACANIDSZ",
    "ACANMB",
    "ACANMBSZ",
    "ACANTB",
    "ACANTBSZ",
    "BOOL",
    "BROADCAST",
    "BYTE",
    "DWORD",
    "HANDLE",
    "HWND",
    "LPACANHI",
    "LPACANMB",
    "LPACANTB",
    "LPBYTE",
    "LPVOID",
    "PACANHI",
    "PACANID",
    "PACANMB",
    "PACANTB",
    "UINT",
    "WORD",
    "ByteMemory",
    "Driver",
    "DriverAbsent",
    "FarPointer",
    "Filter",
    "HardConfig",
    "Installation",
    "Int2d",
    "MachineField",
    "Registers",
    "Services",
    "Status",
    "TaskBlock",
    "acan_word",
    "find_driver",
    "plain_identifier",
]
__all__ += sorted(name for name in set(vars(_constants)) - {"IntEnum", "IntFlag"} if name[0].isupper())
