"""Packs entries into a complete file in a thread, in the time of some thousand frames on a bus."""

from __future__ import annotations

import json
import os
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from canwire.logs import journal
from canwire.logs.tables.arrow import FOR_PANDAS, load_pyarrow, schema_of_log, table_of
from canwire.logs.tables.order import ROW, by_identifier, rows_among
from canwire.logs.tables.parquet_file import ABOUT, PACKING, ROW_GROUP

if TYPE_CHECKING:
    import numpy

_PACKING = {**PACKING, "use_dictionary": [*PACKING["use_dictionary"], ROW]}


class Packing:
    """Writes one file in a separate thread. Its journal, if it has one, is removed when the file is complete."""

    def __init__(
        self, path: str, records: numpy.ndarray, channels: list[str], about: dict[str, Any],
        growing: journal.Writer | None,
    ) -> None:  # fmt: skip
        self.records = records
        self.growing = growing
        self._path = path
        self._channels = list(channels)
        self._about = about
        pool = ThreadPoolExecutor(1, "canwire trace")
        self._future: Future[None] | None = pool.submit(self._write)
        pool.shutdown(wait=False)

    @property
    def done(self) -> bool:
        """True once `finish` would not block."""
        return self._future is None or self._future.done()

    def finish(self) -> None:
        """Wait until the file is complete. Raises OSError if it does not fit; the next call tries again."""
        future, self._future = self._future, None
        if future is None:
            self._write()
        else:
            future.result()
        if self.growing is not None:
            end_journal(self.growing)
            os.remove(self.growing.path)
            self.growing = None

    def _write(self) -> None:
        """Write the file, completely or not at all."""
        rows, order = rows_among(self.records)
        places = by_identifier(self.records)
        arrow = load_pyarrow()
        table = table_of(arrow, schema_of_log(arrow), self.records[places], self._channels)
        table = table.append_column(ROW, arrow.array(rows[places]))
        table = table.replace_schema_metadata(
            {ABOUT: json.dumps({**self._about, "order": order}).encode(), **FOR_PANDAS}
        )
        made = f"{self._path}.new"
        try:
            with open(made, "wb") as file:
                arrow.parquet.write_table(table, file, row_group_size=ROW_GROUP, **_PACKING)
            os.replace(made, self._path)
        except BaseException:
            with suppress(OSError):
                os.remove(made)
            raise


def end_journal(growing: journal.Writer) -> None:
    """Close the file of the journal; a second call does nothing."""
    if growing.file is not None:
        growing.file.close()
