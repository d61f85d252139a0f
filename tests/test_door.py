"""The one public door: its names, its examples, and the command behind `python -m canwire`."""

from __future__ import annotations

import ast
import doctest
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import canwire

# Adding a name is a promise; taking one away breaks somebody's program.
EXPORTED = """
Gateway GatewayCounts GatewayRules
Campaign CampaignRun Draw SmallestCause campaign repeat_run run_campaign shrink_run
BadLog Log LogBatch LogEntry LogFault LogFormat LogKind LogLimits LogMark LogWriter MarkKind create_log log_dtype
log_formats
ChannelStatistics IdentifierStatistics LogStatistics log_statistics
open_log Recorder RecordTriggers Trace open_trace convert_log merge_logs epoch_ns record
Offer offer offered_hubs relay route
lines_now unused_lines FoundAdapter find_adapters
BadSignals Database DecodedMessage MessageDescription SignalColumns SignalDescription load_database
DecodedMessages MessageCheck MessagePort OutgoingMessage Simulation
TimeState TimedProgram
LimitsConfig
LimitReached
ControllerOptions DelayCompensation
BadConfig BadMessage BoardInfo Capabilities ChannelMode ChannelStatus Control CyclicStatus Event Feature Fifo Filtered
FilterContent FilterMode FilterSetup Hub HubChannel HubError HubLost InUse Lease LineInfo LineMode LineStatus
CanBusFaults FaultInfo FaultStay HubBus HubFault HubLinBus HubPlace LinBusFaults Scripted
NoChannel NoSuchBoard NothingHeard NotInitialised RingEnd Scheduler Siblings Ticks TimingRange Unplugged Unsupported
WrongState
connect default_address frame_of_record in_time kind_names serve signals_end_waits WireField wire_fields
RateConflict RunningLine TimingConflict bus_conflicts rate_conflicts conflicts_on format_setter state_directory
LinNodeAttributes LinProduct LinSlaveConfiguration NodeTiming TimingCheck timing_checks timing_findings
Absence LinePlace WantedMode bring_up every_line find_lines format_rates start_line
Acceptance BadFilter BadFrame BadText BadTiming BadValue BitLayout BitTiming BusEvent BusOff
CanwireError Closed ErrorKind ErrorState EventKind ExtraMissing FIELDS Frame Lab LabBus LabNode
LineError LogLine NON_ISO NodeScript NotIdle NotReceived NotTransmitted QueueFull TimingLimits
__version__ core_mode dlc_to_length format_candump_line format_frame format_log_line frames_to_array
length_to_dlc RegisterValue SlcanReader format_slcan_frame parse_slcan_frame decode_error_frame encode_error_frame
ABORT_ON_ERROR CONFIRM CONFIRM_LOAD HIGH_PRIORITY LOOP_BACK SELF_RECEPTION SINGLE_SHOT
parse_candump_line parse_frame parse_log_line record_dtype
BadDescription Busy LabLinBus LabLinNode LinCapabilities LinControl LinErrorKind LinEvent LinEventKind LinFeature
LinFrame LinLineStatus LinLogLine LinMode LinMonitorMode LinMonitorStatus LinOutcome LinSchedule LinSlot LinState
Monitor SlotKind format_lin_frame format_lin_log_line lin_checksum lin_frame_of_record linmsg_of_record parse_lin_frame
parse_lin_schedule
parse_lin_log_line protected_id record_of_linmsg
Ring
Counters LineSettings InfoCode
LinCounters
LinLineState LinConfiguration
assign_frame_ids_request assign_nad_request lin_refusal read_by_identifier_request save_configuration_request
Behaviour
Periodic
Timer
Config
EventDescriptor
LabFaults
LabLinFaults
Fault
Place
LinFault
BoardConfig BusConfig
IsaPlace
DLC_MASK DLC_SHIFT ERROR_STATE_INDICATOR EXTENDED EXTENDED_DATA_LENGTH FAST_DATA_RATE OVERRUN REMOTE TYPE_MASK
"""


