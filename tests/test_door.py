"""The one public door: its names, its examples, and the command behind `python -m canwire`."""

from __future__ import annotations

import doctest
import subprocess
import sys
from types import ModuleType

import canwire

# Adding a name is a promise; taking one away breaks somebody's program.
EXPORTED = """
BadConfig BadMessage BoardInfo Capabilities ChannelMode ChannelStatus Control CyclicStatus Event Feature Fifo Filtered
FilterContent FilterMode FilterSetup Hub HubChannel HubError HubLost InUse Lease LineInfo LineMode LineStatus
NoChannel NoSuchBoard NothingHeard NotInitialised RingEnd Scheduler Siblings Ticks TimingRange Unplugged Unsupported
WrongState
connect default_address frame_of_record kind_names serve WireField wire_fields
RateConflict RunningLine rate_conflicts conflicts_on format_setter state_directory
LinePlace WantedMode bring_up every_line find_lines format_rates start_line
Acceptance BadFilter BadFrame BadText BadTiming BadValue BitLayout BitTiming BusEvent BusOff
CanwireError Closed ErrorKind ErrorState EventKind ExtraMissing FIELDS Frame Lab LabBus LabNode
LineError LogLine NON_ISO NodeScript NotIdle NotReceived NotTransmitted QueueFull TimingLimits
__version__ core_mode dlc_to_length format_candump_line format_frame format_log_line frames_to_array
length_to_dlc RegisterValue SlcanReader format_slcan_frame parse_slcan_frame decode_error_frame encode_error_frame
ABORT_ON_ERROR CONFIRM CONFIRM_LOAD HIGH_PRIORITY LOOP_BACK SELF_RECEPTION SINGLE_SHOT
parse_candump_line parse_frame parse_log_line record_dtype
BadDescription Busy LabLinBus LabLinNode LinCapabilities LinControl LinErrorKind LinEvent LinEventKind LinFeature
LinFrame LinLineStatus LinLogLine LinMode LinMonitorMode LinMonitorStatus LinOutcome LinSchedule LinSlot LinState
Monitor SlotKind format_lin_frame format_lin_log_line lin_checksum linmsg_of_record parse_lin_frame
parse_lin_log_line protected_id record_of_linmsg
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
    assert public - {"TYPE_CHECKING", "Any"} == set(canwire.__all__) - {"__version__"} - set(canwire._LATER)


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
    assert set(canwire.__all__) <= set(dir(canwire))
