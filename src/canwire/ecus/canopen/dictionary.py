"""EDS and DCF files by canopen, with limits: any fault of a file raises the same error.

Source: CiA 306 1.3.0, 4.5 and 4.6 (sections, NrOfEntries, CompactSubObj).
"""

from __future__ import annotations

import io
import re
from os import PathLike
from pathlib import Path

from canopen import ObjectDictionary
from canopen.objectdictionary.eds import import_eds

from canwire import BadDescription
from canwire.platform.foreign_reader import foreign_reader

MOST_BYTES = 1 << 24
MOST_SECONDS = 60.0
_KINDS = (".eds", ".dcf")
_MOST_SUBINDICES = 254
_COUNTS = re.compile(
    r"^[ \t]*(?:NrOfEntries|CompactSubObj)[ \t]*[=:][ \t]*(\S+)", re.IGNORECASE | re.MULTILINE
)


def load_eds(
    path: str | PathLike[str],
    *,
    node_id: int | None = None,
    most_bytes: int = MOST_BYTES,
    seconds: float = MOST_SECONDS,
) -> ObjectDictionary:
    """Load an EDS or DCF file as canopen's dictionary; `node_id` is for entries that contain it ($NODEID+0x180).

    Raises BadDescription with the file's name: for a file of more than `most_bytes`, one that needs more than `seconds`
    to read, an object with more than 254 entries, and a file that is not EDS or DCF.
    """
    file = Path(path)
    if file.suffix.lower() not in _KINDS:
        raise BadDescription(f"{file}: no object dictionary by its ending; there are {', '.join(_KINDS)}")
    with foreign_reader(file, most_bytes, seconds, "no object dictionary"):
        text = _text_of(file.read_bytes())
        _check_counts(file, text)
        return import_eds(io.StringIO(text), node_id)


def dictionary_of(path: str | PathLike[str], node_id: int) -> ObjectDictionary | str:
    """`load_eds` for an EDS or DCF file; other paths are passed to canopen."""
    return load_eds(path, node_id=node_id) if Path(path).suffix.lower() in _KINDS else str(path)


def _text_of(data: bytes) -> str:
    """Decode a file. The standard requires ISO 646; other characters are read as UTF-8, or else as Latin-1."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def _check_counts(file: Path, text: str) -> None:
    """Raise BadDescription for large counts: canopen creates as many entries as a file claims."""
    for found in _COUNTS.finditer(text):
        try:
            count = int(found[1], 0)
        except ValueError:  # canopen says what is wrong with it
            continue
        if count > _MOST_SUBINDICES:
            raise BadDescription(
                f"{file}: {found[0].strip()}: an object has at most {_MOST_SUBINDICES} entries"
            )
