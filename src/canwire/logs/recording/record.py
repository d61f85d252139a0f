"""`record`: records a line, node or bus of CAN or LIN in log files."""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from canwire.errors import BadValue
from canwire.hub.handles.channel import HubChannel
from canwire.hub.handles.lin import Monitor
from canwire.hub.wanted_mode import WantedMode
from canwire.logs.entry import LogKind
from canwire.logs.formats import format_to_write, load_format, log_formats
from canwire.logs.recording.files import RecordingFiles
from canwire.logs.recording.hub_source import HubSource
from canwire.logs.recording.lab import LabLinSource, LabSource
from canwire.logs.recording.recorder import Recorder, RecordingSource
from canwire.logs.recording.several import SeveralShared, SeveralSources
from canwire.logs.recording.shared import SharedSource, shared_sources
from canwire.logs.recording.shared_lin import SharedLinSource
from canwire.logs.recording.triggers import RecordTriggers
from canwire.values.checks import finite, whole

if TYPE_CHECKING:
    from canwire.lab import LabBus, LabLinBus, LabLinNode, LabNode

_SMALLEST = 10_000  # bytes of a file that rotates: below, files would be made faster than they fill
_QUEUE = 1 << 16  # of the node that listens for a recording


def record(
    line: str
    | HubChannel
    | Monitor
    | LabNode
    | LabBus
    | LabLinNode
    | LabLinBus
    | Sequence[str | HubChannel | Monitor | LabNode | LabBus | LabLinNode | LabLinBus],
    path: str | os.PathLike[str],
    *,
    format: str | None = None,
    channel: str | None = None,
    rotate_bytes: int | None = None,
    rotate_s: float | None = None,
    hub: str | None = None,
    bit_rate: int | None = None,
    data_bit_rate: int | None = None,
    epoch_ns: int = 0,
    triggers: RecordTriggers | None = None,
) -> Recorder:
    """Record everything that a line receives in a log file, until the recorder is closed.

    `line` is the name of a shared line ("can0", "HW000001:0", "lin0"), which is started at `bit_rate` if it is not
    running (a LIN line as a slave); or a HubChannel or Monitor, set up and active, which then belongs to the recorder,
    and whose times `epoch_ns` converts to dates; or a node of a lab, or a bus, which gets a listening node. Several
    lines, in a list, are recorded in one log in order of time; "any" is a line of every shared bus. `format` replaces
    the path's suffix. `channel` is the name of a single line in the log. With `rotate_bytes` or `rotate_s` (seconds)
    the files are NAME-0001, NAME-0002, ...: a new one begins when the last is larger or older; a trace (`path` with a
    slash at its end) begins the next file in its folder, by bytes of records. `hub` is the hub's address. With
    `triggers` only parts are kept.

    Frames, error frames, changes of state and losses are recorded; also the frames that a line sends, those of a
    LabNode only with `self_reception`. Raises BadValue, NoSuchBoard, HubError, ExtraMissing, OSError.

    >>> with Lab() as lab:  # doctest: +SKIP
    ...     with record(lab.can_bus("can0", bit_rate=500_000), "drive.blf") as recorder:
    ...         lab.run_for(10)
    """
    name = os.fspath(path)
    if rotate_bytes is not None:
        whole("rotate_bytes", rotate_bytes, _SMALLEST, 1 << 62)
    if rotate_s is not None:
        finite("rotate_s", rotate_s, 0.5, 1e9)
    lines = list(line) if isinstance(line, list | tuple) else [line]
    with ExitStack() as closing:
        sources = _sources(lines, channel, hub, WantedMode(bit_rate, data_bit_rate), epoch_ns, closing)
        if any(isinstance(source, SharedLinSource | LabLinSource) for source in sources):
            _check_holds_lin(name, format)
        shared = [source for source in sources if isinstance(source, HubSource)]
        if shared and len(shared) < len(sources):
            raise BadValue("lines of a hub and of the lab have different times; record them in separate logs")
        source = sources[0] if len(sources) == 1 else (SeveralShared if shared else SeveralSources)(sources)
        closing.callback(source.close)
        files = RecordingFiles(
            name,
            format,
            rotate_bytes=rotate_bytes,
            rotate_s=rotate_s,
            dated=any(one.epoch_ns > 0 for one in shared),
            start_ns=None,
            clock="hub" if shared else "lab",
        )
        return Recorder(source, files, closing.pop_all(), triggers)


def _check_holds_lin(path: str, format: str | None) -> None:
    """Raise BadValue for a format that cannot hold any data of a LIN line."""
    row = format_to_write(path, format)
    if LogKind.LIN_FRAME in load_format(row).Writer.holds:
        return
    others = [
        one.name
        for one in log_formats()
        if one.writes and one.name != "journal" and LogKind.LIN_FRAME in load_format(one).Writer.holds
    ]
    raise BadValue(f"{path}: {row.name} holds no LIN frames; these do: {', '.join(others)}")


def _sources(
    lines: list[Any],
    channel: str | None,
    hub: str | None,
    wanted: WantedMode,
    epoch_ns: int,
    closing: ExitStack,
) -> list[Any]:
    """Return the sources of the lines: for names of shared lines, sources on one hub; otherwise one source for each
    line."""
    if not lines:
        raise BadValue("no line to record")
    if all(isinstance(line, str) for line in lines):
        return list(shared_sources(lines, hub, wanted, channel, closing))
    if channel is not None and len(lines) > 1:
        raise BadValue(f"channel {channel!r}: for one line; these are {len(lines)}")
    sources = []
    for line in lines:
        sources.append(_source(line, channel, epoch_ns))
        closing.callback(sources[-1].close)
    return sources


def _source(line: Any, channel: str | None, epoch_ns: int) -> RecordingSource:
    if isinstance(line, HubChannel):
        return SharedSource(line, channel or "can0", epoch_ns, None, ExitStack())
    if isinstance(line, Monitor):
        return SharedLinSource(line, channel or "lin0", epoch_ns, None, ExitStack())
    if hasattr(line, "respond"):
        return LabLinSource(line, channel or line.bus.name, own=False)
    if hasattr(line, "slave"):
        listener = line.slave("recorder", receive_queue=_QUEUE)
        return LabLinSource(listener, channel or line.name, own=True)
    if hasattr(line, "receive_array"):
        return LabSource(line, channel or line.bus.name, own=False)
    if hasattr(line, "can_bus") or not hasattr(line, "node"):
        raise BadValue(
            f"{line!r}: no line that can be recorded: a name, a HubChannel, a Monitor, or of the lab"
        )
    node = line.node("recorder", listen_only=True, receive_queue=_QUEUE, transmit_queue=1)
    return LabSource(node, channel or line.name, own=True)
