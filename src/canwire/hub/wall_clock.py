"""The hub's time on the computer's clock, the same for all programs that log the traffic of one hub."""

from __future__ import annotations

import time
from contextlib import suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from canwire.hub.handles.hub import Hub

_NOTE = "wall clock of hub time 0"
_TRIES = 5
_AGREEMENT_NS = 1_000_000  # a clock that was set or has drifted further apart than that is compared once more


def epoch_ns(hub: Hub) -> int:
    """Add this to the hub's time to get nanoseconds since 1970; 0 if the hub's time does not follow the clock.

    The first program stores it at the hub with its possible error, so that two logs of one bus have the same time for
    the same frame: what the next one finds on a busy machine differs by what both may be wrong.
    """
    if hub.time != "real":
        return 0
    found_ns, error_ns = min((_compared(hub) for _ in range(_TRIES)), key=lambda pair: pair[1])
    with suppress(ValueError):  # no note yet
        kept_ns, kept_error_ns = map(int, hub.note(_NOTE).split())
        if abs(kept_ns - found_ns) <= kept_error_ns + error_ns + _AGREEMENT_NS:
            return kept_ns
    hub.set_note(_NOTE, b"%d %d" % (found_ns, error_ns))
    return found_ns


def _compared(hub: Hub) -> tuple[int, int]:
    before_ns = time.time_ns()
    hub_ns = hub.now_ns()
    after_ns = time.time_ns()
    return (before_ns + after_ns) // 2 - hub_ns, (after_ns - before_ns + 1) // 2
