"""Scripted disturbances of a LIN bus: wrong checksums and parities, silence, short breaks, noise, a short.

The bus and its nodes do what follows from each (errors, counters, silence).
Source: reference/lin-protocol.md sections 2 and 8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from canwire.bus.lin.bits import DATA, Field, byte_levels, header_fields, response_fields
from canwire.bus.lin.bus import FREE, LinBus
from canwire.bus.lin.node import LinNode, LinResponse
from canwire.bus.lin.wire import LinDisturber, Outgoing, plain, plain_header
from canwire.bus.scripted import Scripted
from canwire.errors import BadValue
from canwire.values.lin.frame import LARGEST_ID, LARGEST_LENGTH, lin_checksum, protected_id
from canwire.values.lin.timing import SYNC_BYTE

_LONGEST_BREAK = 60
_LEVELS = {"ground": 0, "supply": 1}
_P0 = 0x40
InHeader = Callable[[LinNode, int], Outgoing]
InResponse = Callable[[LinResponse], Outgoing | None]


@dataclass(slots=True, eq=False)
class LinFault(Scripted):
    """One scripted disturbance of a header or of a response; `frame_id` chooses frames (None: any)."""

    frame_id: int | None
    in_header: InHeader | None = None
    in_response: InResponse | None = None

    def matches(self, id: int) -> bool:
        return self.times != 0 and (self.frame_id is None or self.frame_id == id)


class LinFaults(LinDisturber):
    """All scripted faults of one bus. Raises BadValue for arguments that no fault can have."""

    def __init__(self, bus: LinBus) -> None:
        self._bus = bus
        self._faults: list[LinFault] = []

    def __repr__(self) -> str:
        return f"<faults of a LIN bus: {sum(fault.times != 0 for fault in self._faults)} scripted>"

    def checksum(self, frame_id: int | None = None, *, times: int | None = 1) -> LinFault:
        """The node that answers sends a checksum that fits neither model."""
        return self._add(frame_id, times, in_response=_wrong_checksum)

    def no_response(self, frame_id: int | None = None, *, times: int | None = 1) -> LinFault:
        """The node that would answer stays silent."""
        return self._add(frame_id, times, in_response=lambda response: None)

    def cut(self, octets: int = 1, frame_id: int | None = None, *, times: int | None = 1) -> LinFault:
        """The response ends early, after `octets` bytes (0..8)."""
        _check("octets", octets, 0, LARGEST_LENGTH)
        return self._add(frame_id, times, in_response=lambda response: _cut(response, octets))

    def stop_bit(self, octet: int = 0, frame_id: int | None = None, *, times: int | None = 1) -> LinFault:
        """The stop bit of this byte of the response (0 is the first one) is dominant."""
        _check("octet", octet, 0, LARGEST_LENGTH)
        return self._add(frame_id, times, in_response=lambda response: _without_stop(response, octet))

    def flip(
        self, octet: int = 0, bit: int = 0, frame_id: int | None = None, *, times: int | None = 1
    ) -> LinFault:
        """Noise inverts one bit (0..7) of this byte of the response for all nodes, its sender included."""
        _check("octet", octet, 0, LARGEST_LENGTH)
        _check("bit", bit, 0, 7)
        return self._add(frame_id, times, in_response=lambda response: _noisy(response, octet, bit))

    def parity(self, frame_id: int | None = None, *, times: int | None = 1) -> LinFault:
        """The master sends a wrong parity bit."""
        return self._add(frame_id, times, in_header=_wrong_parity)

    def short_break(self, bits: int = 10, frame_id: int | None = None, *, times: int | None = 1) -> LinFault:
        """The master's break has `bits` bits (1..60); slaves need 11 by their own clocks."""
        _check("bits", bits, 1, _LONGEST_BREAK)
        return self._add(frame_id, times, in_header=lambda node, id: _header(node, id, break_bits=bits))

    def sync(self, value: int = 0x54, frame_id: int | None = None, *, times: int | None = 1) -> LinFault:
        """The master sends this byte in place of the sync field 0x55."""
        _check("value", value, 0, 0xFF)
        return self._add(frame_id, times, in_header=lambda node, id: _header(node, id, sync=value))

    def short(self, to: str = "ground") -> None:
        """Short the wire to "ground" (dominant) or to the "supply" (recessive), until `clear_short`."""
        if to not in _LEVELS:
            raise BadValue(f"to {to!r}: 'ground' or 'supply'")
        self._bus.short(_LEVELS[to])

    def clear_short(self) -> None:
        self._bus.short(FREE)

    def clear(self) -> None:
        """Remove all scripted faults and the short."""
        for fault in self._faults:
            fault.cancel()
        self._faults.clear()
        self._bus.wire.disturber = None
        if self._bus.bits.shorted != FREE:
            self.clear_short()

    # the bus's side

    def concerns(self, id: int) -> bool:
        return any(fault.matches(id) for fault in self._faults)

    def header(self, node: LinNode, id: int) -> Outgoing:
        for fault in self._faults:
            if fault.in_header is not None and fault.matches(id):
                fault.strike()
                return fault.in_header(node, id)
        return plain_header(node, id)

    def response(self, response: LinResponse) -> Outgoing | None:
        for fault in self._faults:
            if fault.in_response is not None and fault.matches(response.id):
                fault.strike()
                return fault.in_response(response)
        return plain(response)

    def _add(
        self,
        frame_id: int | None,
        times: int | None,
        *,
        in_header: InHeader | None = None,
        in_response: InResponse | None = None,
    ) -> LinFault:
        if frame_id is not None:
            _check("frame_id", frame_id, 0, LARGEST_ID)
        if times is not None and times < 1:
            raise BadValue(f"times {times}: at least 1, or None for every frame")
        fault = LinFault(frame_id, in_header, in_response, times=times)
        self._faults = [*(each for each in self._faults if each.times != 0), fault]
        self._bus.wire.disturber = self
        return fault


