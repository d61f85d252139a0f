"""Writes MF4."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from canwire.errors import BadLog
from canwire.logs.batch import LOG_RECORD_SIZE, entry_of, log_dtype
from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.tables.columns import lengths_of
from canwire.values.error_frame import encode_error_frame
from canwire.values.event import BusEvent
from canwire.values.lin.frame import LinFrame
from canwire.values.record import (
    DLC_SHIFT,
    REMOTE,
    load_numpy,
)

if TYPE_CHECKING:
    import numpy

from canwire.logs.mf4.layout import DATA, ERROR, FLAGS, LIN, REMOTE_FRAME, load_asammdf


class Writer(FormWriter):
    """Channels are written as numbers from 1 on. All records are kept in memory until `end`."""

    holds: ClassVar[frozenset[LogKind]] = frozenset((LogKind.CAN_FRAME, LogKind.CAN_EVENT, LogKind.LIN_FRAME))
    opens: ClassVar[bool] = False
    needs_end: ClassVar[bool] = True

    def begin(self) -> None:
        load_asammdf()
        if self.path == "-":
            raise BadLog("mf4: cannot be written to standard output")
        open(self.path, "wb").close()  # raises now if it cannot be
        self._parts: list[Any] = []

    def put(self, records: numpy.ndarray) -> None:
        self._parts.append(records)

    def sync(self) -> None:
        """Do nothing: the file is written at its end."""

    def end(self) -> None:
        numpy = load_numpy()
        records = numpy.concatenate(self._parts) if self._parts else numpy.zeros(0, log_dtype())
        self._parts = []
        zero_ns = int(records["time_ns"].min()) if len(records) else self.start_ns or 0
        if self.dated and self.start_ns is not None:
            zero_ns = min(zero_ns, self.start_ns)
        self._tell(records)
        _write(self.path, records, self.channels, zero_ns if self.dated else 0)
        self.count = len(records)

    def _tell(self, records: numpy.ndarray) -> None:
        unknown = (records["direction"] == 0) & (records["kind"] == LogKind.CAN_FRAME)
        if count := int(unknown.sum()):
            self.leave_out("directions that are not known (0, received, is written)", count)
        if self.channels not in ([], ["can0"]):
            self.leave_out("names of channels (they have numbers)", len(self.channels))
        if count := int((records["kind"] == LogKind.CAN_EVENT).sum()):
            self.leave_out("details of error frames (what SocketCAN's error frames have no room for)", count)


def _write(path: str, records: numpy.ndarray, channels: list[str], zero_ns: int) -> None:
    asammdf = load_asammdf()
    from asammdf.blocks.v4_blocks import SourceInformation
    from asammdf.blocks.v4_constants import BUS_TYPE_CAN, BUS_TYPE_LIN, FLAG_CG_BUS_EVENT, SOURCE_BUS

    kinds, info = records["kind"], records["info"]
    frames = kinds == LogKind.CAN_FRAME
    remote = frames & (info & REMOTE != 0)
    groups = {
        DATA: _can_samples(DATA, records[frames & ~remote], 64),
        REMOTE_FRAME: _can_samples(REMOTE_FRAME, records[remote], 0),
        ERROR: _error_samples(records[kinds == LogKind.CAN_EVENT], channels),
        LIN: _lin_samples(records[kinds == LogKind.LIN_FRAME], channels),
    }
    with asammdf.MDF(version="4.10") as mdf:
        mdf.header.abs_time = zero_ns
        for name, (times_ns, samples) in groups.items():
            if not len(samples) and name != DATA:
                continue
            bus = BUS_TYPE_LIN if name == LIN else BUS_TYPE_CAN
            origin = SourceInformation(source_type=SOURCE_BUS, bus_type=bus)
            times = (times_ns.astype("i8") - zero_ns) / 1e9
            signal = asammdf.Signal(samples=samples, timestamps=times, name=name, source=origin)
            number = mdf.append(signal, common_timebase=True)
            mdf.groups[number].channel_group.acq_source = origin
            mdf.groups[number].channel_group.flags |= FLAG_CG_BUS_EVENT
        saved = mdf.save(Path(path), overwrite=True, compression=1)
    if str(saved) != path:  # asammdf insists on its suffix
        os.replace(saved, path)


def _columns(name: str, records: numpy.ndarray, names: list[str], size: int) -> Any:
    """Return samples with the channel's number, the direction, and further columns of one byte each."""
    numpy = load_numpy()
    fields: list[Any] = [(f"{name}.BusChannel", "u1"), (f"{name}.ID", "<u4"), (f"{name}.Dir", "u1")]
    fields += [(f"{name}.{column}", "u1") for column in names]
    if size:
        fields.append((f"{name}.DataBytes", "u1", (size,)))
    samples = numpy.zeros(len(records), fields)
    samples[f"{name}.BusChannel"] = records["channel"] + 1
    samples[f"{name}.ID"] = records["id"]
    samples[f"{name}.Dir"] = records["direction"] == 2
    return samples


def _can_samples(name: str, records: numpy.ndarray, size: int) -> tuple[Any, Any]:
    flags = list(FLAGS) if size else ["IDE"]
    samples = _columns(name, records, [*flags, "DLC", "DataLength"], size)
    for flag in flags:
        samples[f"{name}.{flag}"] = records["info"] & FLAGS[flag] != 0
    code = records["info"] >> DLC_SHIFT & 15
    samples[f"{name}.DLC"] = code
    if size:
        samples[f"{name}.DataLength"] = lengths_of(records)
        samples[f"{name}.DataBytes"] = records["data"]
    return records["time_ns"], samples


def _error_samples(records: numpy.ndarray, channels: list[str]) -> tuple[Any, Any]:
    """Return error frames in SocketCAN's form: error classes in the identifier, and eight bytes."""
    samples = _columns(ERROR, records, ["IDE", "EDL", "BRS", "ESI", "DLC", "DataLength"], 8)
    stored, size = records.tobytes(), LOG_RECORD_SIZE
    for number in range(len(records)):
        event = entry_of(stored[number * size : number * size + size], channels).content
        assert isinstance(event, BusEvent)
        id, data = encode_error_frame(event)
        samples[f"{ERROR}.ID"][number] = id & 0x1FFF_FFFF
        samples[f"{ERROR}.DataBytes"][number] = list(data)
    samples[f"{ERROR}.DLC"] = samples[f"{ERROR}.DataLength"] = 8
    return records["time_ns"], samples


def _lin_samples(records: numpy.ndarray, channels: list[str]) -> tuple[Any, Any]:
    samples = _columns(LIN, records, ["DLC", "DataLength", "ChecksumModel", "HeaderOnly"], 8)
    stored, size = records.tobytes(), LOG_RECORD_SIZE
    for number in range(len(records)):
        frame = entry_of(stored[number * size : number * size + size], channels).content
        assert isinstance(frame, LinFrame)
        samples[f"{LIN}.ID"][number] = frame.id
        samples[f"{LIN}.DLC"][number] = frame.length
        samples[f"{LIN}.DataLength"][number] = len(frame.data)
        samples[f"{LIN}.ChecksumModel"][number] = frame.enhanced
        samples[f"{LIN}.HeaderOnly"][number] = frame.header_only
        samples[f"{LIN}.DataBytes"][number] = list(frame.data.ljust(8, b"\0"))
    return records["time_ns"], samples
