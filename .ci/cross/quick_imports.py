"""Windows' Python imports this as it starts, as `sitecustomize`: under Wine it finds modules quickly then.

There `os.stat` asks a second process for the serial number of the volume, by way of a third: 1.5 ms of a processor, and
`import` does that a thousand times for a verb. For all that was installed before the start the names, sizes and times
come from the lists of their folders, and a file is read without such a question. The archive of the standard library is
read once, not once for each of its modules, which takes another quarter off a verb.
"""

from __future__ import annotations

import _io
import nt  # type: ignore[import-not-found]  # Windows' alone
import sys
import zipimport
from importlib import _bootstrap_external as finder  # type: ignore[attr-defined]

HOMES = tuple(path + "\\" for path in sys.path if path)
listed: dict[str, dict[str, nt.DirEntry]] = {}
asked_stat, asked_data = finder._path_stat, finder.FileLoader.get_data


def of_list(path: str) -> nt.stat_result:
    if not path.startswith(HOMES):
        return asked_stat(path)
    folder, _, name = path.rstrip("\\").rpartition("\\")
    if folder not in listed:
        try:
            with nt.scandir(folder) as entries:
                listed[folder] = {entry.name: entry for entry in entries}
        except OSError:
            listed[folder] = {}
    if name not in listed[folder]:
        raise FileNotFoundError(path)
    return listed[folder][name].stat()


def content(loader: object, path: str) -> bytes:
    if not path.startswith(HOMES):
        return asked_data(loader, path)
    file = nt.open(path, nt.O_RDONLY | nt.O_BINARY)
    try:
        return nt.read(file, of_list(path).st_size)
    finally:
        nt.close(file)


class Archives:
    """What `zipimport` opens its archives by."""

    def __init__(self) -> None:
        self.kept: dict[str, bytes] = {}

    def open_code(self, path: str) -> _io.BytesIO:
        if path not in self.kept:
            with _io.open_code(path) as file:
                self.kept[path] = file.read()
        return _io.BytesIO(self.kept[path])


finder._path_stat, finder.FileLoader.get_data = of_list, content
zipimport._io = Archives()  # type: ignore[attr-defined]
