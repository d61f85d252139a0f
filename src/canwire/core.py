"""Whether the core runs compiled or interpreted; both forms have the same sources."""

from __future__ import annotations

from canwire import holding, ring, timeline
from canwire.boards.can import channel, line, message_filter, sending
from canwire.bus import load
from canwire.bus.can import (
    bit_layout,
    bit_level,
    bus_state,
    clock,
    coasting,
    drifting,
    echo,
    frame_reader,
    joining,
    node,
    reader_state,
    station,
    stepped,
    stimulus,
    tally,
)
from canwire.bus.can import bits as can_bits
from canwire.bus.can import bus as can_bus
from canwire.bus.lin import bus as lin_bus
from canwire.bus.lin import node as lin_node
from canwire.chips import confinement, host
from canwire.chips.ideal import can_fd
from canwire.chips.lin import controller as lin_controller
from canwire.chips.sja1000 import controller as sja1000
from canwire.chips.sja1000 import fifo as sja1000_fifo
from canwire.chips.sja1000 import filter as sja1000_filter
from canwire.chips.sja1000 import interrupts as sja1000_interrupts
from canwire.chips.sja1000 import link as sja1000_link
from canwire.chips.sja1000 import modes as sja1000_modes
from canwire.drivers import can_fd as can_fd_driver
from canwire.drivers import driver
from canwire.hub.owner import loop, pace
from canwire.hub.owner.lockstep import keeper, program, shared_page, turns
from canwire.hub.owner.lockstep import pace as lockstep_pace
from canwire.hub.protocol import turn_page
from canwire.values import frame, packed_records, slcan_text

# fmt: off
MODULES = (
    frame, packed_records, slcan_text, timeline, ring, holding, node, can_bits, bit_layout, frame_reader, tally,
    station, stimulus, echo, reader_state, clock, coasting, drifting, bit_level, load, joining, stepped, bus_state,
    can_bus, lin_node, lin_bus, confinement, host, can_fd, lin_controller, sja1000_interrupts, sja1000_fifo,
    sja1000_filter, sja1000_link, sja1000_modes, sja1000, driver, can_fd_driver, message_filter, channel, line, sending,
    pace, loop, turns, program, shared_page, keeper, lockstep_pace, turn_page,
)
# fmt: on


def core_mode() -> str:
    """ "compiled", "uncompiled", or "mixed" when only some of the core's files were compiled."""
    compiled = sum(not str(module.__file__).endswith(".py") for module in MODULES)
    return "compiled" if compiled == len(MODULES) else "mixed" if compiled else "uncompiled"
