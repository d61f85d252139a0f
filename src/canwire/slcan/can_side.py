"""What a dongle's firmware asks of its CAN controller."""

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

    With `data_timing` it speaks CAN FD.
    """

    timing: BitTiming
    data_timing: BitTiming | None = None
    listen_only: bool = False
    code: bytes = ACCEPT_ALL[0]
    mask: bytes = ACCEPT_ALL[1]


class CanSide(Protocol):
    """One controller with its transceiver; the dongle alone uses it, and never blocks in it for long.

    `send` is called for TRANSMIT_QUEUE frames at most that have not come back; they go out in their order. Each
    comes back by `poll` among the received ones, marked `self_received`, once it went through. `close` gives up
    what waits, even in the middle of a frame, and a second time does nothing; nothing comes back after it.
    Raises LineError or BadValue for what the controller cannot do, HubError once there is no controller any more.
    """

    def open(self, setup: Setup) -> None:
        """Go on the bus, with error counters at 0."""

    def close(self) -> None:
        """Go off the bus."""

    def send(self, frame: Frame, *, single_shot: bool = False) -> None:
        """Queue a frame."""

    def poll(self) -> Sequence[Frame]:
        """What was received and sent since the last time; not necessarily everything, none when there is no more."""

    def events(self) -> Sequence[BusEvent]:
        """What happened besides since the last time."""

    def count_refused(self, count: int) -> None:
        """So many frames of the host were refused for want of room: have them counted where people look."""

    def lost(self) -> int:
        """Frames that were lost since it was made, because `poll` was not called in time."""
