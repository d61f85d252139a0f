"""What python-can's interfaces can do, as a table; python-can itself does not tell. Source: its sources, 4.6."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

PASSIVE = "BusState.PASSIVE"  # stands for that constant, so that python-can need not be loaded


@dataclass(frozen=True, slots=True)
class Backend:
    """One interface: what `can.Bus` wants to be told beside channel and bit rate.

    `listen_only`, `fd`: arguments for it, None where it cannot. With `timing` it takes CAN FD's bit rates as a
    can.BitTimingFd. `state`: its `state` is the controller's. `classes`: its error frames are in
    SocketCAN's form; of others no more is known than that they are some. `echoes`: it receives what it sends, and
    does not say which that is. `ours`: canwire drives it itself, and a frame is sent once the bus has taken it.
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
    # on buses without acknowledge, saying nothing is listening only
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
    """What is known of it; of others only that they send and receive."""
    return BACKENDS.get(interface, _UNKNOWN)
