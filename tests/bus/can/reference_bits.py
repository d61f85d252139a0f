"""Frame -> bits, slowly and obviously, from reference/can-protocol.md sections 1 to 4.

It imports nothing of canwire. A frame is a string of "0" (dominant) and "1" (recessive),
grown one field after the other.
"""

from __future__ import annotations

from typing import NamedTuple

FD_LENGTH = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64]
CRC_15 = "1100010110011001"  # the full polynomials of section 3, highest power first
CRC_17 = "110110100001011011"
CRC_21 = "1100000010100010011001"
GRAY_AND_PARITY = ["0000", "0011", "0110", "0101", "1100", "1111", "1010", "1001"]
CLASSIC_TAIL = FD_TAIL = "1" + "1" + "1" + "1111111"  # CRC delimiter, ACK slot as sent, ACK delimiter, EOF


class Reference(NamedTuple):
    """What the wire shows: `bits` SOF to EOF with an unacknowledged (recessive) ACK slot.

    `arbitration` is the unstuffed arbitration field, `stuff_bits` the dynamic ones, `data_bits` those from
    the one after BRS to the last CRC bit (0 without BRS).
    """

    bits: str
    arbitration: str
    crc: int
    stuff_bits: int
    stuff_count: str
    data_bits: int


def classic(id: int, *, extended: bool, remote: bool, dlc: int, data: bytes) -> Reference:
    arbitration = arbitration_field(id, extended=extended, remote=remote)
    control = ("00" if extended else "0") + binary(
        dlc, 4
    )  # r1 r0, or r0; IDE stands in the arbitration field
    plain = "0" + arbitration + control + data_field(data)
    check = remainder(plain, CRC_15, "0" * 15)
    stuffed = stuff(plain + check, ends_stuffed=True)
    inserted = len(stuffed) - len(plain) - 15
    return Reference(stuffed + CLASSIC_TAIL, arbitration, int(check, 2), inserted, "", 0)


def flexible(
    id: int, *, extended: bool, switch: bool, passive: bool, dlc: int, data: bytes, iso: bool = True
) -> Reference:
    """A CAN FD frame."""
    arbitration = arbitration_field(id, extended=extended, remote=False)
    slow = "0" + arbitration + "1" + "0" + ("1" if switch else "0")  # SOF .. FDF, res, BRS
    plain = slow + ("1" if passive else "0") + binary(dlc, 4) + data_field(data)
    stuffed = stuff(plain, ends_stuffed=False)
    inserted = len(stuffed) - len(plain)
    count = GRAY_AND_PARITY[inserted % 8] if iso else ""
    polynomial = CRC_17 if len(data) <= 16 else CRC_21
    width = len(polynomial) - 1
    check = remainder(stuffed + count, polynomial, ("1" if iso else "0") + "0" * (width - 1))
    tail = fixed_stuffing(count + check, last=stuffed[-1])
    slow_bits = len(stuff(slow, ends_stuffed=False))
    data_bits = len(stuffed) + len(tail) - slow_bits if switch else 0
    return Reference(stuffed + tail + FD_TAIL, arbitration, int(check, 2), inserted, count, data_bits)


def arbitration_field(id: int, *, extended: bool, remote: bool) -> str:
    """Identifier, RTR (RRS) and IDE as they follow SOF; 29-bit: base, SRR 1, IDE 1, extension, RTR."""
    rtr = "1" if remote else "0"
    if not extended:
        return binary(id, 11) + rtr + "0"
    return binary(id >> 18, 11) + "1" + "1" + binary(id % 2**18, 18) + rtr


def wins(one: str, other: str) -> bool | None:
    """Wired AND, bit by bit: does the sender of `one` see `other` fall silent? None if neither ever does."""
    for mine, theirs in zip(one, other, strict=False):
        bus = "0" if "0" in (mine, theirs) else "1"
        if mine != bus:
            return False
        if theirs != bus:
            return True
    return None


def binary(value: int, width: int) -> str:
    return format(value, f"0{width}b")


def data_field(data: bytes) -> str:
    return "".join(binary(byte, 8) for byte in data)


def stuff(plain: str, *, ends_stuffed: bool) -> str:
    """After five equal bits the opposite one; behind the very last bit only if `ends_stuffed`."""
    wire = ""
    for k, bit in enumerate(plain):
        wire += bit
        last = k == len(plain) - 1
        if wire[-5:] in ("00000", "11111") and (ends_stuffed or not last):
            wire += opposite(bit)
    return wire


def fixed_stuffing(plain: str, *, last: str) -> str:
    """Before every group of four bits the opposite of the bit before it."""
    wire = ""
    for k, bit in enumerate(plain):
        if k % 4 == 0:
            wire += opposite((last + wire)[-1])
        wire += bit
    return wire


def remainder(message: str, polynomial: str, start: str) -> str:
    """Section 3, word by word: next = bit XOR msb; shift left; if next XOR polynomial."""
    width, divisor, register = len(start), int(polynomial[1:], 2), int(start, 2)
    for bit in message:
        following = int(bit) ^ register >> width - 1
        register = register << 1 & (1 << width) - 1
        if following:
            register ^= divisor
    return binary(register, width)


def opposite(bit: str) -> str:
    return "0" if bit == "1" else "1"
