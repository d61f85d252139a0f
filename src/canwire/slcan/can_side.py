"""The interface of a dongle's firmware to its CAN controller."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from canwire import BitTiming, BusEvent, Frame

ACCEPT_ALL = (bytes(4), b"\xff\xff\xff\xff")  # AC0..AC3, AM0..AM3 after power-up
TRANSMIT_QUEUE = 8  # frames (source: CANBUS manual, 1.3)


@dataclass(frozen=True, slots=True)
class Setup:
    """How the controller takes part in the bus. `code` and `mask` are the SJA1000's ACR0..3 and AMR0..3.

    With `data_timing` it uses CAN FD.
    """

    timing: BitTiming
    data_timing: BitTiming | None = None
    listen_only: bool = False
    code: bytes = ACCEPT_ALL[0]
    mask: bytes = ACCEPT_ALL[1]


class CanSide(Protocol):
    """One controller with its transceiver. Only the dongle uses it; no method blocks for long.

    At most TRANSMIT_QUEUE sent frames may be outstanding; they are sent in their order. `poll` returns each of them
    among the received frames, marked `self_received`, once it was on the bus. `close` discards frames that wait, even
    in the middle of a frame; a second call has no effect, and nothing is returned after it.
    Raises LineError or BadValue for settings that the controller cannot have, HubError if the controller is gone.
    """

    def open(self, setup: Setup) -> None:
        """Take part in the bus, with error counters at 0."""

    def close(self) -> None:
        """Leave the bus."""

    def send(self, frame: Frame, *, single_shot: bool = False) -> None:
        """Queue a frame."""

    def poll(self) -> Sequence[Frame]:
        """Frames received and sent since the last call; possibly only some of them. Empty when no more are left."""

    def events(self) -> Sequence[BusEvent]:
        """Other events since the last call."""

    def count_refused(self, count: int) -> None:
        """Count this many frames of the host that found no room, in the counters that users see."""

    def lost(self) -> int:
        """Frames lost since the start because `poll` was called too late."""
