"""The journal of a recording in a format that cannot be read before its end: plain records.

The magic words are followed by a line of JSON with facts, then by blocks: one byte N or R, the length (4 bytes), and
the name of a channel or records of `log_dtype()`. Flushed entries can be read even if the process is killed: by the
name of the journal (`drive.mf4.journal`), or with `open_log("drive.mf4")` if that file does not exist.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

from canwire.errors import BadLog
from canwire.logs.batch import LOG_RECORD_SIZE, LogBatch, log_dtype
from canwire.logs.entry import LogKind
from canwire.logs.form import FormWriter
from canwire.logs.source import Source
from canwire.values.record import load_numpy

if TYPE_CHECKING:
    import numpy

SUFFIX = ".journal"
_MAGIC = b"canwire journal 1 "
_MOST = 1 << 28


class Writer(FormWriter):
    """Writes all kinds of records."""

    holds: ClassVar[frozenset[LogKind]] = frozenset(LogKind)

    def begin(self) -> None:
        self._named = 0
        about = {"dated": self.dated, "start_ns": self.start_ns, "clock": self.clock}
        self.out(_MAGIC + json.dumps(about).encode() + b"\n")

    def put(self, records: numpy.ndarray) -> None:
        for name in self.channels[self._named :]:
            told = name.encode()
            self.out(b"N" + len(told).to_bytes(4, "little") + told)
        self._named = len(self.channels)
        block = records.tobytes()
        self.out(b"R" + len(block).to_bytes(4, "little") + block, len(records))


def recognises(head: bytes) -> bool:
    """Recognised by the magic words."""
    return head.startswith(_MAGIC)


def read(source: Source) -> Iterator[LogBatch]:
    """Yields a batch for each block; the last block may be incomplete, and then its complete records are used."""
    numpy = load_numpy()
    line = source.file.readline(1 << 16)
    try:
        about = json.loads(line.removeprefix(_MAGIC))
        source.dated, source.start_ns, source.clock = about["dated"], about["start_ns"], about["clock"]
    except (ValueError, KeyError, TypeError):
        raise BadLog(f"{source.path}: no journal of canwire") from None
    at = len(line)
    while head := source.file.read(5):
        size = int.from_bytes(head[1:], "little")
        if len(head) < 5 or head[:1] not in b"NR" or size > _MOST:
            source.fault(f"byte {at}", "no block begins here: the journal is cut or damaged")
            return
        block = source.file.read(size)
        if len(block) < size:
            source.fault(f"byte {at}", f"a block of {size} bytes, of which {len(block)} are there")
        if head[:1] == b"N":
            source.channels.append(block.decode("utf-8", "replace"))
        elif whole := len(block) // LOG_RECORD_SIZE * LOG_RECORD_SIZE:
            yield LogBatch(numpy.frombuffer(bytearray(block[:whole]), log_dtype()), source.channels)
        at += 5 + size
