"""Every test purpose of ISO 16845-1 that is known in public, and to which controllers it applies.

188 purposes have the standard's own numbers; the 6 with a letter (7.2.2.a to 7.2.4.b) are variants that a public list
added. What is open, and what does not apply to which controller, has its reason here.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import pytest

from tests.iso16845.rows import (
    both,
    receiver_counters,
    receiver_error_frames,
    receiver_errors,
    receiver_fd_timing,
    receiver_frames,
    receiver_timing,
    transmitter_counters,
    transmitter_error_frames,
    transmitter_frames,
    transmitter_timing,
)
from tests.iso16845.rows.terms import Kind, Purpose

PURPOSES: tuple[Purpose, ...] = (
    *receiver_frames.ROWS,
    *receiver_errors.ROWS,
    *receiver_error_frames.ROWS,
    *receiver_counters.ROWS,
    *receiver_timing.ROWS,
    *receiver_fd_timing.ROWS,
    *transmitter_frames.ROWS,
    *transmitter_error_frames.ROWS,
    *transmitter_counters.ROWS,
    *transmitter_timing.ROWS,
    *both.ROWS,
)
BY_NUMBER = {purpose.number: purpose for purpose in PURPOSES}
VARIANTS = ("7.2.2.a", "7.2.2.b", "7.2.3.a", "7.2.3.b", "7.2.4.a", "7.2.4.b")

KINDS = {
    "fd": "ideal CAN FD controller",
    "tolerant": "ideal classic controller, FD tolerant",
    "sja1000": "SJA1000",
    "mcp2515": "MCP2515",
}
WHAT: dict[str, Kind] = {
    "fd": "FD enabled",
    "tolerant": "FD tolerant",
    "sja1000": "classic",
    "mcp2515": "classic",
}
NO_FD = "knows no CAN FD"

# purposes for something that ideal controllers alone have
IDEAL_ONLY = {"7.2.2.b": "restricted operation", "7.2.3.b": "restricted operation"}

# (purpose, controller) whose test fails still, and why: it must go on failing until the row is taken out
OPEN: dict[tuple[str, str], str] = {}


def why_not(number: str, kind: str) -> str:
    """Why a purpose does not apply to a controller; empty if it does."""
    if number in IDEAL_ONLY and WHAT[kind] == "classic":
        return f"has no {IDEAL_ONLY[number]}"
    applies = BY_NUMBER[number].applies
    if WHAT[kind] not in applies:
        return NO_FD if "classic" not in applies else "leaves such a frame alone (7.1.6)"
    return ""


Test = TypeVar("Test", bound=Callable[..., None])


def shows(number: str) -> Callable[[Test], Test]:
    """Mark a test with the purpose it shows, and run it with every controller to which that applies."""
    kinds = [kind for kind in KINDS if not why_not(number, kind)]

    def mark(test: Test) -> Test:
        cases = [pytest.param(kind, id=f"{number}-{kind}", marks=_marks(number, kind)) for kind in kinds]
        return pytest.mark.parametrize("kind", cases)(test)

    return mark


def _marks(number: str, kind: str) -> list[pytest.MarkDecorator]:
    if (number, kind) not in OPEN:
        return []
    return [pytest.mark.xfail(strict=True, reason=OPEN[number, kind])]
