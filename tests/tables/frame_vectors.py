"""Frame vectors C01-C32 and D01-D16, copied from reference/can-protocol.md section 11.

There: an encoder of its own, agreeing bit for bit with the iso-16845 compliance library (all) and with the
freecores/can core on a simulated bus (C01-C32), in length with can-utils (C01-C30); most of them read back by
the sigrok decoder. The non-ISO CRC is that encoder's alone; such a frame is 5 bits shorter.

`bits` counts SOF to the last EOF bit with stuff bits. Flags: S 11-bit, E 29-bit, R remote, B bit-rate switch,
I error state indicator.
"""

from __future__ import annotations

from typing import NamedTuple


class Vector(NamedTuple):
    """One row; `crc` CRC-15, 17 or 21, `stuff_bits` the dynamic ones, FD columns empty for classic ones."""

    name: str
    id: int
    flags: str
    dlc: int
    data: bytes
    crc: int
    stuff_bits: int
    bits: int
    fd: bool = False
    stuff_count: str = ""
    data_bits: int = 0
    non_iso_crc: int = 0

    @property
    def keywords(self) -> dict[str, int | bool]:
        """What Frame takes besides identifier and data."""
        return {
            "extended": "E" in self.flags,
            "remote": "R" in self.flags,
            "fd": self.fd,
            "bit_rate_switch": "B" in self.flags,
            "error_state_indicator": "I" in self.flags,
            "dlc": self.dlc,
        }


def counted(length: int) -> bytes:
    return bytes(range(length))


CLASSIC = [
    Vector("C01", 0x000, "S", 0, b"", 0x0000, 6, 50),
    Vector("C02", 0x7FF, "S", 0, b"", 0x272F, 3, 47),
    Vector("C03", 0x001, "S", 1, bytes.fromhex("00"), 0x7C2C, 6, 58),
    Vector("C04", 0x123, "S", 2, bytes.fromhex("1122"), 0x04B7, 2, 62),
    Vector("C05", 0x100, "S", 2, bytes.fromhex("1133"), 0x198F, 2, 62),
    Vector("C06", 0x020, "S", 0, b"", 0x3667, 3, 47),
    Vector("C07", 0x555, "S", 8, bytes.fromhex("5555555555555555"), 0x1B04, 1, 109),
    Vector("C08", 0x2AA, "S", 8, bytes.fromhex("AAAAAAAAAAAAAAAA"), 0x43D6, 0, 108),
    Vector("C09", 0x000, "S", 8, bytes.fromhex("0000000000000000"), 0x145B, 16, 124),
    Vector("C10", 0x7FF, "S", 8, bytes.fromhex("FFFFFFFFFFFFFFFF"), 0x4C89, 15, 123),
    Vector("C11", 0x078, "S", 8, bytes.fromhex("3C3C3C3C3C3C3C3C"), 0x1921, 20, 128),
    Vector("C12", 0x048, "S", 1, bytes.fromhex("61"), 0x61E9, 2, 54),
    Vector("C13", 0x7DF, "S", 8, bytes.fromhex("02010D0000000000"), 0x4865, 12, 120),
    Vector("C14", 0x014, "S", 1, bytes.fromhex("01"), 0x7753, 3, 55),
    Vector("C15", 0x3C7, "S", 4, bytes.fromhex("DEADBEEF"), 0x5737, 2, 78),
    Vector("C16", 0x080, "S", 5, bytes.fromhex("0102030405"), 0x3F88, 8, 92),
    Vector("C17", 0x123, "SR", 0, b"", 0x1B9D, 1, 45),
    Vector("C18", 0x123, "SR", 8, b"", 0x6F9A, 1, 45),
    Vector("C19", 0x7F0, "SR", 4, b"", 0x79F6, 2, 46),
    Vector("C20", 0x12345678, "ER", 0, b"", 0x1F52, 2, 66),
    Vector("C21", 0x1ABCDEF0, "ER", 8, b"", 0x34AD, 1, 65),
    Vector("C22", 0x00000000, "E", 0, b"", 0x4610, 7, 71),
    Vector("C23", 0x1FFFFFFF, "E", 0, b"", 0x1C88, 7, 71),
    Vector("C24", 0x00000100, "E", 2, bytes.fromhex("1133"), 0x5D67, 5, 85),
    Vector("C25", 0x12345678, "E", 8, bytes.fromhex("1122334455667788"), 0x04C2, 3, 131),
    Vector("C26", 0x18DAF110, "E", 3, bytes.fromhex("021003"), 0x1BFE, 5, 93),
    Vector("C27", 0x15555555, "E", 8, bytes.fromhex("5555555555555555"), 0x4F1C, 0, 128),
    Vector("C28", 0x0AAAAAAA, "E", 1, bytes.fromhex("AA"), 0x6392, 1, 73),
    Vector("C29", 0x0CF00400, "E", 8, bytes.fromhex("F07D82A514000000"), 0x6A44, 11, 139),
    Vector("C30", 0x048C0000, "E", 0, b"", 0x5E37, 5, 69),
    Vector("C31", 0x123, "S", 9, bytes.fromhex("1122334455667788"), 0x6969, 0, 108),
    Vector("C32", 0x123, "S", 15, bytes.fromhex("1122334455667788"), 0x5734, 0, 108),
]

