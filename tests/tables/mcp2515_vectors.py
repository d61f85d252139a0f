"""What the MCP2515's data sheet (Microchip DS20001801) says in tables, figures and sentences that are tables.

Numbers are those of its revision J. Hexadecimal strings are bytes in the order of addresses.
"""

# Table 11-2 and the register descriptions: address, name, value after power-up, bits that a write changes
REGISTERS = [
    (0x0C, "BFPCTRL", 0x00, 0x3F),
    (0x0F, "CANCTRL", 0x87, 0xFF),
    (0x28, "CNF3", 0x00, 0xC7),
    (0x29, "CNF2", 0x00, 0xFF),
    (0x2A, "CNF1", 0x00, 0xFF),
    (0x2B, "CANINTE", 0x00, 0xFF),
    (0x2C, "CANINTF", 0x00, 0xFF),
    (0x2D, "EFLG", 0x00, 0xC0),
    (0x30, "TXB0CTRL", 0x00, 0x0B),
    (0x40, "TXB1CTRL", 0x00, 0x0B),
    (0x50, "TXB2CTRL", 0x00, 0x0B),
    (0x60, "RXB0CTRL", 0x00, 0x64),
    (0x70, "RXB1CTRL", 0x00, 0x60),
    (0x00, "RXF0SIDH", 0x00, 0xFF),
    (0x01, "RXF0SIDL", 0x00, 0xEB),
    (0x1B, "RXF5EID0", 0x00, 0xFF),
    (0x21, "RXM0SIDL", 0x00, 0xE3),
    (0x35, "TXB0DLC", 0x00, 0x4F),
    (0x52, "TXB2SIDL", 0x00, 0xEB),
    (0x5D, "TXB2D7", 0x00, 0xFF),
]

# Registers that are not modified outside configuration mode (10.1), by their first and last address
AT_REST = [(0x00, 0x0B), (0x0D, 0x0D), (0x10, 0x1B), (0x20, 0x27), (0x28, 0x2A)]

# Table 7-1: enabled and set flags, ICOD
ICOD = [
    (0x00, 0), (0x20, 1), (0x40, 2), (0x04, 3), (0x08, 4), (0x10, 5), (0x01, 6), (0x02, 7),
    (0x60, 1), (0x44, 2), (0x1C, 3), (0x18, 4), (0x13, 5), (0x03, 6), (0x80, 0), (0xFF, 1), (0x82, 7),
]  # fmt: skip

# Figure 12-8: CANINTF, TXREQ of buffers 0 to 2, what READ STATUS answers
READ_STATUS = [
    (0x01, (0, 0, 0), 0x01), (0x02, (0, 0, 0), 0x02), (0x00, (1, 0, 0), 0x04), (0x04, (0, 0, 0), 0x08),
    (0x00, (0, 1, 0), 0x10), (0x08, (0, 0, 0), 0x20), (0x00, (0, 0, 1), 0x40), (0x10, (0, 0, 0), 0x80),
    (0x1F, (1, 1, 1), 0xFF), (0xE0, (0, 0, 0), 0x00),
]  # fmt: skip

# Chapter 5, worked by hand: CNF1 to CNF3 at 16 MHz; bit/s, quanta, quanta up to the sample point, SJW
CNF = [
    ("00", "90", "02", 1_000_000, 8, 5, 1),
    ("00", "D0", "82", 1_000_000, 8, 5, 1),  # SAM and SOF besides
    ("00", "F0", "86", 500_000, 16, 9, 1),
    ("41", "F1", "85", 250_000, 16, 10, 2),
    ("03", "F0", "86", 125_000, 16, 9, 1),
    ("00", "AC", "03", 500_000, 16, 12, 1),
    ("3F", "BF", "07", 5_000, 25, 17, 1),
    ("C3", "92", "03", 181_818, 11, 7, 4),
    ("00", "12", "07", 800_000, 10, 7, 1),  # BTLMODE = 0: PHSEG2 is as long as PHSEG1
    ("00", "01", "00", 1_333_333, 6, 4, 1),  # ... but two quanta at least
]

