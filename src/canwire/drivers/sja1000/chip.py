"""Writes an SJA1000's registers for settings, reset mode, operating mode and sleep.

Source: SJA1000 data sheet 6.4; reference/sja1000.md sections 3, 7 and 8.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.chips.sja1000 import register_map as m
from canwire.drivers.driver import LineSettings
from canwire.errors import BadTiming, BadValue, Unsupported
from canwire.values.event import ErrorState
from canwire.values.register import RegisterValue
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.limits import TimingLimits

if TYPE_CHECKING:
    from canwire.chips.registers import RegisterAccess

USUAL_OCR = 0x6A  # normal mode, TX0 pull-down, TX1 pull-down inverted: the INduCAN104 manual, hi_ocr
USUAL_IER = m.IER_BEIE | m.IER_ALIE | m.IER_EPIE | m.IER_DOIE | m.IER_EIE | m.IER_RIE
SETTABLE = {
    "OCR": m.OCR, "IER": m.IER, "EWLR": m.EWLR,
    "ACR0": m.ACR0, "ACR1": m.ACR1, "ACR2": m.ACR2, "ACR3": m.ACR3,
    "AMR0": m.AMR0, "AMR1": m.AMR1, "AMR2": m.AMR2, "AMR3": m.AMR3,
}  # fmt: skip
"""Registers that LineSettings.registers may set."""
_USUAL = {m.OCR: USUAL_OCR, m.EWLR: 96, **dict.fromkeys(range(m.ACR0, m.ACR3 + 1), 0)}
_USUAL |= dict.fromkeys(range(m.AMR0, m.AMR3 + 1), 0xFF)
_PASSIVE = 127
_SIDE_EFFECTS = {m.IR, m.ALC, m.ECC}  # to read these changes the chip


class Chip:
    """The chip's registers, by `access`; `peek` reads one without side effects."""

    def __init__(
        self, access: RegisterAccess, oscillator_hz: int, peek: Callable[[int], int] | None = None
    ) -> None:
        self.read = access.read
        self.write = access.write
        self._peek = peek
        self._oscillator_hz = oscillator_hz
        self._mode = 0
        self._asked = USUAL_IER  # by the settings
        self._needed = 0  # by programs that have not made the settings
        self._set_up = False  # until then its registers are BasicCAN's
        self.loops_back = False

    def values_of(self, settings: LineSettings) -> dict[int, int]:
        """The value for each register. Raises BadTiming, Unsupported or BadValue."""
        btr = self._timing_registers(settings.timing)
        if settings.data_timing is not None:
            raise Unsupported("an SJA1000 supports classic CAN only: no data bit rate, no long frames")
        settings.refuse_options("an SJA1000")
        if settings.oscillator_ppm:
            raise BadTiming(f"oscillator_ppm {settings.oscillator_ppm}: the crystal is the board's")
        wanted = {m.BTR0: btr[0], m.BTR1: btr[1], **_USUAL, m.IER: USUAL_IER}
        for name, value in settings.registers:
            if name not in SETTABLE or not 0 <= value <= 0xFF:
                raise BadValue(f"register {name} = {value!r}: {', '.join(SETTABLE)}, each 0..255")
            wanted[SETTABLE[name]] = value
        return wanted

    def set_up(self, settings: LineSettings) -> None:
        """Enter reset mode and write all settings; raises before it changes anything."""
        wanted = self.values_of(settings)
        self.enter_reset()
        self._asked = wanted.pop(m.IER)
        for address, value in wanted.items():
            self.write(address, value)
        self.write(m.IER, self._interrupts)
        self._set_up = True
        self.loops_back = settings.loop_back
        self._mode = (m.MOD_LOM if settings.listen_only else 0) | (m.MOD_STM if settings.loop_back else 0)

    def _timing_registers(self, timing: BitTiming) -> tuple[int, int]:
        """BTR0 and BTR1 for this timing, or for its rate and sample point by this chip's clock."""
        clock_hz = self._oscillator_hz // 2
        if timing.clock_hz != clock_hz:
            timing = BitTiming.for_bit_rate(
                timing.bit_rate, timing.sample_point, clock_hz=clock_hz, limits=TimingLimits.SJA1000
            )
        return timing.to_btr()

    @property
    def _interrupts(self) -> int:
        return self._asked | self._needed

    def need(self, interrupts: int, *, transmits: bool) -> None:
        """Set these bits of IER from now on, besides those of the settings; `transmits`: the chip has a frame."""
        if interrupts != self._needed:
            self._needed = interrupts
            if self._set_up:
                self.write(m.IER, self._interrupts | (m.IER_TIE if transmits else 0))

    def enter_reset(self) -> None:
        """Enter reset mode of PeliCAN; a frame in the transmit buffer is lost."""
        self.write(m.MOD, m.MOD_RM)
        self.write(m.CDR, m.CDR_PELICAN | m.CDR_CBP)
        self.write(m.MOD, m.MOD_RM)  # what was a BasicCAN control register is the mode register now

    def clear(self) -> None:
        """In reset mode: clear counters and captures. This also ends bus-off, without the 128 sequences (6.4.12)."""
        self.write(m.TXERR, 0)
        self.write(m.RXERR, 0)
        for address in (m.IR, m.ALC, m.ECC):
            self.read(address)

    def operate(self) -> None:
        self.write(m.IER, self._interrupts)
        self.write(m.MOD, self._mode)

    def expect_transmit(self, expected: bool) -> None:
        """Set TIE only while the chip has a frame, unless IER of the settings contains it."""
        if not self._interrupts & m.IER_TIE:
            self.write(m.IER, self._interrupts | (m.IER_TIE if expected else 0))

    def sleep(self) -> None:
        """Enter sleep mode; the chip wakes immediately if the bus is busy (6.4.3)."""
        self.write(m.IER, self._interrupts | m.IER_WUIE)
        self.write(m.MOD, self._mode | m.MOD_SM)

    def wake(self) -> None:
        self.write(m.MOD, self._mode)

    def on_wire(self) -> bool:
        return self.read(m.SR) & (m.SR_TS | m.SR_RS) == m.SR_TS

    def state(self) -> ErrorState:
        status = self.read(m.SR)
        if status & m.SR_BS:
            return ErrorState.BUS_OFF
        if self.read(m.TXERR) > _PASSIVE or self.read(m.RXERR) > _PASSIVE:
            return ErrorState.ERROR_PASSIVE
        return ErrorState.ERROR_WARNING if status & m.SR_ES else ErrorState.ERROR_ACTIVE

    def registers(self) -> list[RegisterValue]:
        """The registers of the present mode that can be read without side effects; not the RAM.

        A chip without settings is in BasicCAN mode, where the reset request has the same address and bit.
        """
        resetting = bool(self.read(m.MOD) & m.MOD_RM)
        file = m.PELICAN if self.read(m.CDR) & m.CDR_PELICAN else m.BASIC
        values = []
        for register in file.readable(resetting):
            if register.address >= m.RX_FIFO or (self._peek is None and register.address in _SIDE_EFFECTS):
                continue
            value = (self._peek or self.read)(register.address)
            values.append(RegisterValue(register.name, register.address, value, register.describe(value)))
        return values

    def check_address(self, address: int, value: int = 0) -> None:
        """Raises BadValue unless the address is 0..127 and the value 0..255."""
        if not 0 <= address < m.PELICAN_ADDRESSES or not 0 <= value <= 0xFF:
            raise BadValue(f"register {address} = {value}: an SJA1000 has 0..127, each 0..255")
