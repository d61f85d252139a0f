"""Register vectors of the SJA1000, copied from reference/sja1000.md section 12.

A program is a row of steps: `HW` hardware reset (Intel), `P` the same and W31=0x80, `Wn=v` write, `Rn=v` or `Rn&m=v`
read and compare, `bits n` so many recessive bits pass. Those that need other nodes stand in
tests/chips/sja1000/test_bus.py under their numbers. There: T1.. data sheet tables, 6.x its sections, OC freecores/can.
"""

from __future__ import annotations

# number, program
PROGRAMS = [
    ("R01", "HW R0&0xA1=0x21 R1=0xFF R2=0x0C R3=0xE0 R31=0x00"),
    ("R02", "HW R10=0xFF R11=0xFF R12=0xFF R13=0xFF R14=0xFF R15=0xFF R16=0xFF R17=0xFF R18=0xFF R19=0xFF"
            " R30=0xFF R34=0x0C R2=0x0C"),
    ("R03", "HW W4=0xA5 W5=0x0F R4=0xA5 W0=0x00 R4=0xFF R5=0xFF R6=0xFF R7=0xFF R8=0xFF W4=0x11 W0=0x01 R4=0xA5"),
    ("R04", "HW W0=0xFF R0&0x7F=0x7F"),
    ("R05", "HW W0=0x00 bits 11 W10=0x24 W11=0x62 R10=0x24 R11=0x62 W0=0x01 R10=0xFF"),
    ("R06", "P R0=0x01 R1=0x00 R2=0x3C R3=0x00 R11=0x00 R12=0x00 R13=0x60 R14=0x00 R15=0x00 R29=0x00 R30=0x00"
            " R31=0x80"),
    ("R07", "P R5=0 R10=0 R24=0 R25=0 R26=0 R27=0 R28=0 R112=0 R119=0 R127=0 R130=0x3C"),
    ("R08", "P W16=1 W17=2 W18=3 W19=4 W20=5 W21=6 W22=7 W23=8 R16=1 R17=2 R18=3 R19=4 R20=5 R21=6 R22=7 R23=8"
            " W0=0 R16=0 R19=0 R23=0 W0=1 R16=1 R17=2 R18=3 R19=4 R20=5 R21=6 R22=7 R23=8"),
    ("R09", "P W30=0xFF R30=0x3F"),
    ("R10", "P W6=0x01 W7=0x1C W0=0 W6=0x55 R6=0x01 R7=0x1C"),
    ("R11", "P W31=0xFF R31=0xEF"),
    ("R12", "P W31=0x88 W0=0 W31=0x07 R31=0x8F"),
    ("R13", "P W0=0x1F R0=0x0F"),
    ("R14", "P W0=0x08 R0=0x08 W0=0x0E R0=0x08"),
    ("R15", "P W13=0x70 W0=0 bits 11 R2=0x0C W0=1 R2=0x3C R29=0 R13=0x70"),
    ("R16", "P W0=0 R2=0x3C bits 10 R2=0x3C bits 1 R2=0x0C"),
    ("R17", "P W13=0x20 W0=0 W13=0x40 R13=0x20"),
    ("R18", "P W4=0x24 W15=0x80 R2&0x40=0 R3=0 W0=0 R2&0x40=0x40 R3=0x24 R3=0x00"),
    ("R19", "P W4=0x04 W15=0xFF W0=0 R0&1=1 R2&0x80=0x80 R15=0x7F R14=0x00 R3=0x04"),
    ("R20", "P W4=0x04 W15=0xFF W0=0 W14=0x10 R14=0x00"),
    ("R21", "P W4=0x04 W15=0xFF W0=0 R3=0x04 W0=0 bits 22 R15=0x7D bits 1364 R15=1 R2&0x80=0x80 R3=0 bits 22 R2=0x0C"
            " R15=0 R14=0 R3=0x04"),
    ("R22", "P W4=0x04 W15=0xFF W0=0 R2&0x80=0x80 W15=0x00 R2&0x80=0 W0=0 R2=0x3C bits 11 R2=0x0C"),
    ("R23", "P W4=0x04 W15=0xFF W0=0 W0=0 bits 110 R15=0x75 W0=1 R2&0x80=0x80 R15=0x75 bits 110 R15=0x75"
            " R2&0x80=0x80"),
]  # fmt: skip

# number, transmit buffer from register 16 on, identifier, extended, remote, data, receive window
FRAMES = [
    ("R24", "02 24 60 11 22", 0x123, False, False, "11 22", "02 24 60 11 22"),
    ("R25", "88 91 A2 B3 C0 01 02 03 04 05 06 07 08", 0x12345678, True, False, "01 02 03 04 05 06 07 08",
     "88 91 A2 B3 C0 01 02 03 04 05 06 07 08"),
    ("R25", "C8 91 A2 B3 C0", 0x12345678, True, True, "", "C8 91 A2 B3 C4"),
]  # fmt: skip

# R26: BasicCAN, from register 10 on and from 20 on: identifier, remote, data
BASIC_FRAMES = [("24 62 11 22", 0x123, False, "11 22"), ("24 72", 0x123, True, "")]

# R33: extended, data bytes, received, kept
CAPACITIES = [(False, 0, 22, 21), (True, 0, 13, 12), (True, 8, 5, 4)]

# section 8: data bytes 0 to 8
BASIC_CAPACITY = (32, 21, 16, 12, 10, 9, 8, 7, 6)
STANDARD_CAPACITY = (21, 16, 12, 10, 9, 8, 7, 6, 5)
EXTENDED_CAPACITY = (12, 10, 9, 8, 7, 6, 5, 5, 4)

# R40: the loser's and the winner's (frame information, identifier as in registers 17 ff.), ALC
LOSSES = [
    ("EFF base 0x100 against SFF data 0x100", ("80", "20 00 00 00"), ("00", "20 00"), 11),
    ("EFF data against SFF RTR, same base", ("80", "20 00 00 00"), ("40", "20 00"), 12),
    ("EFF RTR against EFF data", ("C0", "20 00 00 08"), ("80", "20 00 00 08"), 31),
    ("SFF RTR against SFF data", ("40", "20 00"), ("00", "20 00"), 11),
]

# R45: register, I/O port of an INduCAN104 with base 0x280 (INduCAN104 manual)
PORTS = [(0, 0x280), (31, 0x29F), (32, 0x680), (64, 0xA80), (96, 0xE80), (127, 0xE9F)]
