"""The byte of the SJA1000 model at each address, in each of its four views.

A view is two tables of 128 entries, one for reads and one for writes, made from register_map.py. An entry below
`SPECIAL` is the index of a byte in the model's `cells`, and that register is only storage; the others
name registers with side effects. Cells 0 to 127 have PeliCAN's addresses, its RAM included; BasicCAN's registers are
the same bytes where they are the same flip-flops (ACR is ACR0, AMR is AMR0, the transmit buffer the first ten bytes
of PeliCAN's) [INT].
"""

from __future__ import annotations

from canwire.chips.registers import Access, Register, RegisterFile
from canwire.chips.sja1000.register_map import (
    ACR0,
    AMR0,
    BASIC,
    BASIC_ADDRESSES,
    BASIC_RX_WINDOW,
    BASIC_TX_BUFFER,
    PELICAN,
    PELICAN_ADDRESSES,
    RX_WINDOW,
    TX_BUFFER,
    TX_RAM,
)

ZERO, ONES, CONTROL_CELL, CELLS = 128, 129, 130, 131
SPECIAL = 160

READ_STATUS, READ_INTERRUPT, READ_ALC, READ_ECC, READ_RXERR, READ_TXERR, READ_RMC, READ_RBSA = range(160, 168)
WRITE_NOTHING, WRITE_MODE, WRITE_CONTROL, WRITE_COMMAND, WRITE_IER = range(160, 165)
WRITE_RXERR, WRITE_TXERR, WRITE_RBSA, WRITE_CDR = range(165, 169)
WINDOW = 176  # to 188: a byte of the receive window
BUFFER = 192  # to 204: a byte of the transmit buffer, written only while it is released

_READ = {
    "SR": READ_STATUS,
    "IR": READ_INTERRUPT,
    "ALC": READ_ALC,
    "ECC": READ_ECC,
    "RXERR": READ_RXERR,
    "TXERR": READ_TXERR,
    "RMC": READ_RMC,
    "RBSA": READ_RBSA,
    "CR": CONTROL_CELL,
}
_WRITE = {
    "MOD": WRITE_MODE,
    "CR": WRITE_CONTROL,
    "CMR": WRITE_COMMAND,
    "IER": WRITE_IER,
    "RXERR": WRITE_RXERR,
    "TXERR": WRITE_TXERR,
    "RBSA": WRITE_RBSA,
    "CDR": WRITE_CDR,
}
_BASIC_CELLS = {"ACR": ACR0, "AMR": AMR0}


def view(pelican: bool, resetting: bool) -> tuple[bytearray, bytearray]:
    """The tables for reads and for writes; addresses that are not decoded alias lower ones."""
    registers = PELICAN if pelican else BASIC
    size = PELICAN_ADDRESSES if pelican else BASIC_ADDRESSES
    reads = bytearray([ZERO if pelican else ONES]) * size
    writes = bytearray([WRITE_NOTHING]) * size
    for register in registers.registers:
        access = register.access(resetting)
        if access & Access.READ:
            reads[register.address] = _read_code(register, registers)
        if access & Access.WRITE:
            writes[register.address] = _write_code(register, registers)
    aliases = PELICAN_ADDRESSES // size
    return reads * aliases, writes * aliases


def _read_code(register: Register, registers: RegisterFile) -> int:
    if register.name in _READ:
        return _READ[register.name]
    if registers is PELICAN:
        return WINDOW + register.address - RX_WINDOW if register.name.startswith("RX") else register.address
    if register.name.startswith("RX"):
        return WINDOW + register.address - BASIC_RX_WINDOW
    if register.name.startswith("TX"):
        return TX_RAM + register.address - BASIC_TX_BUFFER
    return _BASIC_CELLS.get(register.name, register.address)


def _write_code(register: Register, registers: RegisterFile) -> int:
    if register.name in _WRITE:
        return _WRITE[register.name]
    if register.name.startswith("TX"):
        return BUFFER + register.address - (TX_BUFFER if registers is PELICAN else BASIC_TX_BUFFER)
    return _read_code(register, registers)
