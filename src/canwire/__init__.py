"""CAN and CAN FD buses that behave like copper. Everything public is here; nothing deeper is.

>>> import canwire
>>> with canwire.Lab() as lab:
...     bus = lab.can_bus("can0", bit_rate=500_000)
...     a, b = bus.node("engine"), bus.node("tester")
...     a.send(canwire.Frame(0x123, b"\\x11\\x22"))
...     lab.run_until_idle()
...     b.receive()
Frame(0x123, bytes.fromhex("1122"), timestamp_ns=124000)
"""

from canwire.bus.bit_layout import FIELDS, BitLayout
from canwire.bus.can_bits import NON_ISO
from canwire.core import core_mode
from canwire.errors import (
    BadFilter,
    BadFrame,
    BadText,
    BadTiming,
    BadValue,
    BusOff,
    CanwireError,
    Closed,
    ExtraMissing,
    LineError,
    NotIdle,
    NotReceived,
    NotTransmitted,
    QueueFull,
)
from canwire.lab import Lab, LabBus, LabNode, NodeScript
from canwire.values.acceptance import Acceptance
from canwire.values.bit_timing import BitTiming
from canwire.values.dlc import dlc_to_length, length_to_dlc
from canwire.values.event import BusEvent, ErrorKind, ErrorState, EventKind
from canwire.values.frame import Frame
from canwire.values.record import record_dtype
from canwire.values.records import frames_to_array
from canwire.values.screen_text import format_candump_line, parse_candump_line
from canwire.values.text import LogLine, format_frame, format_log_line, parse_frame, parse_log_line
from canwire.values.timing_limits import TimingLimits
from canwire.version import __version__

__all__ = [
    "FIELDS",
    "NON_ISO",
    "Acceptance",
    "BadFilter",
    "BadFrame",
    "BadText",
    "BadTiming",
    "BadValue",
    "BitLayout",
    "BitTiming",
    "BusEvent",
    "BusOff",
    "CanwireError",
    "Closed",
    "ErrorKind",
    "ErrorState",
    "EventKind",
    "ExtraMissing",
    "Frame",
    "Lab",
    "LabBus",
    "LabNode",
    "LineError",
    "LogLine",
    "NodeScript",
    "NotIdle",
    "NotReceived",
    "NotTransmitted",
    "QueueFull",
    "TimingLimits",
    "__version__",
    "core_mode",
    "dlc_to_length",
    "format_candump_line",
    "format_frame",
    "format_log_line",
    "frames_to_array",
    "length_to_dlc",
    "parse_candump_line",
    "parse_frame",
    "parse_log_line",
    "record_dtype",
]
