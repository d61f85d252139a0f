"""The F byte: the SJA1000's interrupt register, except three bits that the firmware uses or that have no use.

Source: CANBUS manual, F; reference/sja1000.md section 11.
"""

from __future__ import annotations

from canwire import BusEvent, ErrorState, EventKind

RECEIVE_FULL = 1 << 0
TRANSMIT_FULL = 1 << 1
ERROR_WARNING = 1 << 2  # EI
OVERRUN = 1 << 3  # DOI
ERROR_PASSIVE = 1 << 5  # EPI
ARBITRATION_LOST = 1 << 6  # ALI
BUS_ERROR = 1 << 7  # BEI
QUIET = ARBITRATION_LOST  # does not light the red LED

_WARNED = {ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE, ErrorState.BUS_OFF}  # status bit ES
_OF_KIND = {
    EventKind.ERROR: BUS_ERROR,
    EventKind.ARBITRATION_LOST: ARBITRATION_LOST,
    EventKind.OVERRUN: OVERRUN,
}


class Watch:
    """Turns events on the bus into bits. It stores the previous state, because EI and EPI report changes.

    EI is a change of the status bits ES and BS in either direction; EPI is a change into error passive, and from there
    back to error active (source: SJA1000 data sheet, table 15). Bus-off therefore shows only as EI.
    """

    def __init__(self) -> None:
        self.state = ErrorState.ERROR_ACTIVE

    def restart(self) -> None:
        """The controller starts with counters at 0; this change sets no bits."""
        self.state = ErrorState.ERROR_ACTIVE

    def flags_of(self, event: BusEvent) -> int:
        """The bits that this event sets."""
        if event.kind is not EventKind.STATE:
            return _OF_KIND.get(event.kind, 0)
        before, self.state = self.state, event.state
        if ErrorState.STOPPED in (before, event.state):
            return 0
        flags = 0
        if (before in _WARNED) != (event.state in _WARNED) or ErrorState.BUS_OFF in (before, event.state):
            flags |= ERROR_WARNING
        passive = ErrorState.ERROR_PASSIVE
        if passive in (before, event.state) and ErrorState.BUS_OFF not in (before, event.state):
            flags |= ERROR_PASSIVE
        return flags if before is not event.state else 0
