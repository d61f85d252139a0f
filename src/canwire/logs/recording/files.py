"""The files of a recording: one, or several by size and time; each can be read while it grows.

A format that can be read only after its end is accompanied by a journal, which is removed when the file is complete. If
the recording is killed, the journal remains, and `open_log` reads it.
"""

from __future__ import annotations

import os
import time
from collections import Counter
from pathlib import Path

from canwire.errors import BadValue
from canwire.logs.batch import LogBatch
from canwire.logs.formats import format_to_write, load_format
from canwire.logs.journal import SUFFIX
from canwire.logs.log import open_log
from canwire.logs.packing import packing_of, unpacked_name
from canwire.logs.writer import LogWriter, create_log

_LOOK_AT_S = 0.25  # how often a file's size is asked for, and what is written flushed


class RecordingFiles:
    """Writes the batches of a recording. For one thread at a time only."""

    def __init__(
        self,
        path: str,
        format: str | None,
        *,
        rotate_bytes: int | None,
        rotate_s: float | None,
        dated: bool,
        start_ns: int | None,
        clock: str,
    ) -> None:
        row = format_to_write(path, format)
        if (rotate_bytes or rotate_s) and path == "-":
            raise BadValue("rotation needs files; - is standard output")
        self._format = row.name
        self._needs_end = bool(load_format(row).Writer.needs_end)
        self._path = path
        self._rotate_bytes = rotate_bytes
        self._rotate_s = rotate_s
        self._about = {"dated": dated, "start_ns": start_ns, "clock": clock}
        self._left_out: Counter[str] = Counter()
        self._began_s = 0.0
        self._flushed_s = 0.0
        self.files: list[str] = []
        self.count = 0
        self._writer: LogWriter | None = None
        self._open()

    @property
    def left_out(self) -> dict[str, int]:
        """Data that the format cannot hold, with counts for all files so far."""
        found = Counter(self._left_out)
        if self._writer is not None and not self._needs_end:
            found.update(self._writer.left_out)
        return dict(found)

    def write(self, batch: LogBatch) -> None:
        """Append a batch; raises OSError for a full disk."""
        if self._writer is None:
            self._open()
        assert self._writer is not None
        self._writer.write_batch(batch)
        self.count += len(batch)

    def tend(self) -> None:
        """Flush and rotate when it is time; call it several times a second, also without new entries."""
        now_s = time.monotonic()
        if self._writer is None or now_s - self._flushed_s < _LOOK_AT_S:
            return
        self._flushed_s = now_s
        self._writer.flush()
        too_old = self._rotate_s is not None and now_s - self._began_s >= self._rotate_s
        if too_old or (self._rotate_bytes is not None and self._writer.size >= self._rotate_bytes):
            self._began_s = now_s
            if not self._writer.rotate():
                self._end_file()

    def close(self) -> None:
        """Finish the last file."""
        self._end_file()

    def _open(self) -> None:
        name = self._next_name()
        written = name + SUFFIX if self._needs_end else name
        form = "journal" if self._needs_end else self._format
        if self._needs_end:
            create_log(name, format=self._format).close()  # says now what would be wrong with it
        self._writer = create_log(written, format=form, **self._about)  # type: ignore[arg-type]
        if self._needs_end:
            os.remove(name)  # `open_log` finds the journal then
        self.files.append(name)
        self._began_s = self._flushed_s = time.monotonic()

    def _next_name(self) -> str:
        if not (self._rotate_bytes or self._rotate_s) or self._format == "trace":
            return self._path
        path = Path(self._path)
        packed = packing_of(path.name)
        plain = Path(unpacked_name(path.name))
        return str(path.with_name(f"{plain.stem}-{len(self.files) + 1:04d}{plain.suffix}{packed}"))

    def _end_file(self) -> None:
        writer, self._writer = self._writer, None
        if writer is None:
            return
        writer.close()
        if self._needs_end:
            self._finish(self.files[-1])
        else:
            self._left_out.update(writer.left_out)

    def _finish(self, name: str) -> None:
        """Convert the journal to the file. If that fails, the journal remains, and no incomplete file."""
        journal = name + SUFFIX
        try:
            with open_log(journal, format="journal") as log:
                with create_log(name, format=self._format, whole=True, **self._about) as out:  # type: ignore[arg-type]
                    for batch in log.batches():
                        out.write_batch(batch)
                self._left_out.update(out.left_out)
        except BaseException as error:
            error.add_note(
                f"{name} is not written; all of it is in {journal}: canwire convert {journal} {name}"
            )
            raise
        os.remove(journal)
