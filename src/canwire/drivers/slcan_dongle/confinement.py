"""The controller's state by the bits of F. EI and EPI are interrupts of the SJA1000 for changes in both directions.

EI: the status bits ES (a counter at its warning limit) or BS (bus-off) changed. EPI: error passive was entered or left.
Between two readings of F only one change of each kind shows. If a controller seems to have recovered and has not,
later bus errors show that (source: SJA1000 data sheet 6.4.6; reference/sja1000.md section 11).
"""

from __future__ import annotations

from canwire.values.event import ErrorState

EI, EPI = 1 << 2, 1 << 5
_ACTIVE, _WARNING, _PASSIVE, _OFF, _STOPPED = ErrorState

_AFTER = {
    (_ACTIVE, EI): _WARNING,
    (_ACTIVE, EPI): _PASSIVE,
    (_ACTIVE, EI | EPI): _PASSIVE,
    (_WARNING, EI): _ACTIVE,
    (_WARNING, EPI): _PASSIVE,
    (_WARNING, EI | EPI): _PASSIVE,
    (_PASSIVE, EI): _OFF,  # from passive straight to active takes EPI as well
    (_PASSIVE, EPI): _WARNING,
    (_PASSIVE, EI | EPI): _ACTIVE,
    (_OFF, EI): _ACTIVE,
    (_OFF, EPI): _PASSIVE,
    (_OFF, EI | EPI): _PASSIVE,
}


def state_after(state: ErrorState, flags: int) -> ErrorState:
    """The state after F returned these flags."""
    return _AFTER.get((state, flags & (EI | EPI)), state)