def _check(name: str, value: int, least: int, most: int) -> None:
    if not isinstance(value, int) or not least <= value <= most:
        raise BadValue(f"{name} {value!r}: from {least} to {most}")


def _header(
    node: LinNode, id: int, *, break_bits: int | None = None, sync: int = SYNC_BYTE, parity: int = 0
) -> Outgoing:
    fields = header_fields(
        protected_id(id) ^ parity,
        break_bits=node.break_bits if break_bits is None else break_bits,
        delimiter_bits=node.delimiter_bits,
        space_bits=node.space_bits,
        sync=sync,
    )
    return Outgoing(fields)


def _wrong_parity(node: LinNode, id: int) -> Outgoing:
    return _header(node, id, parity=_P0)


def _sent(response: LinResponse, octets: bytes) -> list[Field]:
    return response_fields(octets, space_bits=response.space_bits, gap_bits=response.gap_bits)


def _wrong_checksum(response: LinResponse) -> Outgoing:
    data, checksum = response.octets[:-1], response.octets[-1]
    right = {lin_checksum(data), lin_checksum(data, protected_id(response.id))}
    wrong = next(checksum ^ 1 << bit for bit in range(3) if checksum ^ 1 << bit not in right)
    return Outgoing(_sent(response, data + bytes([wrong])))


def _cut(response: LinResponse, octets: int) -> Outgoing | None:
    if octets == 0:
        return None
    return Outgoing(_sent(response, response.octets[:octets]))


def _without_stop(response: LinResponse, octet: int) -> Outgoing:
    fields = _sent(response, response.octets)
    places = [k for k, field in enumerate(fields) if field.kind == DATA]
    if octet < len(places):
        fields[places[octet]] = Field(DATA, byte_levels(response.octets[octet], stop=0))
    return Outgoing(fields)


def _noisy(response: LinResponse, octet: int, bit: int) -> Outgoing:
    fields = _sent(response, response.octets)
    places = [k for k, field in enumerate(fields) if field.kind == DATA]
    flips = {(places[octet], bit + 1)} if octet < len(places) else set()
    return Outgoing(fields, frozenset(flips))
