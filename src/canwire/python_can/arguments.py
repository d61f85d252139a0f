"""python-can's arguments in our terms."""

from __future__ import annotations

import can

from canwire import BitTiming


def state_of(state: can.BusState | str) -> can.BusState:
    """Raises ValueError for what is no state that one can ask for."""
    found = can.BusState[state.upper()] if isinstance(state, str) else state
    if found not in (can.BusState.ACTIVE, can.BusState.PASSIVE):
        raise ValueError(f"state {state}: BusState.ACTIVE or BusState.PASSIVE")
    return found


def timings_of(timing: can.BitTiming | can.BitTimingFd | None) -> tuple[BitTiming | None, BitTiming | None]:
    """For both phases, at the clock that they were made for."""
    if timing is None:
        return None, None
    clock_hz = timing.f_clock
    if isinstance(timing, can.BitTiming):
        triple = timing.nof_samples == 3
        nominal = BitTiming(
            timing.brp, timing.tseg1, timing.tseg2, timing.sjw, clock_hz=clock_hz, triple_sampling=triple
        )
        return nominal, None
    return (
        BitTiming(timing.nom_brp, timing.nom_tseg1, timing.nom_tseg2, timing.nom_sjw, clock_hz=clock_hz),
        BitTiming(timing.data_brp, timing.data_tseg1, timing.data_tseg2, timing.data_sjw, clock_hz=clock_hz),
    )
