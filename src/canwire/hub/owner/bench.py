"""A bench with buses into which the boards of a hub may be plugged."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.faults import LinFaults
from canwire.held_time import HeldTime
from canwire.timeline import Timeline


class Bench(NamedTuple):
    """The bench's time and its pacing, its buses by name, and the faults of each.

    A bus has one script of faults, to which all programs add.
    """

    timeline: Timeline
    held: HeldTime
    buses: Mapping[str, CanBus | LinBus]
    faults: Mapping[str, Faults | LinFaults]
