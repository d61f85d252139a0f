"""CAN, CAN FD and LIN buses that behave like copper. Everything public is here; nothing deeper is.

>>> import canwire
>>> with canwire.Lab() as lab:
...     bus = lab.can_bus("can0", bit_rate=500_000)
...     a, b = bus.node("engine"), bus.node("tester")
...     a.send(canwire.Frame(0x123, b"\\x11\\x22"))
...     lab.run_until_idle()
...     b.receive()
Frame(0x123, bytes.fromhex("1122"), timestamp_ns=124000)
"""

from typing import TYPE_CHECKING, Any

from canwire.boards.can.modes import (
    ChannelMode,
    ChannelStatus,
    CyclicStatus,
    FilterContent,
    FilterMode,
    FilterSetup,
    LineMode,
    LineStatus,
    Siblings,
)
from canwire.boards.can.rates import RateConflict, RunningLine, format_rates, format_setter, rate_conflicts
from canwire.boards.description import (
    BoardInfo,
    Capabilities,
    Feature,
    LinCapabilities,
    LineInfo,
    LinFeature,
    Ticks,
    TimingRange,
)
from canwire.boards.lin.modes import LinLineStatus, LinMode, LinMonitorMode, LinMonitorStatus
from canwire.bus.can.bit_layout import FIELDS, BitLayout
from canwire.bus.can.bits import NON_ISO
from canwire.bus.can.wire_fields import WireField, wire_fields
from canwire.core import core_mode
from canwire.errors import (
    BadConfig,
    BadDescription,
    BadFilter,
    BadFrame,
    BadMessage,
    BadText,
    BadTiming,
    BadValue,
    BusOff,
    Busy,
    CanwireError,
    Closed,
    ExtraMissing,
    HubError,
    HubLost,
    InUse,
    LineError,
    NoChannel,
    NoSuchBoard,
    NothingHeard,
    NotIdle,
    NotInitialised,
    NotReceived,
    NotTransmitted,
    QueueFull,
    Unplugged,
    Unsupported,
    WrongState,
)
from canwire.lab import Lab, LabBus, LabLinBus, LabLinNode, LabNode, NodeScript
from canwire.values.acceptance import Acceptance
from canwire.values.dlc import dlc_to_length, length_to_dlc
from canwire.values.error_frame import decode_error_frame, encode_error_frame
from canwire.values.event import BusEvent, ErrorKind, ErrorState, EventKind
from canwire.values.frame import Frame, frame_of_record
from canwire.values.lin.event import LinErrorKind, LinEvent, LinEventKind, LinOutcome, LinState
from canwire.values.lin.frame import LinFrame, lin_checksum, protected_id
from canwire.values.lin.record import linmsg_of_record, record_of_linmsg
from canwire.values.lin.schedule import LinSchedule, LinSlot, SlotKind
from canwire.values.lin.text import (
    LinLogLine,
    format_lin_frame,
    format_lin_log_line,
    parse_lin_frame,
    parse_lin_log_line,
)
from canwire.values.record import (
    ABORT_ON_ERROR,
    CONFIRM,
    CONFIRM_LOAD,
    HIGH_PRIORITY,
    LOOP_BACK,
    SELF_RECEPTION,
    SINGLE_SHOT,
    record_dtype,
)
from canwire.values.records import frames_to_array
from canwire.values.register import RegisterValue
from canwire.values.screen_text import format_candump_line, parse_candump_line
from canwire.values.slcan_text import SlcanReader, format_slcan_frame, parse_slcan_frame
from canwire.values.text import LogLine, format_frame, format_log_line, parse_frame, parse_log_line
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import TimingLimits
from canwire.version import __version__

if TYPE_CHECKING:
    from canwire.hub.bring_up import bring_up, start_line
    from canwire.hub.conflicts import conflicts_on
    from canwire.hub.connect import connect
    from canwire.hub.finding import LinePlace, every_line, find_lines
    from canwire.hub.handles.channel import HubChannel
    from canwire.hub.handles.control import Control
    from canwire.hub.handles.ends import RingEnd
    from canwire.hub.handles.event import Event
    from canwire.hub.handles.fifo import Fifo
    from canwire.hub.handles.filtered import Filtered
    from canwire.hub.handles.hub import Hub
    from canwire.hub.handles.lease import Lease
    from canwire.hub.handles.lin import LinControl, Monitor
    from canwire.hub.handles.scheduler import Scheduler
    from canwire.hub.serve import serve
    from canwire.hub.usual import default_address, kind_names, state_directory
    from canwire.hub.wanted_mode import WantedMode

