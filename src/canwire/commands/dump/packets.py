"""Packets for Wireshark: what `canwire dump --pcapng` writes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence

from canwire import (
    SELF_RECEPTION,
    TYPE_MASK,
    BusEvent,
    LogBatch,
    LogEntry,
    LogKind,
    LogMark,
    LogWriter,
    MarkKind,
    create_log,
    frame_of_record,
    log_dtype,
    record_dtype,
)
from canwire.commands.dump.filters import Capture
from canwire.commands.live.listening import RECORD, Record


class Packets:
    """pcapng in a file, or on stdout for a Wireshark that reads from a pipe; times are of the wall clock."""

    def __init__(self, path: str, capture: Capture, names: Sequence[str], epoch_ns: int) -> None:
        self.shown: defaultdict[str, int] = defaultdict(int)
        self._capture = capture
        self._names = list(names)
        self._epoch_ns = epoch_ns
        self._latest_ns = epoch_ns
        self._writer: LogWriter = create_log(path, format="pcapng", clock="hub")
        self._writer.flush()  # its reader knows now that something will come

    def put(self, name: str, records: Sequence[Record], most: int | None) -> int:
        import numpy

        blocks = [RECORD.pack(*record) for record in records]
        capture = self._capture.of(name)
        kept = [block for block in blocks if _accepts(capture, block)][:most]
        if not kept:
            return 0
        raw = numpy.frombuffer(b"".join(kept), record_dtype())
        found = numpy.zeros(len(kept), log_dtype())
        for column in ("id", "info", "data"):
            found[column] = raw[column]
        found["time_ns"] = raw["time_ns"] + numpy.uint64(self._epoch_ns)
        found["channel"] = self._names.index(name)
        found["kind"] = numpy.where(raw["info"] & TYPE_MASK, int(LogKind.CAN_EVENT), int(LogKind.CAN_FRAME))
        found["direction"] = 1 + (raw["info"] & SELF_RECEPTION != 0)
        self._latest_ns = int(found["time_ns"][-1])
        batch = LogBatch(found, self._names)
        self.shown[name] += len(kept)
        self._writer.write_batch(batch)
        return len(kept)

    def flush(self) -> None:
        self._writer.flush()

    def end(self, lost: Callable[[], Mapping[str, int]]) -> None:
        marks = [
            LogEntry(self._latest_ns, name, LogMark(MarkKind.LOST, self._latest_ns, count=count))
            for name, count in lost().items()
            if count
        ]
        if marks:
            self._writer.write_many(marks)
        self._writer.close()


def _accepts(capture: Capture, block: bytes) -> bool:
    if not (capture.filters or capture.kinds or capture.events):
        return True  # the channel brings frames only
    event = int.from_bytes(block[12:16], "little") & TYPE_MASK
    return capture.accepts(BusEvent.from_record(block) if event else frame_of_record(block))
