"""Frames as the lower tester sends them: any format, any reserved bit, every bit with its name and rate.

Imports nothing of canwire: what the wire must look like is said here once more, from the rules.
Source: reference/can-protocol.md sections 1 to 4.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from tests.bus.can.reference_bits import (
    CRC_15,
    CRC_17,
    CRC_21,
    FD_LENGTH,
    GRAY_AND_PARITY,
    binary,
    opposite,
    remainder,
)


@dataclass(frozen=True)
class Spec:
    """A frame by its bits' values. `reserved`: other than usual values of "SRR", "RRS", "FDF", "res", "r0"."""

    id: int
    data: bytes = b""
    extended: bool = False
    remote: bool = False
    fd: bool = False
    brs: bool = True
    esi: bool = False
    dlc: int | None = None
    reserved: tuple[tuple[str, str], ...] = ()

    @property
    def code(self) -> int:
        """DLC."""
        if self.dlc is not None:
            return self.dlc
        return FD_LENGTH.index(len(self.data))

    def but(self, **changes: object) -> Spec:
        return replace(self, **changes)  # type: ignore[arg-type]


@dataclass
class Bits:
    """A frame on the wire: levels as "0" and "1", the field of each bit, whether it is a stuff bit, and its rate.

    The ACK slot is recessive. `names` has "FSB" for fixed stuff bits' field too, with `stuff` "fixed".
    """

    spec: Spec
    levels: str = ""
    names: list[str] = field(default_factory=list)
    stuff: list[str] = field(default_factory=list)  # "", "dynamic" or "fixed"
    fast: list[bool] = field(default_factory=list)

    def index(self, name: str, bit: int = 1) -> int:
        """Which bit of the frame the bit-th of a field is, on the wire: stuff bits included."""
        found = [k for k, other in enumerate(self.names) if other == name]
        return found[bit - 1]

    def plain(self, name: str, level: str = "", nth: int = 1) -> int:
        """The nth bit of a field that is no stuff bit, of this level if one is given."""
        found = [
            k
            for k, other in enumerate(self.names)
            if other == name and not self.stuff[k] and level in ("", self.levels[k])
        ]
        return found[nth - 1]

    def stuffs(self, kind: str = "dynamic", name: str = "", level: str = "") -> list[int]:
        """Every stuff bit of a kind, of a field, of a level."""
        return [
            k
            for k, what in enumerate(self.stuff)
            if what == kind and name in ("", self.names[k]) and level in ("", self.levels[k])
        ]

    @property
    def ack(self) -> int:
        return self.names.index("ACK")

    def put(self, name: str, levels: str, kind: str = "", fast: bool = False) -> None:
        self.levels += levels
        self.names += [name] * len(levels)
        self.stuff += [kind] * len(levels)
        self.fast += [fast] * len(levels)


def header(spec: Spec) -> list[tuple[str, str]]:
    """Fields from SOF to DLC, without stuff bits."""
    other = dict(spec.reserved)
    fdf = other.get("FDF", "1" if spec.fd else "0")
    request = "1" if spec.remote else "0"
    fields = [("SOF", "0")]
    if spec.extended:
        fields += [("ID", binary(spec.id >> 18, 11)), ("SRR", other.get("SRR", "1")), ("IDE", "1")]
        fields += [("EXT", binary(spec.id % 2**18, 18)), ("RTR", other.get("RRS", request)), ("FDF", fdf)]
        if not spec.fd:
            fields.append(("r0", other.get("r0", "0")))
    else:
        fields += [
            ("ID", binary(spec.id, 11)),
            ("RTR", other.get("RRS", request)),
            ("IDE", "0"),
            ("FDF", fdf),
        ]
    if spec.fd:
        fields += [
            ("res", other.get("res", "0")),
            ("BRS", "1" if spec.brs else "0"),
            ("ESI", "1" if spec.esi else "0"),
        ]
    return [*fields, ("DLC", binary(spec.code, 4))]


