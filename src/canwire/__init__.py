"""CAN, CAN FD and LIN buses that behave like copper. Every public name is in this package.

>>> import canwire
>>> with canwire.Lab() as lab:
...     bus = lab.can_bus("can0", bit_rate=500_000)
...     a, b = bus.node("engine"), bus.node("tester")
...     a.send(canwire.Frame(0x123, b"\\x11\\x22"))
...     lab.run_until_idle()
...     b.receive()
Frame(0x123, bytes.fromhex("1122"), timestamp_ns=124000)
"""

from canwire.errors import (
    BadConfig,
    BadDescription,
    BadFilter,
    BadFrame,
    BadLog,
    BadMessage,
    BadSignals,
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
    LimitReached,
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
from canwire.version import __version__

TYPE_CHECKING = False  # type checkers take it as true; `typing` would be most of what the door takes to load
if TYPE_CHECKING:  # what the table below says to the interpreter
    from canwire import acan as acan
    from canwire import candrv as candrv
    from canwire import ecus as ecus
    from canwire import ldf as ldf
    from canwire import python_can as python_can
    from canwire import slcan as slcan
    from canwire import vci as vci
    from canwire.boards.adapters import FoundAdapter, find_adapters
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
    from canwire.boards.can.rates import (
        RateConflict,
        RunningLine,
        TimingConflict,
        bus_conflicts,
        format_rates,
        format_setter,
        rate_conflicts,
    )
    from canwire.boards.catalogue import kind_names
    from canwire.boards.config.configuration import Config
    from canwire.boards.config.limits import LimitsConfig
    from canwire.boards.config.tables import BoardConfig, BusConfig
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
    from canwire.boards.isa import IsaPlace
    from canwire.boards.lin.modes import LinLineStatus, LinMode, LinMonitorMode, LinMonitorStatus
    from canwire.bus.can.bit_layout import FIELDS, BitLayout
    from canwire.bus.can.bits import NON_ISO
    from canwire.bus.can.faults.faults import Fault
    from canwire.bus.can.faults.places import Place
    from canwire.bus.can.wire_fields import WireField, wire_fields
    from canwire.bus.lin.faults import LinFault
    from canwire.bus.scripted import Scripted
    from canwire.campaigns.campaign import Campaign, campaign
    from canwire.campaigns.parameters import Draw
    from canwire.campaigns.playing import CampaignRun
    from canwire.campaigns.running import repeat_run, run_campaign
    from canwire.campaigns.shrinking.shrink import SmallestCause, shrink_run
    from canwire.core import core_mode
    from canwire.databases.checking import MessageCheck
    from canwire.databases.columns import SignalColumns
    from canwire.databases.database import Database
    from canwire.databases.decoded import DecodedMessage
    from canwire.databases.description import MessageDescription, SignalDescription
    from canwire.databases.loading import load_database
    from canwire.databases.port import DecodedMessages, MessagePort
    from canwire.databases.simulation import OutgoingMessage, Simulation
    from canwire.drivers.driver import Counters, LineSettings
    from canwire.drivers.lin_driver import LinCounters
    from canwire.errors import LimitReached
    from canwire.gateway.gateway import Gateway
    from canwire.gateway.rules import GatewayCounts, GatewayRules
    from canwire.hub.absence import Absence
    from canwire.hub.bring_up import bring_up, start_line
    from canwire.hub.conflicts import conflicts_on
    from canwire.hub.connect import connect
    from canwire.hub.finding import LinePlace, every_line, find_lines, lines_now, unused_lines
    from canwire.hub.handles.bus.bus import HubBus, HubLinBus
    from canwire.hub.handles.bus.can import CanBusFaults
    from canwire.hub.handles.bus.fault import HubFault
    from canwire.hub.handles.bus.lin import LinBusFaults
    from canwire.hub.handles.bus.setting import FaultStay
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
    from canwire.hub.links.network.keys import Offer
    from canwire.hub.offer import offer, offered_hubs, relay, route
    from canwire.hub.protocol.fault_messages import FaultInfo, HubPlace
    from canwire.hub.protocol.lin_messages import LinConfiguration, LinLineState
    from canwire.hub.protocol.time_messages import TimedProgram, TimeState
    from canwire.hub.serve import serve
    from canwire.hub.usual import default_address, state_directory
    from canwire.hub.wall_clock import epoch_ns
    from canwire.hub.wanted_mode import WantedMode
    from canwire.lab import Lab, LabBus, LabLinBus, LabLinNode, LabNode, NodeScript
    from canwire.lab.can.bus import Behaviour
    from canwire.lab.can.faults import LabFaults
    from canwire.lab.can.script import Periodic
    from canwire.lab.in_time import in_time
    from canwire.lab.lin.faults import LabLinFaults
    from canwire.logs.batch import LogBatch, log_dtype
    from canwire.logs.convert import convert_log
    from canwire.logs.entry import LogEntry, LogKind, LogMark, MarkKind
    from canwire.logs.formats import LogFormat, log_formats
    from canwire.logs.limits import LogLimits
    from canwire.logs.log import Log, open_log
    from canwire.logs.merging import merge_logs
    from canwire.logs.queries.trace import Trace, open_trace
    from canwire.logs.recording.record import record
    from canwire.logs.recording.recorder import Recorder
    from canwire.logs.recording.triggers import RecordTriggers
    from canwire.logs.source import LogFault
    from canwire.logs.statistics.collecting import log_statistics
    from canwire.logs.statistics.results import ChannelStatistics, IdentifierStatistics, LogStatistics
    from canwire.logs.writer import LogWriter, create_log
    from canwire.platform import EventDescriptor, signals_end_waits
    from canwire.ring import Ring
    from canwire.timeline import Timer
    from canwire.values.acceptance import Acceptance
    from canwire.values.controller_options import ControllerOptions, DelayCompensation
    from canwire.values.dlc import dlc_to_length, length_to_dlc
    from canwire.values.error_frame import decode_error_frame, encode_error_frame
    from canwire.values.event import BusEvent, ErrorKind, ErrorState, EventKind, InfoCode
    from canwire.values.frame import Frame, frame_of_record
    from canwire.values.lin.configuration import LinNodeAttributes, LinProduct, LinSlaveConfiguration
    from canwire.values.lin.event import LinErrorKind, LinEvent, LinEventKind, LinOutcome, LinState
    from canwire.values.lin.frame import LinFrame, lin_checksum, protected_id
    from canwire.values.lin.record import lin_frame_of_record, linmsg_of_record, record_of_linmsg
    from canwire.values.lin.requests import (
        assign_frame_ids_request,
        assign_nad_request,
        lin_refusal,
        read_by_identifier_request,
        save_configuration_request,
    )
    from canwire.values.lin.schedule import LinSchedule, LinSlot, SlotKind
    from canwire.values.lin.slots import parse_lin_schedule
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
        DLC_MASK,
        DLC_SHIFT,
        ERROR_STATE_INDICATOR,
        EXTENDED,
        EXTENDED_DATA_LENGTH,
        FAST_DATA_RATE,
        HIGH_PRIORITY,
        LOOP_BACK,
        OVERRUN,
        REMOTE,
        SELF_RECEPTION,
        SINGLE_SHOT,
        TYPE_MASK,
        record_dtype,
    )
    from canwire.values.records import frames_to_array
    from canwire.values.register import RegisterValue
    from canwire.values.screen_text import format_candump_line, parse_candump_line
    from canwire.values.slcan_text import SlcanReader, format_slcan_frame, parse_slcan_frame
    from canwire.values.text import LogLine, format_frame, format_log_line, parse_frame, parse_log_line
    from canwire.values.timing.agreement import timing_checks, timing_findings
    from canwire.values.timing.bit_timing import BitTiming
    from canwire.values.timing.check import NodeTiming, TimingCheck
    from canwire.values.timing.limits import TimingLimits

