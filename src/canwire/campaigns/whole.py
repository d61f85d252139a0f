"""Files that are there whole or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """The name to write to: what is written there takes the place of `path`, unless writing fails."""
    part = path.with_name(path.name + ".part")
    yield part
    part.replace(path)