def test_names_are_pinned() -> None:
    assert sorted(canwire.__all__) == sorted(EXPORTED.split())
    missing = [name for name in canwire.__all__ if not hasattr(canwire, name)]
    assert missing == []


def test_nothing_else_stands_in_the_door() -> None:
    public = {
        name
        for name, value in vars(canwire).items()
        if not name.startswith("_") and not isinstance(value, ModuleType)
    }
    assert public - {"TYPE_CHECKING"} <= set(canwire.__all__)


def test_the_table_says_what_type_checkers_read() -> None:
    tree = ast.parse(Path(canwire.__file__).read_text(encoding="utf-8"))
    (block,) = (
        node for node in tree.body if isinstance(node, ast.If) and "not" not in ast.unparse(node.test)
    )
    imported = {
        alias.name: str(node.module)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    modules = {name for name, place in imported.items() if place == "canwire"}
    assert modules == canwire._MODULES
    places = {name: f"canwire.{place}" for name, place in canwire._PLACES.items()}
    assert {name: place for name, place in imported.items() if name not in modules} == places
    errors = {name for name in canwire.__all__ if getattr(canwire, name).__class__ is type
              and getattr(canwire, name).__module__ == "canwire.errors"}  # fmt: skip
    assert {*places, *errors, "__version__"} == set(canwire.__all__)


def test_asking_for_the_door_loads_nothing_behind_it() -> None:
    """A test suite of somebody who only has canwire installed pays for nothing."""
    program = "import sys, canwire.pytest_plugin; print(*sorted(name for name in sys.modules if name[:7] == 'canwire'))"
    shown = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )
    assert shown.stdout.split() == ["canwire", "canwire.errors", "canwire.pytest_plugin", "canwire.version"]


def test_a_bench_loads_no_sockets_nor_what_finds_plug_ins() -> None:
    program = "import sys, canwire; canwire.Lab().can_bus().node('a'); print(*sys.modules)"
    shown = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )
    assert {"socket", "importlib.metadata", "msgspec", "numpy", "asyncio"} & set(
        shown.stdout.split()
    ) == set()


def test_who_connects_to_a_hub_elsewhere_loads_no_boards() -> None:
    program = "import sys, canwire; canwire.connect; canwire.HubChannel; print(*sys.modules)"
    shown = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )
    loaded = set(shown.stdout.split())
    assert "canwire.hub.links.unix_socket.client" in loaded
    assert {"canwire.boards.catalogue", "canwire.hub.owner.engine", "tomllib", "tempfile"} & loaded == set()


def test_programs_views_are_found_without_an_import_of_their_own() -> None:
    program = "import canwire; print(canwire.vci.__name__, canwire.ldf.__name__)"
    shown = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True, timeout=60
    )
    assert shown.stdout.split() == ["canwire.vci", "canwire.ldf"]


def test_a_name_that_is_not_there() -> None:
    with pytest.raises(AttributeError, match="module 'canwire' has no attribute 'Fram'"):
        canwire.Fram  # type: ignore[attr-defined]  # noqa: B018


def test_examples_in_docstrings() -> None:
    names = {name: getattr(canwire, name) for name in canwire.__all__}
    finder = doctest.DocTestFinder(recurse=False)
    runner = doctest.DocTestRunner(optionflags=doctest.ELLIPSIS)
    found = [finder.find(canwire, "canwire", globs={})]
    found += [finder.find(value, name, globs=dict(names)) for name, value in names.items()]
    for examples in found:
        for example in examples:
            runner.run(example)
    assert runner.tries > 5
    assert runner.failures == 0


def test_python_m_is_the_command() -> None:
    shown = subprocess.run(
        [sys.executable, "-m", "canwire", "--version"], capture_output=True, text=True, check=True, timeout=60
    )
    mode = "compiled core" if canwire.core_mode() == "compiled" else "uncompiled core: slower"
    assert (shown.stdout, shown.stderr) == (f"canwire {canwire.__version__} ({mode})\n", "")


def test_what_is_loaded_later_is_shown_too() -> None:
    assert {*canwire.__all__, "ldf", "vci"} <= set(dir(canwire))
