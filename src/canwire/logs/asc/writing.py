"""Writes ASC: times count from the beginning of the log, whose date is in the header."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from canwire.logs.batch import LOG_RECORD_SIZE, entry_of
from canwire.logs.dates import vector_date
from canwire.logs.detail import detail_of
from canwire.logs.entry import LogEntry, LogKind
from canwire.logs.form import FormWriter
from canwire.values.event import BusEvent, EventKind
from canwire.values.frame import Frame
from canwire.values.lin.frame import LinFrame

if TYPE_CHECKING:
    import numpy

OURS = "// canwire"
_DIRECTIONS = {"R": "Rx", "T": "Tx", None: "Rx"}
_MS = 1_000_000
_KINDS = {"BusEvent": "CAN_EVENT", "LinEvent": "LIN_EVENT", "LogMark": "MARK"}


class Writer(FormWriter):
    """Channels are written as numbers; their names, marks and events are comments that begin with `// canwire`."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)

    def begin(self) -> None:
        self._zero_ns: int | None = None
        self._named = 0

    def put(self, records: numpy.ndarray) -> None:
        if self._zero_ns is None:
            self._head(int(records["time_ns"][0]))
        for number in range(self._named, len(self.channels)):
            self.out(f"{OURS} channel {number + 1} {self.channels[number]}\n".encode())
        self._named = len(self.channels)
        stored, size = records.tobytes(), LOG_RECORD_SIZE
        numbers = {name: number + 1 for number, name in enumerate(self.channels)}
        unknown = int(((records["direction"] == 0) & (records["kind"] == LogKind.CAN_FRAME)).sum())
        if unknown:
            self.leave_out("directions that are not known (Rx is written)", unknown)
        lines = [
            self._line(entry_of(stored[at : at + size], self.channels), numbers)
            for at in range(0, len(stored), size)
        ]
        self.out("".join(lines).encode(), len(lines))

    def end(self) -> None:
        if self._zero_ns is None:
            self._head(self.start_ns or 0)
        self.out(b"End TriggerBlock\n")
        self.sync()

    def _head(self, first_ns: int) -> None:
        begin_ns = first_ns if self.start_ns is None or not self.dated else min(first_ns, self.start_ns)
        self._zero_ns = begin_ns // _MS * _MS if self.dated else 0  # the head's date has milliseconds
        date = vector_date(self._zero_ns)
        exact = f"{OURS} start {self._zero_ns if self.dated else 'unknown'} {self.clock}".rstrip()
        self.out(
            f"date {date}\nbase hex  timestamps absolute\ninternal events logged\n{exact}\n"
            f"Begin TriggerBlock {date}\n   0.000000 Start of measurement\n".encode()
        )

    def _line(self, entry: LogEntry, numbers: dict[str, int]) -> str:
        content, channel = entry.content, numbers[entry.channel]
        assert self._zero_ns is not None
        stamp = _stamp(entry.timestamp_ns - self._zero_ns)
        if isinstance(content, Frame):
            return f"{stamp} {_frame(content, channel, _DIRECTIONS[entry.direction])}\n"
        if isinstance(content, LinFrame):
            return f"{stamp} {_lin(content, channel, _DIRECTIONS[entry.direction])}\n"
        told = f"{_KINDS[type(content).__name__]} {detail_of(content)}"
        if isinstance(content, BusEvent) and content.kind is EventKind.ERROR:
            return f"{stamp} {channel}  ErrorFrame  {OURS} {told}\n"
        return f"{OURS} {stamp.strip()} {channel} {told}\n"


def _stamp(time_ns: int) -> str:
    sign, time_ns = ("-", -time_ns) if time_ns < 0 else ("", time_ns)
    seconds, rest = divmod(time_ns, 10**9)
    decimals = f"{rest:09d}" if rest % 1000 else f"{rest // 1000:06d}"
    return f"{sign}{seconds}.{decimals}".rjust(11)


def _frame(frame: Frame, channel: int, direction: str) -> str:
    id = f"{frame.id:X}x" if frame.extended else f"{frame.id:X}"
    data = frame.data.hex(" ").upper()
    if frame.fd:
        flags = 1 << 12 | frame.bit_rate_switch << 13 | frame.error_state_indicator << 14
        return (
            f"CANFD {channel:3d} {direction:<4} {id:>8} {'':>33} {int(frame.bit_rate_switch)} "
            f"{int(frame.error_state_indicator)} {frame.dlc:x} {len(frame.data):2d} {data} {0:8d} {0:4d} {flags:8X} "
            f"{0:8d} {0:8d} {0:8d} {0:8d} {0:8d}"
        )
    kind = f"r {frame.dlc:x}" if frame.remote else f"d {frame.dlc:x} {data}"
    return f"{channel}  {id:<15} {direction:<4} {kind}".rstrip()


def _lin(frame: LinFrame, channel: int, direction: str) -> str:
    if frame.header_only:
        return f"Li{channel} {frame.id:X} {OURS} {detail_of(frame)}"
    model = "enhanced" if frame.enhanced else "classic"
    data = frame.data.hex(" ").upper()
    return f"Li{channel} {frame.id:X} {direction} {len(frame.data)} {data} checksum = {frame.checksum:x} CSM = {model}"
