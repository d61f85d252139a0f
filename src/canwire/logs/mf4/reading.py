"""Reads MF4."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from canwire.errors import BadLog
from canwire.logs.batch import LogBatch, log_dtype
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.mf4.apart import FORKS, read_apart
from canwire.logs.source import Source
from canwire.values.dlc import FD_LENGTHS
from canwire.values.error_frame import decode_error_frame
from canwire.values.event import BusEvent, ErrorKind, EventKind
from canwire.values.lin.frame import LinFrame
from canwire.values.record import (
    DLC_SHIFT,
    EXTENDED,
    EXTENDED_DATA_LENGTH,
    REMOTE,
    load_numpy,
)

if TYPE_CHECKING:
    import numpy

from canwire.logs.mf4.layout import DATA, ERROR, FLAGS, LIN, REMOTE_FRAME, load_asammdf

_AT_ONCE = 50_000


def recognises(head: bytes) -> bool:
    """Recognises the format by its magic words: MDF, version 4."""
    return head.startswith((b"MDF     4", b"UnFinMF 4"))


def read(source: Source) -> Iterator[LogBatch]:
    """Yield the entries of all groups in the order of time. Raises BadLog for a file without bus logging."""
    asammdf = load_asammdf()
    if source.path == "-":
        raise BadLog("mf4: cannot be read from standard input")
    records = read_apart(source, lambda source: _opened(source, asammdf))
    for at in range(0, len(records), _AT_ONCE):
        yield LogBatch(records[at : at + _AT_ONCE], source.channels)


def _opened(source: Source, asammdf: Any) -> numpy.ndarray:
    if FORKS:  # this is a separate process, and faults become errors
        logging.disable()
    try:
        with asammdf.MDF(source.path, process_bus_logging=False) as mdf:
            return _read(source, mdf)
    except (BadLog, MemoryError):
        raise
    except Exception as error:  # somebody else's parser: anything may come
        raise BadLog(f"{source.path}: asammdf cannot read it: {type(error).__name__}: {error}") from None


def _read(source: Source, mdf: Any) -> numpy.ndarray:
    numpy = load_numpy()
    begin_ns = int(mdf.header.abs_time) if mdf.header.abs_time else 0
    source.dated, source.start_ns = begin_ns > 0, begin_ns or None
    parts, seen = [], False
    for number, group in enumerate(mdf.groups):
        for channel in group.channels:
            if channel.name in _READERS:
                seen = True
                signal = mdf.get(channel.name, group=number)
                if len(signal.samples):
                    times_ns = numpy.rint(signal.timestamps * 1e9).astype("i8") + begin_ns
                    parts.append(_READERS[channel.name](source, channel.name, signal.samples, times_ns))
    if not seen:
        raise BadLog(f"{source.path}: an MDF file without bus logging")
    if not parts:
        return numpy.zeros(0, log_dtype())
    records = numpy.concatenate(parts)
    return records[numpy.argsort(records["time_ns"], kind="stable")]


def _column(samples: Any, name: str, column: str, usual: int = 0) -> Any:
    """Return a column as numbers, default values if it is missing; texts such as "Tx" become 1."""
    numpy = load_numpy()
    full = f"{name}.{column}"
    if full not in samples.dtype.names:
        return numpy.full(len(samples), usual)
    values = samples[full]
    return (values == b"Tx").astype("u1") if values.dtype.kind == "S" else values


def _identifiers(samples: Any, name: str) -> Any:
    """Return the 29 bits of each identifier; some loggers (CANedge) have a 16-bit column if all identifiers have 11
    bits."""
    return _column(samples, name, "ID").astype("u4") & 0x1FFF_FFFF


def _can_records(source: Source, name: str, samples: Any, times_ns: Any) -> numpy.ndarray:
    numpy = load_numpy()
    found = _begun(source, name, samples, times_ns, "can")
    found["kind"] = LogKind.CAN_FRAME
    found["id"] = _identifiers(samples, name)
    info = numpy.where(_column(samples, name, "IDE"), EXTENDED, 0).astype("u4")
    fd = _column(samples, name, "EDL") != 0
    info |= numpy.where(fd, EXTENDED_DATA_LENGTH, 0).astype("u4")
    for flag in ("BRS", "ESI"):
        info |= numpy.where(fd & (_column(samples, name, flag) != 0), FLAGS[flag], 0).astype("u4")
    code = _column(samples, name, "DLC").astype("u4") & 15
    if name == REMOTE_FRAME:
        found["info"] = info | REMOTE | code << DLC_SHIFT
        return _fit(source, found)
    length = _column(samples, name, "DataLength")
    table = numpy.searchsorted(FD_LENGTHS, numpy.arange(65)).astype("u4")
    code = numpy.where(~fd & (code > 8) & (length == 8), code, table[numpy.minimum(length, 64)])
    found["info"] = info | code << DLC_SHIFT
    data = samples[f"{name}.DataBytes"]
    width = min(data.shape[1] if data.ndim > 1 else 0, 64)
    keep = numpy.arange(width) < length[:, None]
    found["data"][:, :width] = numpy.where(keep, data[:, :width], 0)
    return _fit(source, found)


def _fit(source: Source, found: numpy.ndarray) -> numpy.ndarray:
    """Return the records without invalid frames, which are faults of the source."""
    wrong = (found["info"] & EXTENDED == 0) & (found["id"] > 0x7FF)
    if count := int(wrong.sum()):
        source.fault("frames", f"{count} identifiers of more than 11 bits in standard frames")
    return found[~wrong]


def _error_records(source: Source, name: str, samples: Any, times_ns: Any) -> numpy.ndarray:
    entries = []
    begun = _begun(source, name, samples, times_ns, "can")
    ids = _identifiers(samples, name)
    for number, time_ns in enumerate(times_ns.tolist()):
        classes = int(ids[number])
        has_data = f"{name}.DataBytes" in samples.dtype.names
        data = bytes(samples[f"{name}.DataBytes"][number].tolist())[:8] if has_data else b""
        if classes or any(data):
            event = decode_error_frame(classes | 0x2000_0000, data, time_ns)
        else:
            event = BusEvent(EventKind.ERROR, time_ns, error=ErrorKind.OTHER)
        entries.append(LogEntry(time_ns, source.channels[begun["channel"][number]], event))
    return source.batch(entries).records


def _lin_records(source: Source, name: str, samples: Any, times_ns: Any) -> numpy.ndarray:
    entries = []
    begun = _begun(source, name, samples, times_ns, "lin")
    only = _column(samples, name, "HeaderOnly")
    ids, models = _column(samples, name, "ID"), _column(samples, name, "ChecksumModel", 1)
    lengths, asked = _column(samples, name, "DataLength"), _column(samples, name, "DLC")
    for number, time_ns in enumerate(times_ns.tolist()):
        header, sent = bool(only[number]), begun["direction"][number] == 2
        data = b"" if header else bytes(samples[f"{name}.DataBytes"][number].tolist())[: int(lengths[number])]
        id = int(ids[number]) & 0x3F
        length = int(asked[number]) if header else None
        frame = LinFrame(id, data, enhanced=bool(models[number]), header_only=header, length=length,
                         timestamp_ns=time_ns, sent=bool(sent))  # fmt: skip
        channel = source.channels[begun["channel"][number]]
        entries.append(LogEntry(time_ns, channel, frame, "T" if sent else "R"))
    return source.batch(entries).records


def _begun(source: Source, name: str, samples: Any, times_ns: Any, kind: str) -> numpy.ndarray:
    """Return records with time, channel and direction."""
    numpy = load_numpy()
    found = numpy.zeros(len(samples), log_dtype())
    found["time_ns"] = times_ns
    numbers = _column(samples, name, "BusChannel", 1).astype("u2")
    for number in numpy.unique(numbers).tolist():
        found["channel"][numbers == number] = source.channel(f"{kind}{max(number - 1, 0)}")
    found["direction"] = 1 + (_column(samples, name, "Dir") != 0)
    return found


_READERS = {DATA: _can_records, REMOTE_FRAME: _can_records, ERROR: _error_records, LIN: _lin_records}
