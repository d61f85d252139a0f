"""Faults that a program sets on a CAN bus of its hub: those of docs/faults.md, with lines in place of nodes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Unpack

from canwire.errors import BadValue
from canwire.hub.handles.bus.fault import HubFault
from canwire.hub.handles.bus.setting import BusFaults, FaultStay
from canwire.hub.protocol import fault_messages as f
from canwire.values.frame import Frame, record_of_frame
from canwire.values.mistakes.names import answers_wrong_names

At = f.HubPlace | int | None
SeenBy = str | Iterable[str]
_PROVOKED = {"stuff": "receivers", "form": "receivers", "crc": "receivers", "bit": "sender", "ack": "sender"}


@answers_wrong_names
class CanBusFaults(BusFaults):
    """Lines are named "HW000001:1". `seen_by` is "all", "receivers", "sender", a line or several.

    `at` is a place, a time of the hub in ns, or None (immediately). `times` is how often it occurs (None: no limit).
    """

    def place(
        self,
        part: str,
        bit: int = 1,
        *,
        frame_id: int | None = None,
        extended: bool | None = None,
        node: str | None = None,
    ) -> f.HubPlace:
        """The start of a bit, for `at`: a part and its bit as in docs/faults.md; the bits of `node` are counted."""
        return f.HubPlace(part, bit, frame_id, extended, node or "")

    def flip(
        self,
        *,
        bit: int | str,
        frame_id: int | None = None,
        extended: bool | None = None,
        times: int | None = 1,
        seen_by: SeenBy = "all",
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """Invert one bit of matching frames, by number from SOF (0, stuff bits included) or by name."""
        return self._set(f.Flip(bit, frame_id, extended, times, _seen(seen_by)), stay)

    def inject(
        self,
        error: str,
        *,
        frame_id: int | None = None,
        extended: bool | None = None,
        times: int | None = 1,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """Provoke one kind of error in matching frames: "stuff", "form", "crc", "bit" or "ack"."""
        if error not in _PROVOKED:
            raise BadValue(f"error {error!r}: one of {', '.join(_PROVOKED)}")
        seen_by = _PROVOKED[error]
        return self.flip(
            bit=error, frame_id=frame_id, extended=extended, times=times, seen_by=seen_by, **stay
        )

    def noise(self, bit_error_rate: float, **stay: Unpack[FaultStay]) -> HubFault:
        """Every node reads each bit of a frame wrong with this probability; several noise faults add up."""
        return self._set(f.Noise(bit_error_rate), stay)

    def hold(
        self,
        level: str,
        *,
        at: At = None,
        bits: int | None = 1,
        seen_by: SeenBy = "all",
        times: int | None = 1,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """Hold the bus "dominant" or "recessive" for `bits` bit times; None: until the fault ends."""
        return self._set(f.Hold(level, at, bits, _seen(seen_by), times), stay)

    def play(
        self,
        levels: str,
        *,
        at: At = None,
        seen_by: SeenBy = "all",
        times: int | None = 1,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """Force one level a bit: "0" dominant, "1" recessive, "-" leaves the bit as it is."""
        return self._set(f.Play(levels, at, _seen(seen_by), times), stay)

    def glitch(
        self,
        level: str,
        *,
        at: At = None,
        from_ns: float = 0.0,
        width_ns: float,
        seen_by: SeenBy = "all",
        times: int | None = 1,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """Force a level for `width_ns`, shorter or longer than a bit, starting `from_ns` after the place or time."""
        return self._set(f.Glitch(level, at, from_ns, width_ns, _seen(seen_by), times), stay)

    def move_edge(
        self,
        quanta: int,
        *,
        at: f.HubPlace,
        to: str = "dominant",
        seen_by: SeenBy = "all",
        times: int | None = 1,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """Move the edge at the start of a frame's bit, which leads `to` this level, by quanta (< 0: forward)."""
        return self._set(f.MoveEdge(quanta, at, to, _seen(seen_by), times), stay)

    def short(self, **stay: Unpack[FaultStay]) -> HubFault:
        """Short the wires: the bus is dominant until `cancel`."""
        return self._set(f.Short(), stay)

    def drift(self, line: str, ppm: float, **stay: Unpack[FaultStay]) -> HubFault:
        """A line's oscillator runs fast, or slow (negative), by up to 100,000 ppm; several drifts add up."""
        return self._set(f.Drift(line, ppm), stay)

    def wrong_rate(self, line: str, bit_rate: int, **stay: Unpack[FaultStay]) -> HubFault:
        """A line that is set up runs at this rate (bit/s) instead of the one that was set."""
        return self._set(f.WrongRate(line, bit_rate), stay)

    def cable(self, length_m: float, *, node_delay_ns: float = 0.0, **stay: Unpack[FaultStay]) -> HubFault:
        """Set the cable's length and the one-way delay that each isolated node adds; the latest cable is effective."""
        return self._set(f.Cable(length_m, node_delay_ns), stay)

    def babble(
        self,
        frame_id: int = 0,
        data: bytes = b"",
        *,
        frame: Frame | None = None,
        gap: float = 0.0,
        times: int | None = None,
        **stay: Unpack[FaultStay],
    ) -> HubFault:
        """An additional node repeats a frame, `gap` seconds apart; with identifier 0 it can block all other nodes.

        It acknowledges frames as other nodes do, and errors may bring it to bus-off.
        """
        if not 0 <= gap < 1e6:
            raise BadValue(f"gap {gap!r}: seconds, not negative")
        record = record_of_frame(frame or Frame(frame_id, data))
        return self._set(f.Babble(record, round(gap * 1e9), times), stay)


def _seen(seen_by: SeenBy) -> f.SeenBy:
    return (seen_by,) if isinstance(seen_by, str) else tuple(seen_by)
