"""The output of `canwire devices --json`: numbers as numbers, everything else by name."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from canwire import (
    BitTiming,
    BoardInfo,
    ErrorKind,
    ErrorState,
    Feature,
    LineInfo,
    LineStatus,
    LinFeature,
    LinState,
)
from canwire.commands.devices.uses import LinUse, Use, errors_by_kind

if TYPE_CHECKING:
    from canwire import TimeState


def board_facts(board: BoardInfo, states: list[Use]) -> dict[str, Any]:
    """The JSON object of a board."""
    lines = [
        line_facts(index, line, status)
        for index, (line, status) in enumerate(zip(board.lines, states, strict=True))
    ]
    return {**asdict(board), "lines": lines}


def line_facts(index: int, line: LineInfo, status: Use) -> dict[str, Any]:
    """The JSON object of a line: numbers as numbers, states, errors and features by their names, bytes in hex."""
    if isinstance(status, LinUse):
        return _lin_facts(index, line, status)
    capabilities = asdict(line.capabilities)
    capabilities["features"] = [str(one.name) for one in Feature if line.capabilities.can(one)]
    return {
        **asdict(line),
        "index": index,
        "capabilities": capabilities,
        "status": {
            **asdict(status),
            "state": ErrorState(status.state).name,
            "last_error": ErrorKind(status.last_error).name,
            "mode": _mode_facts(status),
        },
    }


def _lin_facts(index: int, line: LineInfo, use: LinUse) -> dict[str, Any]:
    """A LIN line has its capabilities in `lin`; `capabilities` is None."""
    assert line.lin is not None
    features = [str(one.name) for one in LinFeature if line.lin.can(one)]
    mode = use.status.mode
    return {
        **asdict(line),
        "index": index,
        "capabilities": None,
        "lin": {**asdict(line.lin), "features": features},
        "status": {
            **asdict(use.status),
            "state": LinState(use.status.state).name,
            "errors": errors_by_kind(use.status),
            "mode": None if mode is None else {**asdict(mode), "note": mode.note.hex()},
            "control_holder": use.control_holder,
            "exclusive": use.exclusive,
        },
    }


def _mode_facts(status: LineStatus) -> dict[str, Any] | None:
    if status.mode is None:
        return None
    return {
        **asdict(status.mode),
        "note": status.mode.note.hex(),
        "timing": _timing_facts(status.mode.timing),
        "data_timing": _timing_facts(status.mode.data_timing),
    }


def _timing_facts(timing: BitTiming | None) -> dict[str, Any] | None:
    if timing is None:
        return None
    return {**asdict(timing), "bit_rate": timing.bit_rate, "sample_point": round(timing.sample_point, 4)}


def time_facts(state: TimeState) -> dict[str, Any]:
    """The JSON object of a hub's time in lockstep mode."""
    programs = [
        {"name": one.name, "thread": one.thread, "waits": one.waits, "until_ns": one.until_ns}
        for one in state.programs
    ]
    return {
        "now_ns": state.now_ns,
        "programs": programs,
        "standstill": state.standstill,
        "pace": state.pace or None,
    }
