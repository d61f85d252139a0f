"""The SJA1000's registers under their data-sheet names: both maps, every bit, every code.

Nothing here behaves; controller.py is the model, and drivers take their constants from here.
Source: SJA1000 data sheet, 2000 Jan 04, tables 1 to 49; reference/sja1000.md sections 1 to 8.
"""

from __future__ import annotations

from canwire.chips.registers import Access, Bit, Register, RegisterFile

NONE, READ, WRITE, BOTH = Access.NONE, Access.READ, Access.WRITE, Access.READ_WRITE

# addresses, PeliCAN
MOD, CMR, SR, IR, IER, BTR0, BTR1, OCR, TEST = 0, 1, 2, 3, 4, 6, 7, 8, 9
ALC, ECC, EWLR, RXERR, TXERR = 11, 12, 13, 14, 15
ACR0, ACR1, ACR2, ACR3, AMR0, AMR1, AMR2, AMR3 = range(16, 24)
TX_BUFFER = RX_WINDOW = 16  # to 28: frame information, identifier, data
WINDOW_SIZE = 13
RMC, RBSA, CDR = 29, 30, 31
RX_FIFO, RX_FIFO_SIZE = 32, 64
TX_RAM, FREE_RAM = 96, 109
PELICAN_ADDRESSES = 128

# addresses, BasicCAN
BASIC_CR, BASIC_CMR, BASIC_SR, BASIC_IR, BASIC_ACR, BASIC_AMR = range(6)
BASIC_BTR0, BASIC_BTR1, BASIC_OCR, BASIC_TEST = 6, 7, 8, 9
BASIC_TX_BUFFER, BASIC_RX_WINDOW, BASIC_WINDOW_SIZE = 10, 20, 10
BASIC_ADDRESSES = 32

# mode register
MOD_RM, MOD_LOM, MOD_STM, MOD_AFM, MOD_SM = 0x01, 0x02, 0x04, 0x08, 0x10
# BasicCAN control register
CR_RR, CR_RIE, CR_TIE, CR_EIE, CR_OIE = 0x01, 0x02, 0x04, 0x08, 0x10
# command register
CMR_TR, CMR_AT, CMR_RRB, CMR_CDO, CMR_SRR = 0x01, 0x02, 0x04, 0x08, 0x10
CMR_GTS = 0x10  # BasicCAN: go to sleep
# status register
SR_RBS, SR_DOS, SR_TBS, SR_TCS, SR_RS, SR_TS, SR_ES, SR_BS = (1 << bit for bit in range(8))
# interrupt and interrupt enable register
IR_RI, IR_TI, IR_EI, IR_DOI, IR_WUI, IR_EPI, IR_ALI, IR_BEI = (1 << bit for bit in range(8))
IER_RIE, IER_TIE, IER_EIE, IER_DOIE, IER_WUIE, IER_EPIE, IER_ALIE, IER_BEIE = (1 << bit for bit in range(8))
BASIC_IR_ONES = 0xE0
# bus timing
BTR0_SJW_SHIFT, BTR0_BRP_MASK = 6, 0x3F
BTR1_SAM, BTR1_TSEG2_SHIFT, BTR1_TSEG1_MASK = 0x80, 4, 0x0F
# output control
OCR_OCTP1, OCR_OCTN1, OCR_OCPOL1, OCR_OCTP0, OCR_OCTN0, OCR_OCPOL0 = 0x80, 0x40, 0x20, 0x10, 0x08, 0x04
OCR_BIPHASE, OCR_TEST, OCR_NORMAL, OCR_CLOCK = range(4)
# clock divider
CDR_PELICAN, CDR_CBP, CDR_RXINTEN, CDR_CLOCK_OFF, CDR_DIVIDER_MASK = 0x80, 0x40, 0x20, 0x08, 0x07
CLOCK_DIVIDERS = (2, 4, 6, 8, 10, 12, 14, 1)
# frame information, first byte of a buffer
FI_FF, FI_RTR, FI_DLC_MASK = 0x80, 0x40, 0x0F
# error code capture
ECC_TYPE_MASK, ECC_BIT, ECC_FORM, ECC_STUFF, ECC_OTHER = 0xC0, 0x00, 0x40, 0x80, 0xC0
ECC_RX, ECC_SEGMENT_MASK = 0x20, 0x1F
ECC_TYPES = ((0, "bit error"), (1, "form error"), (2, "stuff error"), (3, "other error"))
ECC_SEGMENTS = (
    (0x03, "start of frame"), (0x02, "ID.28 to ID.21"), (0x06, "ID.20 to ID.18"), (0x04, "SRTR"), (0x05, "IDE"),
    (0x07, "ID.17 to ID.13"), (0x0F, "ID.12 to ID.5"), (0x0E, "ID.4 to ID.0"), (0x0C, "RTR"),
    (0x0D, "reserved bit 1"), (0x09, "reserved bit 0"), (0x0B, "data length code"), (0x0A, "data field"),
    (0x08, "CRC sequence"), (0x18, "CRC delimiter"), (0x19, "acknowledge slot"), (0x1B, "acknowledge delimiter"),
    (0x1A, "end of frame"), (0x12, "intermission"), (0x11, "active error flag"), (0x16, "passive error flag"),
    (0x13, "tolerate dominant bits"), (0x17, "error delimiter"), (0x1C, "overload flag"),
)  # fmt: skip
# arbitration lost capture: the bit that was lost, in the order of the frame
ALC_BITS = (
    *((bit, f"ID.{28 - bit}") for bit in range(11)),
    (11, "SRTR"),
    (12, "IDE"),
    *((bit, f"ID.{30 - bit}") for bit in range(13, 31)),
    (31, "RTR"),
)

