"""The settings of a line as values for the registers of an MCP2515."""

from __future__ import annotations

from canwire.chips.mcp2515 import register_map as m
from canwire.drivers.driver import LineSettings
from canwire.drivers.mcp2515.timing import cnf_of
from canwire.errors import BadTiming, BadValue, Unsupported

KEPT = frozenset({m.BFPCTRL, m.CANINTE, *m.RXBCTRL})  # through a reset, by this driver; AT_REST besides
SETTABLE = {
    register.name: register.address
    for register in m.MAP.registers
    if register.address in m.AT_REST | KEPT and register.address not in {m.CNF1, m.CNF2, m.CNF3}
}
"""Registers that LineSettings.registers may set."""
USUAL = {
    m.CANINTE: 0xFF,
    m.RXBCTRL[0]: m.RXM_ALL << m.RX_RXM_SHIFT | m.RX_BUKT,
    m.RXBCTRL[1]: m.RXM_ALL << m.RX_RXM_SHIFT,
}


def set_up(settings: LineSettings, oscillator_hz: int) -> tuple[dict[int, int], int]:
    """The value for each register, and the mode. Raises BadTiming, Unsupported or BadValue."""
    cnf = cnf_of(settings.timing, oscillator_hz)
    if settings.data_timing is not None:
        raise Unsupported("an MCP2515 supports classic CAN only: no data bit rate, no long frames")
    settings.refuse_options("an MCP2515")
    if settings.oscillator_ppm:
        raise BadTiming(f"oscillator_ppm {settings.oscillator_ppm}: the crystal is the board's")
    if settings.loop_back and settings.listen_only:
        raise BadValue("listen_only and loop_back: an MCP2515 can only be in one of these modes")
    registers = dict(zip((m.CNF1, m.CNF2, m.CNF3), cnf, strict=True)) | USUAL
    for name, value in settings.registers:
        if name not in SETTABLE or not 0 <= value <= 0xFF:
            raise BadValue(f"register {name} = {value!r}: {', '.join(SETTABLE)}, each 0..255")
        registers[SETTABLE[name]] = value
    mode = m.LISTEN_ONLY if settings.listen_only else m.LOOP_BACK if settings.loop_back else m.NORMAL
    return registers, mode
