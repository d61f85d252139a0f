"""A bench whose buses a hub's boards may be plugged into."""

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
    """Its time and what holds that, its buses by name, and what goes wrong on each.

    A bus has one script of faults, whichever program adds to it.
    """

    timeline: Timeline
    held: HeldTime
    buses: Mapping[str, CanBus | LinBus]
    faults: Mapping[str, Faults | LinFaults]