# 4.5 and figure 4-4: mask, filter (four bytes each), RXM, identifier (8 digits: 29 bits), remote, data, accepted
FILTERS = [
    ("00000000", "00000000", 0, "123", False, "", True),
    ("00000000", "00000000", 0, "12345678", False, "", False),  # EXIDE = 0: standard frames
    ("00000000", "00080000", 0, "12345678", False, "", True),
    ("00000000", "00080000", 0, "123", False, "", False),
    ("FFE00000", "24600000", 0, "123", False, "", True),
    ("FFE00000", "24600000", 0, "122", False, "", False),
    ("FFE00000", "24600000", 0, "123", True, "", True),
    ("FF000000", "24000000", 0, "127", False, "", True),
    ("FF000000", "24000000", 0, "128", False, "", False),
    ("FFE0FF00", "24601100", 0, "123", False, "11", True),  # data byte 0 by EID15 to 8
    ("FFE0FF00", "24601100", 0, "123", False, "12", False),
    ("FFE0FFFF", "24601122", 0, "123", False, "1122", True),  # data byte 1 by EID7 to 0
    ("FFE0FFFF", "24601122", 0, "123", False, "1123", False),
    ("FFE0FFFF", "24601122", 0, "123", False, "112233", True),
    ("FFE0FFFF", "24601122", 0, "123", False, "11", True),
    ("FFE0FFFF", "24601122", 0, "123", False, "", True),
    ("FFE0FFFF", "24601122", 0, "123", True, "", True),
    ("FFE3FFFF", "24631122", 0, "123", False, "1122", True),  # EID17 and 16 have no part in standard frames
    ("FFE3FFFF", "91AB5678", 0, "12375678", False, "", True),
    ("FFE3FFFF", "91A85678", 0, "12345678", False, "", True),
    ("FFE3FFFF", "91A85678", 0, "12345679", False, "", False),
    ("FFE3FFFE", "91A85678", 0, "12345679", False, "99", True),
    ("FFE00000", "91A85678", 0, "1234FFFF", False, "", True),
    ("FFE0FFFF", "24601122", 1, "123", False, "9999", True),  # RXM = 01: standard frames, data apart
    ("FFE0FFFF", "24681122", 1, "123", False, "", False),
    ("00000000", "00080000", 1, "12345678", False, "", False),
    ("00000000", "00080000", 2, "12345678", False, "", True),  # RXM = 10: extended frames
    ("00000000", "00000000", 2, "123", False, "", False),
    ("FFE3FFFF", "FFE80000", 3, "123", False, "", True),  # RXM = 11: everything
    ("FFE3FFFF", "FFE80000", 3, "12345678", True, "", True),
]

# 3.2: TXP of buffers 0 to 2, the order in which they are sent
ORDER = [
    ((0, 0, 0), (2, 1, 0)), ((3, 3, 3), (2, 1, 0)), ((3, 0, 0), (0, 2, 1)), ((0, 3, 0), (1, 2, 0)),
    ((1, 2, 3), (2, 1, 0)), ((3, 2, 1), (0, 1, 2)), ((2, 1, 2), (2, 0, 1)), ((1, 1, 0), (1, 0, 2)),
    ((2, 3, 1), (1, 0, 2)),
]  # fmt: skip

# Figure 12-9: CANINTF, RXB0CTRL, RXB0SIDL, RXB1CTRL, RXB1SIDL, what RX STATUS answers
RX_STATUS = [
    (0x00, 0x09, 0x08, 0x0A, 0x08, 0x00),
    (0x01, 0x00, 0x00, 0x00, 0x00, 0x40),
    (0x01, 0x01, 0x00, 0x00, 0x00, 0x41),
    (0x01, 0x08, 0x10, 0x00, 0x00, 0x48),
    (0x01, 0x01, 0x08, 0x00, 0x00, 0x51),
    (0x01, 0x09, 0x08, 0x00, 0x00, 0x59),
    (0x02, 0x00, 0x00, 0x02, 0x00, 0x82),
    (0x02, 0x00, 0x00, 0x05, 0x08, 0x95),
    (0x02, 0x00, 0x00, 0x00, 0x00, 0x86),  # RXF0, rolled over
    (0x02, 0x00, 0x00, 0x09, 0x00, 0x8F),  # RXF1, rolled over, a remote frame
    (0x03, 0x01, 0x00, 0x04, 0x08, 0xC1),  # both: bits 4 to 0 are those of RXB0
]

# 6.7 and register 6-3: TEC, REC, EFLG without overflows
EFLG = [
    (0, 0, 0x00), (95, 95, 0x00), (96, 0, 0x05), (0, 96, 0x03), (127, 127, 0x07), (128, 0, 0x15), (0, 128, 0x0B),
    (128, 128, 0x1F), (255, 0, 0x15), (256, 0, 0x35),
]  # fmt: skip
