"""The addresses of the 128 SJA1000 registers of an INduCAN104 in the I/O space of a PC.

The board uses 32 addresses below 400h, as the PC/AT bus requires: A9..A5 select the board, A4..A0 one of
32 registers, and A11, A10, which that bus leaves free, one of four pages of 32. BasicCAN's 32 registers are page 0.
A15..A12 are not connected. Source: INduCAN104 manual ("PC/104 board address"). Its page ranges "0-32, 33-64, ..."
count wrong; its addresses make them 0..31, 32..63, 64..95, 96..127.
"""

from __future__ import annotations

from canwire.errors import BadValue

PORTS = 0x20
"""Number of addresses of a board below 400h, and of registers in a page."""
BASES = range(0x100, 0x400, PORTS)
"""The 24 addresses a board can have."""
USUAL_BASE = 0x280
REGISTERS = 128
SELECT = 0x3E0  # A9..A5
_PAGE_SHIFT = 10  # A10, A11
_SPACE = 0x10000


def port_text(port: int) -> str:
    """The port in the notation of the manual: 280h."""
    return f"{port:03X}h"


def checked_base(base: int) -> int:
    """The base address, if jumpers can set it; raises BadValue."""
    if not isinstance(base, int) or isinstance(base, bool) or base not in BASES:
        shown = port_text(base) if isinstance(base, int) and base >= 0 else repr(base)
        raise BadValue(f"base address {shown}: 100h, 120h, 140h and so on to 3E0h; usually {USUAL_BASE:X}h")
    return base


def checked_port(port: int) -> int:
    """Return the port if the processor has it; raises BadValue."""
    if not 0 <= port < _SPACE:
        raise BadValue(f"port {port:#x}: 0 to 0xFFFF")
    return port


def checked_byte(value: int, port: int) -> int:
    """Return the value if it is a byte; raises BadValue with the port."""
    if not 0 <= value <= 0xFF:
        raise BadValue(f"value {value:#x} for port {port_text(port)}: 0 to 0xFF")
    return value


def port_of(register: int, base: int) -> int:
    """The port of a register, 0..127, of the board at that base; raises BadValue."""
    if not 0 <= register < REGISTERS:
        raise BadValue(f"register {register}: 0 to {REGISTERS - 1}")
    page, offset = divmod(register, PORTS)
    return checked_base(base) + offset + (page << _PAGE_SHIFT)


def register_at(port: int, base: int) -> int | None:
    """The register at a port of the board at that base; None if the board does not answer."""
    if port & SELECT != base:
        return None
    return port & (PORTS - 1) | (port >> _PAGE_SHIFT & 3) * PORTS
