"""The MCP2515's registers under their data-sheet names: all 128 addresses, every bit, every instruction.

Nothing here behaves; controller.py is the model, and drivers take their constants from here.

Source: Microchip DS20001801 (MCP2515 data sheet), from which this file has
- chapter 3: TXBnCTRL, TXRTSCTRL, the transmit buffers (registers 3-1 to 3-8);
- chapter 4: RXBnCTRL, BFPCTRL, the receive buffers, filters and masks (registers 4-1 to 4-17), the codes of FILHIT;
- chapter 5: CNF1 to CNF3 (registers 5-1 to 5-3); 6: TEC, REC, EFLG; 7: CANINTE, CANINTF, the codes of ICOD;
- chapter 10: CANCTRL, CANSTAT, the modes; 11: the map, values after reset, which registers take BIT MODIFY;
- chapter 12: the instructions of the SPI interface, and what READ STATUS and RX STATUS answer.
RXM = 01 and 10 (reserved in revision J) are those of revisions E to G. Addresses and bits were held against Linux'
drivers/net/can/spi/mcp251x.c, whose CNF3_SOF and CNF3_WAKFIL are not the data sheet's; nothing was copied.
"""

from __future__ import annotations

from canwire.chips.registers import Access, Bit, Register, RegisterFile

NONE, READ, BOTH = Access.NONE, Access.READ, Access.READ_WRITE

ADDRESSES = 128
# addresses
RXF = (0x00, 0x04, 0x08, 0x10, 0x14, 0x18)
"""Where the six filters begin: SIDH, SIDL, EID8, EID0."""
RXM = (0x20, 0x24)
BFPCTRL, TXRTSCTRL, CANSTAT, CANCTRL = 0x0C, 0x0D, 0x0E, 0x0F
TEC, REC = 0x1C, 0x1D
CNF3, CNF2, CNF1, CANINTE, CANINTF, EFLG = range(0x28, 0x2E)
TXBCTRL = (0x30, 0x40, 0x50)
RXBCTRL = (0x60, 0x70)
# within a buffer, from its control register
SIDH, SIDL, EID8, EID0, DLC, DATA = range(1, 7)
BUFFER_SIZE = 13
"""Bytes of a buffer without its control register."""
TX_BUFFERS, RX_BUFFERS = 3, 2

# TXBnCTRL
TX_ABTF, TX_MLOA, TX_TXERR, TX_TXREQ, TX_TXP = 0x40, 0x20, 0x10, 0x08, 0x03
# RXBnCTRL
RX_RXM_SHIFT, RX_RXRTR, RX_BUKT, RX_BUKT1, RX_FILHIT0, RX_FILHIT = 5, 0x08, 0x04, 0x02, 0x01, 0x07
RXM_FILTERS, RXM_STANDARD, RXM_EXTENDED, RXM_ALL = range(4)
# identifiers and lengths in buffers, filters and masks
SIDL_SRR, SIDL_EXIDE, DLC_RTR, DLC_MASK = 0x10, 0x08, 0x40, 0x0F
# CANCTRL
REQOP_SHIFT, CTRL_ABAT, CTRL_OSM, CTRL_CLKEN, CTRL_CLKPRE = 5, 0x10, 0x08, 0x04, 0x03
NORMAL, SLEEP, LOOP_BACK, LISTEN_ONLY, CONFIGURATION = range(5)
"""REQOP and OPMOD."""
# CANINTE and CANINTF
INT_RX0, INT_RX1, INT_TX0, INT_TX1, INT_TX2, INT_ERR, INT_WAK, INT_MERR = (1 << bit for bit in range(8))
INT_RX, INT_TX = (INT_RX0, INT_RX1), (INT_TX0, INT_TX1, INT_TX2)
# EFLG
EFLG_EWARN, EFLG_RXWAR, EFLG_TXWAR, EFLG_RXEP, EFLG_TXEP, EFLG_TXBO, EFLG_RX0OVR, EFLG_RX1OVR = (
    1 << bit for bit in range(8)
)
EFLG_OVERFLOWS = EFLG_RX0OVR | EFLG_RX1OVR
# CNF1 to CNF3
CNF1_SJW_SHIFT, CNF1_BRP = 6, 0x3F
CNF2_BTLMODE, CNF2_SAM, CNF2_PHSEG1_SHIFT, CNF2_PRSEG = 0x80, 0x40, 3, 0x07
CNF3_SOF, CNF3_WAKFIL, CNF3_PHSEG2 = 0x80, 0x40, 0x07
SHORTEST_PHASE2 = 2  # the information processing time
# BFPCTRL and TXRTSCTRL, of pin 0; that of pin n is n bits further left
BFP_BFM, BFP_BFE, BFP_BFS, RTS_RTSM, RTS_RTS = 0x01, 0x04, 0x10, 0x01, 0x08
# instructions
(
    DO_WRITE, DO_READ, DO_BIT_MODIFY, DO_LOAD_TX, DO_RTS, DO_READ_RX, DO_READ_STATUS, DO_RX_STATUS, DO_RESET,
) = (0x02, 0x03, 0x05, 0x40, 0x80, 0x90, 0xA0, 0xB0, 0xC0)  # fmt: skip

