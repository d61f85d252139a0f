"""Checks and converts the arguments of can.Bus."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from types import NoneType
from typing import Any

import can

from canwire import BadValue, BitTiming, Hub, Lab

_IGNORE_ERRORS = "ignore_rx_error_frames"  # SocketCAN's
_NO_EFFECT = {"single_handle"}  # of other interfaces; python-can's tests give them to every interface
_ANYWAY = {"local_loopback": True}  # SocketCAN's: other programs on the same line receive what this one sends


def check_arguments(
    bitrate: object, data_bitrate: object, hub: object, can_filters: object, *, fd: bool
) -> None:
    """Raise BadValue for arguments of the wrong type, with an example, and for a data rate without FD."""
    for name, rate in (("bitrate", bitrate), ("data_bitrate", data_bitrate)):
        if rate is not None and not isinstance(rate, int):
            raise BadValue(f"{name}={rate!r}: a whole number of bit/s, such as 500_000 for 500 kbit/s")
    if data_bitrate and not fd:
        raise BadValue(
            f"data_bitrate={data_bitrate}: only CAN FD has a data phase; add fd=True, or leave it out"
        )
    if not isinstance(hub, (str, Hub, Lab, NoneType)):
        raise BadValue(f"hub={hub!r}: the address of a hub's socket, a canwire.Hub or a canwire.Lab")
    for one in can_filters if isinstance(can_filters, (list, tuple)) else ():
        if not isinstance(one, Mapping):
            raise BadValue(
                f'can_filters: {one!r} is no filter; one is {{"can_id": 0x120, "can_mask": 0x7F0}}'
            )


def state_of(state: can.BusState | str) -> can.BusState:
    """The BusState of this name; raises ValueError unless it is ACTIVE or PASSIVE."""
    found = can.BusState[state.upper()] if isinstance(state, str) else state
    if found not in (can.BusState.ACTIVE, can.BusState.PASSIVE):
        raise ValueError(f"state {state}: BusState.ACTIVE or BusState.PASSIVE")
    return found


def timings_of(timing: can.BitTiming | can.BitTimingFd | None) -> tuple[BitTiming | None, BitTiming | None]:
    """The timings of both phases, for the clock that they were made for."""
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
    """Which error frames are wanted, also by SocketCAN's argument `ignore_rx_error_frames`.

    Raises BadValue for any other argument that is not `known`; the message names similar ones.
    """
    for name, value in others.items():
        if name in _NO_EFFECT:
            warnings.warn(
                f"can.Bus(interface='canwire'): {name}={value!r} has no effect: it is for Kvaser adapters",
                stacklevel=4,
            )
        elif name != _IGNORE_ERRORS and (name not in _ANYWAY or bool(value) is not _ANYWAY[name]):
            raise BadValue(f"can.Bus(interface='canwire'): {name}={value!r} {_unknown(name, known)}")
    return False if others.get(_IGNORE_ERRORS) else error_frames


def _unknown(name: str, known: Iterable[str]) -> str:
    if name in _ANYWAY:
        return "is not possible: programs on one line always receive each other's messages"
    names = [*known, _IGNORE_ERRORS]
    near = get_close_matches(name, names, 3, 0.6)
    hint = f"did you mean {' or '.join(near)}?" if near else f"there are {', '.join(names)}"
    return f"is no argument; {hint}"
