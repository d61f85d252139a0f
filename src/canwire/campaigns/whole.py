"""Writes files completely or not at all."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """A temporary name to write to; that file replaces `path` at the end, unless writing fails."""
    part = path.with_name(path.name + ".part")
    yield part
    part.replace(path)
