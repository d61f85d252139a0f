"""What the walk hands in: nothing, wrong types, extremes, things that were never initialised, and what calls back."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from typing import Any

import numpy as np


class CallsBack:
    """Whatever it is taken for, it does what it was made with first: it uses the very thing that is being called."""

    def __init__(self, does: Callable[[], object]) -> None:
        self._does = does
        self._within = False

    def _now(self) -> None:
        if not self._within:  # one level: a recursion without an end is Python's own matter
            self._within = True
            try:
                with contextlib.suppress(Exception):
                    self._does()
            finally:
                self._within = False

    def __call__(self, *_: object) -> int:
        self._now()
        return 1

    def __index__(self) -> int:
        self._now()
        return 1

    def __float__(self) -> float:
        self._now()
        return 1.0

    def __len__(self) -> int:
        self._now()
        return 1

    def __bool__(self) -> bool:
        self._now()
        return True

    def __getitem__(self, index: object) -> int:
        self._now()
        if index != 0:
            raise IndexError(index)
        return 1

    def __eq__(self, other: object) -> bool:
        self._now()
        return True

    def __hash__(self) -> int:
        self._now()
        return 1

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        self._now()
        return self


def plain() -> list[Any]:
    """Wrong types and extreme numbers, made anew."""
    return [
        None, 0, 1, -1, 7, 2**31, 2**63 - 1, -(2**63), 2**64 - 1, 2**70, 1.5, float("nan"), 1e300, True,
        "", "x", "\udcff", b"", b"\xff" * 80, bytearray(b"\xfe" * 80), memoryview(b"\xfd" * 160)[::2],
        [], [None], [1, 2], (), (None, None), {}, object(), int, len, np.zeros(3), np.zeros((2, 80), np.uint8),
    ]  # fmt: skip
