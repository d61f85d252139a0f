"""`record`: a line, node or bus into log files."""

from __future__ import annotations

import os
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from canwire.errors import BadValue
from canwire.hub.handles.channel import HubChannel
from canwire.hub.wanted_mode import WantedMode
from canwire.logs.recording.files import RecordingFiles
from canwire.logs.recording.lab import LabSource
from canwire.logs.recording.recorder import Recorder, RecordingSource
from canwire.logs.recording.shared import SharedSource, shared_source
from canwire.values.checks import finite, whole

if TYPE_CHECKING:
    from canwire.lab import LabBus, LabNode

_SMALLEST = 10_000  # bytes of a file that rotates: below, files would be made faster than they fill
_QUEUE = 1 << 16  # of the node that listens for a recording


def record(
    line: str | HubChannel | LabNode | LabBus,
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
) -> Recorder:
    """Write everything that a line hears to a log file, until the recorder is closed.

    `line` is the name of a shared one ("can0", "HW000001:0"), which is started at `bit_rate` if nobody did; a
    HubChannel that is set up and active, which then belongs to the recorder, and whose times become dates by
    `epoch_ns`; a LabNode, or a LabBus, on which a listening node is put. `format` is told by the path's suffix unless
    given. `channel` is the
    name in the log. With `rotate_bytes` or `rotate_s` (seconds) the files are NAME-0001, NAME-0002, ...: a new one as
    soon as one is larger or older; a trace (`path` with a slash at its end) is one folder, which begins its next file
    then, by bytes of records. `hub` is the hub's address.

    Frames, error frames, changes of state and losses are recorded; a line's own frames as well, a LabNode's where it
    has `self_reception`. Raises BadValue, NoSuchBoard, HubError, ExtraMissing, OSError.

    >>> with Lab() as lab:  # doctest: +SKIP
    ...     with record(lab.can_bus("can0", bit_rate=500_000), "drive.blf") as recorder:
    ...         lab.run_for(10)
    """
    name = os.fspath(path)
    if rotate_bytes is not None:
        whole("rotate_bytes", rotate_bytes, _SMALLEST, 1 << 62)
    if rotate_s is not None:
        finite("rotate_s", rotate_s, 0.5, 1e9)
    with ExitStack() as closing:
        source = _source(line, channel, hub, WantedMode(bit_rate, data_bit_rate), epoch_ns)
        closing.callback(source.close)
        dated = isinstance(source, SharedSource) and source.epoch_ns > 0
        clock = "hub" if isinstance(source, SharedSource) else "lab"
        files = RecordingFiles(
            name,
            format,
            rotate_bytes=rotate_bytes,
            rotate_s=rotate_s,
            dated=dated,
            start_ns=None,
            clock=clock,
        )
        return Recorder(source, files, closing.pop_all())


def _source(
    line: Any, channel: str | None, hub: str | None, wanted: WantedMode, epoch_ns: int
) -> RecordingSource:
    if isinstance(line, str):
        return shared_source(line, hub, wanted, channel)
    if isinstance(line, HubChannel):
        return SharedSource(line, channel or "can0", epoch_ns, None, ExitStack())
    if hasattr(line, "receive_array"):
        return LabSource(line, channel or line.bus.name, own=False)
    if hasattr(line, "can_bus") or not hasattr(line, "node"):
        raise BadValue(f"{line!r}: no line that can be recorded: a name, a HubChannel, a LabNode or a LabBus")
    node = line.node("recorder", listen_only=True, receive_queue=_QUEUE, transmit_queue=1)
    return LabSource(node, channel or line.name, own=True)