# loaded when they are first asked for: the lab's users need no messages, sockets and boards
_LATER = {
    "Control": "handles.control",
    "Event": "handles.event",
    "Fifo": "handles.fifo",
    "Filtered": "handles.filtered",
    "Hub": "handles.hub",
    "HubChannel": "handles.channel",
    "Lease": "handles.lease",
    "LinControl": "handles.lin",
    "LinePlace": "finding",
    "Monitor": "handles.lin",
    "RingEnd": "handles.ends",
    "Scheduler": "handles.scheduler",
    "WantedMode": "wanted_mode",
    "bring_up": "bring_up",
    "conflicts_on": "conflicts",
    "connect": "connect",
    "default_address": "usual",
    "every_line": "finding",
    "find_lines": "finding",
    "kind_names": "usual",
    "serve": "serve",
    "start_line": "bring_up",
    "state_directory": "usual",
}


def __getattr__(name: str) -> Any:
    if name not in _LATER:
        raise AttributeError(f"module 'canwire' has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(f"canwire.hub.{_LATER[name]}"), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


__all__ = [
    "ABORT_ON_ERROR",
    "CONFIRM",
    "CONFIRM_LOAD",
    "FIELDS",
    "HIGH_PRIORITY",
    "LOOP_BACK",
    "NON_ISO",
    "SELF_RECEPTION",
    "SINGLE_SHOT",
    "Acceptance",
    "BadConfig",
    "BadDescription",
    "BadFilter",
    "BadFrame",
    "BadMessage",
    "BadText",
    "BadTiming",
    "BadValue",
    "BitLayout",
    "BitTiming",
    "BoardInfo",
    "BusEvent",
    "BusOff",
    "Busy",
    "CanwireError",
    "Capabilities",
    "ChannelMode",
    "ChannelStatus",
    "Closed",
    "Control",
    "CyclicStatus",
    "ErrorKind",
    "ErrorState",
    "Event",
    "EventKind",
    "ExtraMissing",
    "Feature",
    "Fifo",
    "FilterContent",
    "FilterMode",
    "FilterSetup",
    "Filtered",
    "Frame",
    "Hub",
    "HubChannel",
    "HubError",
    "HubLost",
    "InUse",
    "Lab",
    "LabBus",
    "LabLinBus",
    "LabLinNode",
    "LabNode",
    "Lease",
    "LinCapabilities",
    "LinControl",
    "LinErrorKind",
    "LinEvent",
    "LinEventKind",
    "LinFeature",
    "LinFrame",
    "LinLineStatus",
    "LinLogLine",
    "LinMode",
    "LinMonitorMode",
    "LinMonitorStatus",
    "LinOutcome",
    "LinSchedule",
    "LinSlot",
    "LinState",
    "LineError",
    "LineInfo",
    "LineMode",
    "LinePlace",
    "LineStatus",
    "LogLine",
    "Monitor",
    "NoChannel",
    "NoSuchBoard",
    "NodeScript",
    "NotIdle",
    "NotInitialised",
    "NotReceived",
    "NotTransmitted",
    "NothingHeard",
    "QueueFull",
    "RateConflict",
    "RegisterValue",
    "RingEnd",
    "RunningLine",
    "Scheduler",
    "Siblings",
    "SlcanReader",
    "SlotKind",
    "Ticks",
    "TimingLimits",
    "TimingRange",
    "Unplugged",
    "Unsupported",
    "WantedMode",
    "WireField",
    "WrongState",
    "__version__",
    "bring_up",
    "conflicts_on",
    "connect",
    "core_mode",
    "decode_error_frame",
    "default_address",
    "dlc_to_length",
    "encode_error_frame",
    "every_line",
    "find_lines",
    "format_candump_line",
    "format_frame",
    "format_lin_frame",
    "format_lin_log_line",
    "format_log_line",
    "format_rates",
    "format_setter",
    "format_slcan_frame",
    "frame_of_record",
    "frames_to_array",
    "kind_names",
    "length_to_dlc",
    "lin_checksum",
    "linmsg_of_record",
    "parse_candump_line",
    "parse_frame",
    "parse_lin_frame",
    "parse_lin_log_line",
    "parse_log_line",
    "parse_slcan_frame",
    "protected_id",
    "rate_conflicts",
    "record_dtype",
    "record_of_linmsg",
    "serve",
    "start_line",
    "state_directory",
    "wire_fields",
]