_NAMES = {
    "boards.config.limits": "LimitsConfig",
    "errors": "LimitReached",
    "values.controller_options": "ControllerOptions DelayCompensation",
    "boards.can.modes": (
        "ChannelMode ChannelStatus CyclicStatus FilterContent FilterMode FilterSetup LineMode LineStatus "
        "Siblings"
    ),
    "boards.can.rates": (
        "RateConflict RunningLine TimingConflict bus_conflicts format_rates format_setter rate_conflicts"
    ),
    "boards.catalogue": "kind_names",
    "boards.config.configuration": "Config",
    "boards.config.tables": "BoardConfig BusConfig",
    "boards.description": (
        "BoardInfo Capabilities Feature LinCapabilities LinFeature LineInfo Ticks TimingRange"
    ),
    "boards.isa": "IsaPlace",
    "boards.lin.modes": "LinLineStatus LinMode LinMonitorMode LinMonitorStatus",
    "bus.can.bit_layout": "BitLayout FIELDS",
    "bus.can.bits": "NON_ISO",
    "bus.can.faults.faults": "Fault",
    "bus.can.faults.places": "Place",
    "bus.can.wire_fields": "WireField wire_fields",
    "bus.lin.faults": "LinFault",
    "bus.scripted": "Scripted",
    "campaigns.campaign": "Campaign campaign",
    "campaigns.parameters": "Draw",
    "campaigns.playing": "CampaignRun",
    "campaigns.running": "repeat_run run_campaign",
    "campaigns.shrinking.shrink": "SmallestCause shrink_run",
    "core": "core_mode",
    "databases.columns": "SignalColumns",
    "databases.checking": "MessageCheck",
    "databases.database": "Database",
    "databases.decoded": "DecodedMessage",
    "databases.description": "MessageDescription SignalDescription",
    "databases.loading": "load_database",
    "databases.port": "DecodedMessages MessagePort",
    "databases.simulation": "OutgoingMessage Simulation",
    "drivers.driver": "Counters LineSettings",
    "drivers.lin_driver": "LinCounters",
    "gateway.gateway": "Gateway",
    "gateway.rules": "GatewayCounts GatewayRules",
    "hub.absence": "Absence",
    "hub.bring_up": "bring_up start_line",
    "hub.conflicts": "conflicts_on",
    "hub.connect": "connect",
    "boards.adapters": "FoundAdapter find_adapters",
    "hub.finding": "LinePlace every_line find_lines lines_now unused_lines",
    "hub.handles.bus.bus": "HubBus HubLinBus",
    "hub.handles.bus.can": "CanBusFaults",
    "hub.handles.bus.fault": "HubFault",
    "hub.handles.bus.lin": "LinBusFaults",
    "hub.handles.bus.setting": "FaultStay",
    "hub.handles.channel": "HubChannel",
    "hub.handles.control": "Control",
    "hub.handles.ends": "RingEnd",
    "hub.handles.event": "Event",
    "hub.handles.fifo": "Fifo",
    "hub.handles.filtered": "Filtered",
    "hub.handles.hub": "Hub",
    "hub.handles.lease": "Lease",
    "hub.handles.lin": "LinControl Monitor",
    "hub.handles.scheduler": "Scheduler",
    "hub.links.network.keys": "Offer",
    "hub.offer": "offer offered_hubs relay route",
    "hub.protocol.fault_messages": "FaultInfo HubPlace",
    "hub.protocol.time_messages": "TimeState TimedProgram",
    "hub.protocol.lin_messages": "LinConfiguration LinLineState",
    "hub.serve": "serve",
    "hub.usual": "default_address state_directory",
    "hub.wall_clock": "epoch_ns",
    "hub.wanted_mode": "WantedMode",
    "lab": "Lab LabBus LabLinBus LabLinNode LabNode NodeScript",
    "lab.can.bus": "Behaviour",
    "lab.can.faults": "LabFaults",
    "lab.can.script": "Periodic",
    "lab.in_time": "in_time",
    "lab.lin.faults": "LabLinFaults",
    "logs.batch": "LogBatch log_dtype",
    "logs.entry": "LogEntry LogKind LogMark MarkKind",
    "logs.formats": "LogFormat log_formats",
    "logs.log": "Log open_log",
    "logs.convert": "convert_log",
    "logs.merging": "merge_logs",
    "logs.queries.trace": "Trace open_trace",
    "logs.recording.record": "record",
    "logs.recording.recorder": "Recorder",
    "logs.recording.triggers": "RecordTriggers",
    "logs.limits": "LogLimits",
    "logs.source": "LogFault",
    "logs.statistics.collecting": "log_statistics",
    "logs.statistics.results": "ChannelStatistics IdentifierStatistics LogStatistics",
    "logs.writer": "LogWriter create_log",
    "platform": "EventDescriptor signals_end_waits",
    "ring": "Ring",
    "timeline": "Timer",
    "values.acceptance": "Acceptance",
    "values.dlc": "dlc_to_length length_to_dlc",
    "values.error_frame": "decode_error_frame encode_error_frame",
    "values.event": "BusEvent ErrorKind ErrorState EventKind InfoCode",
    "values.frame": "Frame frame_of_record",
    "values.lin.configuration": "LinNodeAttributes LinProduct LinSlaveConfiguration",
    "values.lin.event": "LinErrorKind LinEvent LinEventKind LinOutcome LinState",
    "values.lin.frame": "LinFrame lin_checksum protected_id",
    "values.lin.record": "lin_frame_of_record linmsg_of_record record_of_linmsg",
    "values.lin.requests": (
        "assign_frame_ids_request assign_nad_request lin_refusal read_by_identifier_request save_configuration_request"
    ),
    "values.lin.schedule": "LinSchedule LinSlot SlotKind",
    "values.lin.slots": "parse_lin_schedule",
    "values.lin.text": "LinLogLine format_lin_frame format_lin_log_line parse_lin_frame parse_lin_log_line",
    "values.record": (
        "ABORT_ON_ERROR CONFIRM CONFIRM_LOAD DLC_MASK DLC_SHIFT ERROR_STATE_INDICATOR EXTENDED "
        "EXTENDED_DATA_LENGTH FAST_DATA_RATE HIGH_PRIORITY LOOP_BACK OVERRUN REMOTE SELF_RECEPTION "
        "SINGLE_SHOT TYPE_MASK record_dtype"
    ),
    "values.records": "frames_to_array",
    "values.register": "RegisterValue",
    "values.screen_text": "format_candump_line parse_candump_line",
    "values.slcan_text": "SlcanReader format_slcan_frame parse_slcan_frame",
    "values.text": "LogLine format_frame format_log_line parse_frame parse_log_line",
    "values.timing.agreement": "timing_checks timing_findings",
    "values.timing.bit_timing": "BitTiming",
    "values.timing.check": "NodeTiming TimingCheck",
    "values.timing.limits": "TimingLimits",
}
"""The names of each file. A file is loaded when a program first uses one of its names: a frame loads no hub.

Errors are loaded with the package: a program may need them while the interpreter shuts down.
"""
_MODULES = frozenset({"acan", "candrv", "ecus", "ldf", "python_can", "slcan", "vci"})
"""Interfaces for programs, and modules that need an extra: not exported, but `canwire.ldf` loads one."""
_PLACES = {name: place for place, names in _NAMES.items() for name in names.split()}