_DRIVERS = ((0, "float"), (1, "pull-down"), (2, "pull-up"), (3, "push-pull"))
_OUTPUT_MODES = ((0, "bi-phase"), (1, "test"), (2, "normal"), (3, "clock"))
_CLOCK = tuple((code, f"fosc/{by}" if by > 1 else "fosc") for code, by in enumerate(CLOCK_DIVIDERS))


def _flags(names: str) -> tuple[Bit, ...]:
    """Single bits from the most significant down; "-" is a reserved one."""
    listed = names.split()
    return tuple(Bit(name, len(listed) - 1 - place) for place, name in enumerate(listed) if name != "-")


_STATUS = _flags("BS ES TS RS TCS TBS DOS RBS")
_BTR0 = (Bit("SJW", 6, 2, tuple((v, f"{v + 1}") for v in range(4))),
         Bit("BRP", 0, 6, tuple((v, f"{v + 1}") for v in range(64))))  # fmt: skip
_BTR1 = (Bit("SAM", 7, 1, ((0, "1"), (1, "3"))),
         Bit("TSEG2", 4, 3, tuple((v, f"{v + 1}") for v in range(8))),
         Bit("TSEG1", 0, 4, tuple((v, f"{v + 1}") for v in range(16))))  # fmt: skip
_OCR = (Bit("TX1", 6, 2, _DRIVERS), Bit("OCPOL1", 5),
        Bit("TX0", 3, 2, _DRIVERS), Bit("OCPOL0", 2),
        Bit("OCMODE", 0, 2, _OUTPUT_MODES))  # fmt: skip
_CDR = (Bit("CAN", 7, 1, ((0, "BasicCAN"), (1, "PeliCAN"))), Bit("CBP", 6), Bit("RXINTEN", 5), Bit("CLKOFF", 3),
        Bit("CD", 0, 3, _CLOCK))  # fmt: skip
_MOD = (
    Bit("SM", 4),
    Bit("AFM", 3, 1, ((0, "dual"), (1, "single"))),
    Bit("STM", 2),
    Bit("LOM", 1),
    Bit("RM", 0),
)
_ECC = (
    Bit("ERRC", 6, 2, ECC_TYPES),
    Bit("DIR", 5, 1, ((0, "TX"), (1, "RX"))),
    Bit("SEG", 0, 5, ECC_SEGMENTS),
)
_FI = (Bit("FF", 7, 1, ((0, "SFF"), (1, "EFF"))), Bit("RTR", 6), Bit("DLC", 0, 4))


def _row(first: int, count: int, name: str, operating: Access, reset: Access, title: str) -> list[Register]:
    """Consecutive registers, numbered from 0."""
    return [Register(f"{name}{k}", first + k, operating, reset, title) for k in range(count)]


def _buffer(address: int, name: str, access: Access, title: str) -> list[Register]:
    """Frame information and the twelve bytes after it, in operating mode only."""
    head = Register(f"{name}FI", address, access, NONE, f"{title} frame information", _FI)
    rest = [
        Register(f"{name}{k}", address + k, access, NONE, f"{title} byte {k}") for k in range(1, WINDOW_SIZE)
    ]
    return [head, *rest]