def lay_out(spec: Spec, *, crc_change: int = 0, parity_change: bool = False) -> Bits:
    """The frame in bits. `crc_change` is XORed into the CRC, `parity_change` alters the stuff count, the rest fits."""
    bits = Bits(spec)
    fields = header(spec)
    if spec.data and not spec.remote:
        fields.append(("DATA", "".join(binary(byte, 8) for byte in spec.data)))
    plain = [(name, level) for name, levels in fields for level in levels]
    if spec.fd:
        _flexible(bits, plain, crc_change, parity_change)
    else:
        check = int(remainder("".join(level for _, level in plain), CRC_15, "0" * 15), 2) ^ crc_change
        _stuffed(bits, [*plain, *(("CRC", level) for level in binary(check, 15))], ends_stuffed=True)
    for name, count in (("CRC DEL", 1), ("ACK", 1), ("ACK DEL", 1), ("EOF", 7)):
        bits.put(name, "1" * count)
    if bits.spec.fd and bits.spec.brs:  # the CRC delimiter begins at the data rate
        bits.fast[bits.names.index("CRC DEL")] = True
    return bits


def _stuffed(bits: Bits, plain: list[tuple[str, str]], *, ends_stuffed: bool) -> None:
    fast = False
    for k, (name, level) in enumerate(plain):
        bits.put(name, level, fast=fast)
        fast = fast or (name == "BRS" and level == "1")
        if bits.levels[-5:] in ("00000", "11111") and (ends_stuffed or k < len(plain) - 1):
            bits.put(plain[min(k + 1, len(plain) - 1)][0], opposite(level), "dynamic", fast)


def _flexible(bits: Bits, plain: list[tuple[str, str]], crc_change: int, parity_change: bool) -> None:
    _stuffed(bits, plain, ends_stuffed=False)
    inserted = bits.stuff.count("dynamic")
    count = GRAY_AND_PARITY[inserted % 8]
    polynomial = CRC_17 if len(bits.spec.data) <= 16 else CRC_21
    width = len(polynomial) - 1
    if parity_change:
        count = count[:3] + opposite(count[3])
    check = int(remainder(bits.levels + count, polynomial, "1" + "0" * (width - 1)), 2) ^ crc_change
    tail = count + binary(check, width)
    for k, level in enumerate(tail):
        name = "COUNT" if k < 4 else "CRC"
        if k % 4 == 0:
            bits.put(name, opposite(bits.levels[-1]), "fixed", bits.spec.brs)
        bits.put(name, level, fast=bits.spec.brs)


def pattern(text: str, *, extended: bool, fd: bool, only_first: bool = False) -> Spec:
    """One frame of the stuffing tables, "ID/CTRL/data": data as hexadecimal bytes, "8x3C", "F8 then 47x78" or "-".

    `only_first` keeps byte 0 alone of FD data, all others are 55.
    """
    number, control, octets = text.split("/")
    data = b"".join(_octets(part) for part in octets.split(" then "))
    ctrl = int(control, 16)
    if fd:
        shift = {False: 10, True: 10}[extended]
        rest, top = ctrl & 0x3F, ctrl >> 6
        brs, esi, dlc = bool(rest & 0x20), bool(rest & 0x10), rest & 15
        assert shift == 10
        length = FD_LENGTH[dlc]
        data = (data[:1] + b"\x55" * 64)[:length] if only_first else data
        names = ("SRR", "IDE", "RRS", "FDF", "res")[0 if extended else 2 :]
        if not extended:
            names = ("RRS", "IDE", "FDF", "res")
        values = binary(top, len(names))
        reserved = tuple((n, v) for n, v in zip(names, values, strict=True) if n in ("SRR", "RRS"))
        return Spec(int(number, 16), data, extended, False, True, brs, esi, dlc, reserved)
    names = ("SRR", "IDE", "RTR", "FDF", "r0") if extended else ("RTR", "IDE", "FDF")
    values = dict(zip(names, binary(ctrl >> 4, len(names)), strict=True))
    reserved = tuple((n, v) for n, v in values.items() if n in ("SRR", "FDF", "r0"))
    return Spec(
        int(number, 16), data, extended, values["RTR"] == "1", False, False, False, ctrl & 15, reserved
    )


def _octets(text: str) -> bytes:
    if text == "-":
        return b""
    if "x" in text:
        count, octet = text.split("x")
        return bytes.fromhex(octet) * int(count)
    return bytes.fromhex(text)
