"""A table of what python-can's interfaces can do, which python-can does not report. Source: its sources, 4.6."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

PASSIVE = "BusState.PASSIVE"  # means that constant, so that python-can need not be loaded


@dataclass(frozen=True, slots=True)
class Backend:
    """One interface: the arguments that `can.Bus` needs besides channel and bit rate, and its abilities.

    `listen_only`, `fd`: arguments for these modes, None if the interface lacks them. `timing`: it accepts the bit
    rates of CAN FD as a can.BitTimingFd. `state`: its `state` is that of the controller. `classes`: its error frames
    have SocketCAN's form; of other error frames only their arrival is known. `echoes`: it receives what it sends,
    without a mark. `ours`: canwire has its own driver, and a frame counts as sent once it was on the bus.
    """

    listen_only: Mapping[str, Any] | None = None
    fd: Mapping[str, Any] | None = None
    timing: bool = False
    state: bool = False
    classes: bool = False
    echoes: bool = False
    ours: bool = False


_UNKNOWN = Backend()
BACKENDS = {
    # buses without acknowledgement: a node that sends nothing only listens
    "virtual": Backend(listen_only={}, fd={}),
    "udp_multicast": Backend(listen_only={}, fd={"fd": True}, echoes=True),
    "socketcan": Backend(fd={"fd": True}, classes=True),
    "gs_usb": Backend(listen_only={}, fd={}, classes=True, ours=True),
    "socketcand": Backend(classes=True),
    "canwire": Backend(fd={"fd": True}, state=True, classes=True),
    "pcan": Backend(listen_only={"state": PASSIVE}, fd={"fd": True}, timing=True),
    "kvaser": Backend(listen_only={"driver_mode": False}, fd={"fd": True}),
    "vector": Backend(listen_only={"listen_only": True}, fd={"fd": True}),
    "ixxat": Backend(fd={"fd": True}, state=True),
    "nixnet": Backend(listen_only={"listen_only": True}, fd={"fd": True}),
    "etas": Backend(fd={"fd": True}, state=True),
    "cantact": Backend(listen_only={"monitor": True}),
    "seeedstudio": Backend(listen_only={"operation_mode": "silent"}),
}


def backend(interface: str) -> Backend:
    """The abilities of this interface; an unknown one can only send and receive."""
    return BACKENDS.get(interface, _UNKNOWN)