ICOD = (
    (0, "none"), (1, "ERR"), (2, "WAK"), (3, "TX0"), (4, "TX1"), (5, "TX2"), (6, "RX0"), (7, "RX1"),
)  # fmt: skip
ICOD_ORDER = (INT_ERR, INT_WAK, INT_TX0, INT_TX1, INT_TX2, INT_RX0, INT_RX1)
"""What ICOD tells of first; MERR is not among them."""
MODES = ((0, "normal"), (1, "sleep"), (2, "loop-back"), (3, "listen-only"), (4, "configuration"))
_RXM = ((0, "filters"), (1, "standard"), (2, "extended"), (3, "all"))
_FILTERS = tuple((number, f"RXF{number}") for number in range(6))


def _flags(names: str) -> tuple[Bit, ...]:
    """Single bits from the most significant down; "-" is not implemented."""
    listed = names.split()
    return tuple(Bit(name, len(listed) - 1 - place) for place, name in enumerate(listed) if name != "-")


def _plus_one(name: str, position: int, width: int) -> Bit:
    return Bit(name, position, width, tuple((value, f"{value + 1}") for value in range(1 << width)))


_TXCTRL = (*_flags("- ABTF MLOA TXERR TXREQ - - -"), Bit("TXP", 0, 2))
_RX0CTRL = (Bit("RXM", 5, 2, _RXM), *_flags("- - - - RXRTR BUKT BUKT1 -"), Bit("FILHIT", 0, 1, _FILTERS[:2]))
_RX1CTRL = (Bit("RXM", 5, 2, _RXM), Bit("RXRTR", 3), Bit("FILHIT", 0, 3, _FILTERS))
_ID_LOW = (Bit("SID2-0", 5, 3), Bit("EXIDE", 3), Bit("EID17-16", 0, 2))
_MASK_LOW = (Bit("SID2-0", 5, 3), Bit("EID17-16", 0, 2))
_RX_ID_LOW = (Bit("SID2-0", 5, 3), Bit("SRR", 4), Bit("IDE", 3), Bit("EID17-16", 0, 2))
_TX_LENGTH = (Bit("RTR", 6), Bit("DLC", 0, 4))
_RX_LENGTH = (Bit("RTR", 6), Bit("RB1", 5), Bit("RB0", 4), Bit("DLC", 0, 4))
_CTRL = (Bit("REQOP", 5, 3, MODES), Bit("ABAT", 4), Bit("OSM", 3), Bit("CLKEN", 2),
         Bit("CLKPRE", 0, 2, ((0, "1"), (1, "2"), (2, "4"), (3, "8"))))  # fmt: skip
_STAT = (Bit("OPMOD", 5, 3, MODES), Bit("ICOD", 1, 3, ICOD))
_SOURCES = "MERR WAK ERR TX2 TX1 TX0 RX1 RX0"
_UNKNOWN, _CLEAR = "xxxxxxxx", "00000000"


def _pattern(name: str, address: int, title: str, low: tuple[Bit, ...]) -> list[Register]:
    """The four bytes of a filter or a mask: written in configuration mode, and read as 0 in every other."""
    rows = (("SIDH", ()), ("SIDL", low), ("EID8", ()), ("EID0", ()))
    return [
        Register(f"{name}{part}", address + place, NONE, BOTH, title, bits, _unknown(bits))
        for place, (part, bits) in enumerate(rows)
    ]


def _unknown(bits: tuple[Bit, ...]) -> str:
    """The value after power-up: x for each bit that the register has, 0 for the others."""
    there = sum(bit.mask for bit in bits) if bits else 0xFF
    return "".join("x" if there >> place & 1 else "0" for place in range(7, -1, -1))


def _buffer(
    name: str, control: int, access: Access, low: tuple[Bit, ...], length: tuple[Bit, ...]
) -> list[Register]:
    """The registers after a control register: identifier, length and data."""
    rows = [("SIDH", ()), ("SIDL", low), ("EID8", ()), ("EID0", ()), ("DLC", length)]
    rows += [(f"D{place}", ()) for place in range(8)]
    return [
        Register(f"{name}{part}", control + place, access, access, f"{name} {part}", bits, _unknown(bits))
        for place, (part, bits) in enumerate(rows, 1)
    ]


def _transmit(number: int) -> list[Register]:
    at, name = TXBCTRL[number], f"TXB{number}"
    control = Register(
        f"{name}CTRL", at, BOTH, BOTH, f"transmit buffer {number} control", _TXCTRL, _CLEAR, _CLEAR
    )
    return [control, *_buffer(name, at, BOTH, _ID_LOW, _TX_LENGTH)]


def _receive(number: int, bits: tuple[Bit, ...]) -> list[Register]:
    at, name = RXBCTRL[number], f"RXB{number}"
    control = Register(
        f"{name}CTRL", at, BOTH, BOTH, f"receive buffer {number} control", bits, _CLEAR, _CLEAR
    )
    return [control, *_buffer(name, at, READ, _RX_ID_LOW, _RX_LENGTH)]


