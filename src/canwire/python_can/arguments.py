"""python-can's arguments in our terms."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Any

import can

from canwire import BadValue, BitTiming

_IGNORE_ERRORS = "ignore_rx_error_frames"  # SocketCAN's
_NO_EFFECT = {"single_handle"}  # other interfaces' own, which python-can's tests give to every one
_ANYWAY = {"local_loopback": True}  # SocketCAN's: other programs on the same line hear what this one sends


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


def error_frames_of(
    error_frames: bool | None, others: Mapping[str, Any], known: Iterable[str]
) -> bool | None:
    """Which error frames are wanted, SocketCAN's word for it included.

    Raises BadValue for any other argument that is not `known`, with those that look like it.
    """
    for name, value in others.items():
        if name in _NO_EFFECT:
            warnings.warn(
                f"can.Bus(interface='canwire'): {name}={value!r} has no effect here: it is Kvaser's",
                stacklevel=4,
            )
        elif name != _IGNORE_ERRORS and (name not in _ANYWAY or bool(value) is not _ANYWAY[name]):
            raise BadValue(f"can.Bus(interface='canwire'): {name}={value!r} {_unknown(name, known)}")
    return False if others.get(_IGNORE_ERRORS) else error_frames


def _unknown(name: str, known: Iterable[str]) -> str:
    if name in _ANYWAY:
        return "is not possible: programs on one line always hear each other"
    names = [*known, _IGNORE_ERRORS]
    near = get_close_matches(name, names, 3, 0.6)
    hint = f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(names)}"
    return f"is no argument; {hint}"
