"""What the sources of the core say to Cython beside their .pxd, where Cython is not installed: nothing."""

from __future__ import annotations

from collections.abc import Callable


def cclass(kind: type) -> type:
    return kind


def freelist(count: int) -> Callable[[type], type]:
    """`count` objects that are no longer used are kept, because the next ones are then quicker to make."""
    return cclass