PELICAN = RegisterFile([
    Register("MOD", MOD, BOTH, BOTH, "mode", _MOD, "00000001", "0000xxx1"),
    Register("CMR", CMR, WRITE, WRITE, "command", _flags("- - - SRR CDO RRB AT TR"), "00000000", "00000000"),
    Register("SR", SR, READ, READ, "status", _STATUS, "00111100", "xx11x100"),
    Register("IR", IR, READ, READ, "interrupt", _flags("BEI ALI EPI WUI DOI EI TI RI"), "00000000", "00000x00"),
    Register("IER", IER, BOTH, BOTH, "interrupt enable", _flags("BEIE ALIE EPIE WUIE DOIE EIE TIE RIE")),
    Register("BTR0", BTR0, READ, BOTH, "bus timing 0", _BTR0),
    Register("BTR1", BTR1, READ, BOTH, "bus timing 1", _BTR1),
    Register("OCR", OCR, READ, BOTH, "output control", _OCR),
    Register("ALC", ALC, READ, READ, "arbitration lost capture", (Bit("BITNO", 0, 5, ALC_BITS),), "00000000"),
    Register("ECC", ECC, READ, READ, "error code capture", _ECC, "00000000"),
    Register("EWLR", EWLR, READ, BOTH, "error warning limit", (), "01100000"),
    Register("RXERR", RXERR, READ, BOTH, "receive error counter", (), "00000000"),
    Register("TXERR", TXERR, READ, BOTH, "transmit error counter", (), "00000000"),
    *_row(ACR0, 4, "ACR", NONE, BOTH, "acceptance code"),
    *_row(AMR0, 4, "AMR", NONE, BOTH, "acceptance mask, 1 does not care"),
    *_buffer(TX_BUFFER, "TX", WRITE, "transmit buffer"),
    *_buffer(RX_WINDOW, "RX", READ, "receive window"),
    Register("RMC", RMC, READ, READ, "receive message counter", (), "00000000", "00000000"),
    Register("RBSA", RBSA, READ, BOTH, "receive buffer start address", (), "00000000"),
    Register("CDR", CDR, BOTH, BOTH, "clock divider", _CDR, "00000000"),
    *_row(RX_FIFO, RX_FIFO_SIZE, "RAM", READ, BOTH, "receive FIFO"),
    *[Register(f"RAM{64 + k}", TX_RAM + k, READ, BOTH, "transmit buffer") for k in range(WINDOW_SIZE)],
    *[Register(f"RAM{77 + k}", FREE_RAM + k, READ, BOTH, "free RAM") for k in range(3)],
])  # fmt: skip

_BASIC_ID2 = (Bit("ID.2-0", 5, 3), Bit("RTR", 4), Bit("DLC", 0, 4))


def _basic_buffer(address: int, name: str, operating: Access, reset: Access, title: str) -> list[Register]:
    names = ("ID1", "ID2", *(f"D{k}" for k in range(1, 9)))
    return [
        Register(
            f"{name}{part}", address + k, operating, reset, f"{title} {part}", _BASIC_ID2 if k == 1 else ()
        )
        for k, part in enumerate(names)
    ]


BASIC = RegisterFile([
    Register("CR", BASIC_CR, BOTH, BOTH, "control", _flags("- - - OIE EIE TIE RIE RR"), "0x1xxxx1", "0x1xxxx1"),
    Register("CMR", BASIC_CMR, WRITE, WRITE, "command", _flags("- - - GTS CDO RRB AT TR"), "11111111", "11111111"),
    Register("SR", BASIC_SR, READ, READ, "status", _STATUS, "00001100", "xx00x100"),
    Register("IR", BASIC_IR, READ, READ, "interrupt", _flags("- - - WUI DOI EI TI RI"), "11100000", "11100x00"),
    Register("ACR", BASIC_ACR, NONE, BOTH, "acceptance code"),
    Register("AMR", BASIC_AMR, NONE, BOTH, "acceptance mask, 1 does not care"),
    Register("BTR0", BASIC_BTR0, NONE, BOTH, "bus timing 0", _BTR0),
    Register("BTR1", BASIC_BTR1, NONE, BOTH, "bus timing 1", _BTR1),
    Register("OCR", BASIC_OCR, NONE, BOTH, "output control", _OCR),
    *_basic_buffer(BASIC_TX_BUFFER, "TX", BOTH, NONE, "transmit buffer"),
    *_basic_buffer(BASIC_RX_WINDOW, "RX", BOTH, BOTH, "receive window"),
    Register("CDR", CDR, BOTH, BOTH, "clock divider", _CDR, "00000000"),
])  # fmt: skip
