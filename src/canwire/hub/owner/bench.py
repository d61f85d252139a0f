"""A bench whose buses a hub's boards may be plugged into."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults import Faults
from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.faults import LinFaults
from canwire.timeline import Timeline


class Bench(NamedTuple):
    """Its time, its buses by name, and what goes wrong on each: a bus has one script of faults, whoever adds to it."""

    timeline: Timeline
    buses: Mapping[str, CanBus | LinBus]
    faults: Mapping[str, Faults | LinFaults]