def _load(name: str) -> object:
    from importlib import import_module

    if name in _MODULES:
        return import_module(f"canwire.{name}")
    if name not in _PLACES:
        from canwire.values.mistakes.names import OF_THE_DOOR  # for mistakes alone

        advice = f": {OF_THE_DOOR[name]}" if name in OF_THE_DOOR else ""
        raise AttributeError(f"module 'canwire' has no attribute {name!r}{advice}")
    found: object = getattr(import_module(f"canwire.{_PLACES[name]}"), name)
    globals()[name] = found  # the next time at full speed
    return found


if not TYPE_CHECKING:
    __getattr__ = _load


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, *_MODULES})


__all__ = [
    "ABORT_ON_ERROR",
    "CONFIRM",
    "CONFIRM_LOAD",
    "DLC_MASK",
    "DLC_SHIFT",
    "ERROR_STATE_INDICATOR",
    "EXTENDED",
    "EXTENDED_DATA_LENGTH",
    "FAST_DATA_RATE",
    "FIELDS",
    "HIGH_PRIORITY",
    "LOOP_BACK",
    "NON_ISO",
    "OVERRUN",
    "REMOTE",
    "SELF_RECEPTION",
    "SINGLE_SHOT",
    "TYPE_MASK",
    "Absence",
    "Acceptance",
    "BadConfig",
    "BadDescription",
    "BadFilter",
    "BadFrame",
    "BadLog",
    "BadMessage",
    "BadSignals",
    "BadText",
    "BadTiming",
    "BadValue",
    "Behaviour",
    "BitLayout",
    "BitTiming",
    "BoardConfig",
    "BoardInfo",
    "BusConfig",
    "BusEvent",
    "BusOff",
    "Busy",
    "Campaign",
    "CampaignRun",
    "CanBusFaults",
    "CanwireError",
    "Capabilities",
    "ChannelMode",
    "ChannelStatistics",
    "ChannelStatus",
    "Closed",
    "Config",
    "Control",
    "ControllerOptions",
    "Counters",
    "CyclicStatus",
    "Database",
    "DecodedMessage",
    "DecodedMessages",
    "DelayCompensation",
    "Draw",
    "ErrorKind",
    "ErrorState",
    "Event",
    "EventDescriptor",
    "EventKind",
    "ExtraMissing",
    "Fault",
    "FaultInfo",
    "FaultStay",
    "Feature",
    "Fifo",
    "FilterContent",
    "FilterMode",
    "FilterSetup",
    "Filtered",
    "FoundAdapter",
    "Frame",
    "Gateway",
    "GatewayCounts",
    "GatewayRules",
    "Hub",
    "HubBus",
    "HubChannel",
    "HubError",
    "HubFault",
    "HubLinBus",
    "HubLost",
    "HubPlace",
    "IdentifierStatistics",
    "InUse",
    "InfoCode",
    "IsaPlace",
    "Lab",
    "LabBus",
    "LabFaults",
    "LabLinBus",
    "LabLinFaults",
    "LabLinNode",
    "LabNode",
    "Lease",
    "LimitReached",
    "LimitsConfig",
    "LinBusFaults",
    "LinCapabilities",
    "LinConfiguration",
    "LinControl",
    "LinCounters",
    "LinErrorKind",
    "LinEvent",
    "LinEventKind",
    "LinFault",
    "LinFeature",
    "LinFrame",
    "LinLineState",
    "LinLineStatus",
    "LinLogLine",
    "LinMode",
    "LinMonitorMode",
    "LinMonitorStatus",
    "LinNodeAttributes",
    "LinOutcome",
    "LinProduct",
    "LinSchedule",
    "LinSlaveConfiguration",
    "LinSlot",
    "LinState",
    "LineError",
    "LineInfo",
    "LineMode",
    "LinePlace",
    "LineSettings",
    "LineStatus",
    "Log",
    "LogBatch",
    "LogEntry",
    "LogFault",
    "LogFormat",
    "LogKind",
    "LogLimits",
    "LogLine",
    "LogMark",
    "LogStatistics",
    "LogWriter",
    "MarkKind",
    "MessageCheck",
    "MessageDescription",
    "MessagePort",
    "Monitor",
    "NoChannel",
    "NoSuchBoard",
    "NodeScript",
    "NodeTiming",
    "NotIdle",
    "NotInitialised",
    "NotReceived",
    "NotTransmitted",
    "NothingHeard",
    "Offer",
    "OutgoingMessage",
    "Periodic",
    "Place",
    "QueueFull",
    "RateConflict",
    "RecordTriggers",
    "Recorder",
    "RegisterValue",
    "Ring",
    "RingEnd",
    "RunningLine",
    "Scheduler",
    "Scripted",
    "Siblings",
    "SignalColumns",
    "SignalDescription",
    "Simulation",
    "SlcanReader",
    "SlotKind",
    "SmallestCause",
    "Ticks",
    "TimeState",
    "TimedProgram",
    "Timer",
    "TimingCheck",
    "TimingConflict",
    "TimingLimits",
    "TimingRange",
    "Trace",
    "Unplugged",
    "Unsupported",
    "WantedMode",
    "WireField",
    "WrongState",
    "__version__",
    "assign_frame_ids_request",
    "assign_nad_request",
    "bring_up",
    "bus_conflicts",
    "campaign",
    "conflicts_on",
    "connect",
    "convert_log",
    "core_mode",
    "create_log",
    "decode_error_frame",
    "default_address",
    "dlc_to_length",
    "encode_error_frame",
    "epoch_ns",
    "every_line",
    "find_adapters",
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
    "in_time",
    "kind_names",
    "length_to_dlc",
    "lin_checksum",
    "lin_frame_of_record",
    "lin_refusal",
    "lines_now",
    "linmsg_of_record",
    "load_database",
    "log_dtype",
    "log_formats",
    "log_statistics",
    "merge_logs",
    "offer",
    "offered_hubs",
    "open_log",
    "open_trace",
    "parse_candump_line",
    "parse_frame",
    "parse_lin_frame",
    "parse_lin_log_line",
    "parse_lin_schedule",
    "parse_log_line",
    "parse_slcan_frame",
    "protected_id",
    "rate_conflicts",
    "read_by_identifier_request",
    "record",
    "record_dtype",
    "record_of_linmsg",
    "relay",
    "repeat_run",
    "route",
    "run_campaign",
    "save_configuration_request",
    "serve",
    "shrink_run",
    "signals_end_waits",
    "start_line",
    "state_directory",
    "timing_checks",
    "timing_findings",
    "unused_lines",
    "wire_fields",
]