FD = [
    Vector("D01", 0x123, "S", 0, b"", 0x0515A, 1, 60, True, "0011", 0, 0x012B7),
    Vector("D02", 0x123, "SB", 0, b"", 0x1ED12, 0, 59, True, "0000", 32, 0x0C993),
    Vector("D03", 0x123, "SBI", 1, bytes.fromhex("11"), 0x04A55, 0, 67, True, "0000", 40, 0x11E8A),
    Vector(
        "D04", 0x7FF, "S", 8, bytes.fromhex("1122334455667788"), 0x180E0, 3, 126, True, "0101", 0, 0x0CD46
    ),
    Vector(
        "D05", 0x000, "S", 8, bytes.fromhex("0000000000000000"), 0x11F11, 15, 138, True, "1001", 0, 0x1FEEF
    ),
    Vector("D06", 0x456, "SB", 9, counted(12), 0x0150C, 11, 166, True, "0101", 139, 0x08787),
    Vector("D07", 0x321, "SB", 10, counted(16), 0x1DC82, 13, 200, True, "1111", 173, 0x090DA),
    Vector("D08", 0x321, "SB", 11, counted(20), 0x0F4AE9, 15, 239, True, "1001", 212, 0x08F312),
    Vector("D09", 0x0F0, "S", 12, b"\x00" * 24, 0x058DBC, 39, 295, True, "1001", 0, 0x031E00),
    Vector("D10", 0x2AB, "SB", 13, b"\xff" * 32, 0x047BE5, 51, 371, True, "0101", 344, 0x141751),
    Vector("D11", 0x555, "SB", 14, b"\x55" * 48, 0x1493AC, 0, 448, True, "0000", 421, 0x0EDBE2),
    Vector("D12", 0x100, "SB", 15, counted(64), 0x1AA9B8, 27, 603, True, "0101", 574, 0x127645),
    Vector("D13", 0x000, "SB", 15, b"\x00" * 64, 0x17B97B, 104, 680, True, "0000", 651, 0x1F11FB),
    Vector("D14", 0x12345678, "E", 2, bytes.fromhex("AABB"), 0x0169F, 1, 95, True, "0011", 0, 0x1EBB6),
    Vector("D15", 0x1FFFFFFF, "EB", 10, b"\xff" * 16, 0x0CE6B, 31, 237, True, "1001", 185, 0x061E2),
    Vector("D16", 0x18FF0102, "EBI", 15, counted(64), 0x0B3276, 30, 625, True, "1010", 575, 0x0D850A),
]

VECTORS = CLASSIC + FD

# the full bit streams, ACK slot dominant
STREAMS = {
    "C01": "00000100000100000100000100000100000100001011111111",
    "C04": "00010010001100000110000100010010001000001100101101111011111111",
    "C17": "000100100011100000100011011100111011011111111",
    "C20": "010010001101110001010110011110001000001000111110010100101011111111",
    "D01": "000100100011001000001001001100010110001101011101001011111111",
    "D03": "0001001000110010110001000100010000010010101010001011010111011111111",
    "D14": (
        "01001000110111000101011001111000010000011010101010101110110001100000110110010011111011011111111"
    ),
}

# the longest stuffed frames that a search found (section 2): identifier, extended, data, bits
LONGEST = [
    (0x7C0, False, bytes.fromhex("3C20F0F0F0F0F0F0"), 129),
    (0x10031934, True, b"\x3c" * 8, 151),
]

# section 9: bits of a frame and its intermission; frames/s by bit rate in kbit/s, column by column
BEST_BITS = {"SFF0": 48, "SFF8": 111, "EFF8": 131}
WORST_BITS = {"SFF8": 135, "EFF8": 160}
FRAME_RATES = {
    1000: (20833, 9009, 7407, 7633, 6250),
    800: (16666, 7207, 5925, 6106, 5000),
    500: (10416, 4504, 3703, 3816, 3125),
    250: (5208, 2252, 1851, 1908, 1562),
    125: (2604, 1126, 925, 954, 781),
    100: (2083, 900, 740, 763, 625),
    50: (1041, 450, 370, 381, 312),
    20: (416, 180, 148, 152, 125),
    10: (208, 90, 74, 76, 62),
}
