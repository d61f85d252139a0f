"""Faults that a program sets on a LIN bus of its hub: those of the lab's LIN buses."""

from __future__ import annotations

from typing import Unpack

from canwire.hub.handles.bus.fault import HubFault
from canwire.hub.handles.bus.setting import BusFaults, FaultStay
from canwire.hub.protocol import fault_messages as f


class LinBusFaults(BusFaults):
    """`frame_id` chooses frames (None: any); `times` is how many times the fault occurs (None: no limit)."""

    def checksum(
        self, frame_id: int | None = None, *, times: int | None = 1, **stay: Unpack[FaultStay]
    ) -> HubFault:
        """The responding node sends a checksum that fits neither model."""
        return self._frames("checksum", (), frame_id, times, stay)

    def no_response(
        self, frame_id: int | None = None, *, times: int | None = 1, **stay: Unpack[FaultStay]
    ) -> HubFault:
        """The node that should respond stays silent."""
        return self._frames("no_response", (), frame_id, times, stay)

    def cut(
        self,
        octets: int = 1,
        frame_id: int | None = None,
        *,
        times: int | None = 1,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """The response breaks off after `octets` bytes (0..8)."""
        return self._frames("cut", (octets,), frame_id, times, stay)

    def stop_bit(
        self, octet: int = 0, frame_id: int | None = None, *, times: int | None = 1, **stay: Unpack[FaultStay]
    ) -> HubFault:
        """The stop bit of this byte of the response (0 is the first one) is dominant."""
        return self._frames("stop_bit", (octet,), frame_id, times, stay)

    def flip(
        self,
        octet: int = 0,
        bit: int = 0,
        frame_id: int | None = None,
        *,
        times: int | None = 1,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """Noise inverts one bit (0..7) of this byte of the response for every node, its sender included."""
        return self._frames("flip", (octet, bit), frame_id, times, stay)

    def parity(
        self, frame_id: int | None = None, *, times: int | None = 1, **stay: Unpack[FaultStay]
    ) -> HubFault:
        """The master sends a wrong parity bit."""
        return self._frames("parity", (), frame_id, times, stay)

    def short_break(
        self, bits: int = 10, frame_id: int | None = None, *, times: int | None = 1, **stay: Unpack[FaultStay]
    ) -> HubFault:
        """The master's break has `bits` bits (1..60); slaves need at least 11 of their bit times."""
        return self._frames("short_break", (bits,), frame_id, times, stay)

    def sync(
        self,
        value: int = 0x54,
        frame_id: int | None = None,
        *,
        times: int | None = 1,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """The master sends this byte in place of the sync field 0x55."""
        return self._frames("sync", (value,), frame_id, times, stay)

    def short(self, to: str = "ground", **stay: Unpack[FaultStay]) -> HubFault:
        """Short the wire to "ground" (dominant) or to the "supply" (recessive), until `cancel`."""
        return self._set(f.Short(to), stay)

    def _frames(
        self, kind: str, numbers: tuple[int, ...], frame_id: int | None, times: int | None, stay: FaultStay
    ) -> HubFault:
        return self._set(f.LinFrames(kind, numbers, frame_id, times), stay)