def _always(
    name: str, address: int, access: Access, title: str, bits: tuple[Bit, ...], value: int = 0
) -> Register:
    after = f"{value:08b}"
    return Register(name, address, access, access, title, bits, after, after)


def _at_rest(name: str, address: int, title: str, bits: tuple[Bit, ...]) -> Register:
    """A register that every mode reads, and only configuration mode writes."""
    return Register(name, address, READ, BOTH, title, bits, _CLEAR, _CLEAR)


MAP = RegisterFile([
    *[row for n in (0, 1, 2) for row in _pattern(f"RXF{n}", RXF[n], f"acceptance filter {n}", _ID_LOW)],
    _always("BFPCTRL", BFPCTRL, BOTH, "RXnBF pins", _flags("- - B1BFS B0BFS B1BFE B0BFE B1BFM B0BFM")),
    Register("TXRTSCTRL", TXRTSCTRL, READ, BOTH, "TXnRTS pins", _flags("- - B2RTS B1RTS B0RTS B2RTSM B1RTSM B0RTSM"),
             "00xxx000", "00xxx000"),
    _always("CANSTAT", CANSTAT, READ, "status", _STAT, 0x80),
    _always("CANCTRL", CANCTRL, BOTH, "control", _CTRL, 0x87),
    *[row for n in (3, 4, 5) for row in _pattern(f"RXF{n}", RXF[n], f"acceptance filter {n}", _ID_LOW)],
    _always("TEC", TEC, READ, "transmit error counter", ()),
    _always("REC", REC, READ, "receive error counter", ()),
    *[row for n in (0, 1) for row in _pattern(f"RXM{n}", RXM[n], f"acceptance mask {n}, 1 compares", _MASK_LOW)],
    _at_rest("CNF3", CNF3, "bit timing 3", (Bit("SOF", 7), Bit("WAKFIL", 6), _plus_one("PHSEG2", 0, 3))),
    _at_rest("CNF2", CNF2, "bit timing 2", (Bit("BTLMODE", 7), Bit("SAM", 6, 1, ((0, "1"), (1, "3"))),
                                            _plus_one("PHSEG1", 3, 3), _plus_one("PRSEG", 0, 3))),
    _at_rest("CNF1", CNF1, "bit timing 1", (_plus_one("SJW", 6, 2), _plus_one("BRP", 0, 6))),
    _always("CANINTE", CANINTE, BOTH, "interrupt enable", _flags(_SOURCES.replace(" ", "IE ") + "IE")),
    _always("CANINTF", CANINTF, BOTH, "interrupt flags", _flags("MERRF WAKIF ERRIF TX2IF TX1IF TX0IF RX1IF RX0IF")),
    _always("EFLG", EFLG, BOTH, "error flags", _flags("RX1OVR RX0OVR TXBO TXEP RXEP TXWAR RXWAR EWARN")),
    *[row for n in range(TX_BUFFERS) for row in _transmit(n)],
    *_receive(0, _RX0CTRL),
    *_receive(1, _RX1CTRL),
])  # fmt: skip
"""Every register once; CANSTAT and CANCTRL are at all eight addresses that end in E and F."""

_READ_ONLY = {  # bits that a write leaves alone, in registers that can be written
    "TXRTSCTRL": 0x38,
    "EFLG": 0x3F,
    **{f"TXB{n}CTRL": TX_ABTF | TX_MLOA | TX_TXERR for n in range(TX_BUFFERS)},
    "RXB0CTRL": RX_RXRTR | RX_BUKT1 | RX_FILHIT0,
    "RXB1CTRL": RX_RXRTR | RX_FILHIT,
}
WRITABLE = {
    register.address: (sum(bit.mask for bit in register.bits) if register.bits else 0xFF)
    & ~_READ_ONLY.get(register.name, 0)
    for register in MAP.registers
    if register.reset & Access.WRITE
}
"""By address: the bits that a write changes, where the mode lets it."""
MODIFIABLE = frozenset({
    BFPCTRL, TXRTSCTRL, CANCTRL, CNF1, CNF2, CNF3, CANINTE, CANINTF, EFLG, *TXBCTRL, *RXBCTRL,
})  # fmt: skip
"""Registers that BIT MODIFY changes bit by bit; elsewhere its mask counts as FFh (data sheet 12.10)."""
AT_REST = frozenset(register.address for register in MAP.registers if not register.operating & Access.WRITE
                    and register.reset & Access.WRITE)  # fmt: skip
"""Registers that are written in configuration mode only."""
HIDDEN = frozenset(register.address for register in MAP.registers if not register.operating)
"""Those of them that every other mode reads as 0: filters and masks."""


def canonical(address: int) -> int:
    """The address of a register in MAP: CANSTAT and CANCTRL have eight each; addresses wrap beyond 7Fh."""
    address &= ADDRESSES - 1
    return address & 0x0F if address & 0x0F >= CANSTAT else address
