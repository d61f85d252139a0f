# cython: nonecheck=False
"""The SJA1000 CAN controller, register by register: BasicCAN and PeliCAN.

The map is data (register_map.py), and a table (cells.py) gives the byte at each address. This file has the effects of
reads and writes; link.py is the side towards the bus.
Source: Philips SJA1000 data sheet, 2000 Jan 04; reference/sja1000.md.

Interpretations [INT] where the data sheet is silent, besides those of link.py and modes.py:
- Effects of RM, RIE and commands that need one internal clock on the chip happen immediately.
- Commands that ask for a transmission are lost in reset mode, and while a request is pending; AT among them still
  makes the pending one a single shot. Registers and RAM are 0 at power-up where the data sheet says X.
- ALC and ECC keep their values when they are read.
- With SAM set a bit is what two of three samples are, the last at the sample point, one clock period of the bit
  timing logic (a quantum) apart.
- Output control and the comparator bypass change nothing on the bus: transceivers belong to the board. Nor does
  RXINTEN.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from canwire.bus.can.node import QUIET, RECEIVED_LAST, RECEIVING, SENDING
from canwire.chips.sja1000 import cells as codes
from canwire.chips.sja1000 import register_map as names
from canwire.chips.sja1000.modes import Modes
from canwire.chips.sja1000.output import FLOAT, pins
from canwire.errors import BadValue
from canwire.values.timing.bit_timing import BitTiming

_SPECIAL, _WINDOW, _BUFFER, _CONTROL = codes.SPECIAL, codes.WINDOW, codes.BUFFER, codes.CONTROL_CELL
_READ_STATUS, _READ_INTERRUPT = codes.READ_STATUS, codes.READ_INTERRUPT
_READ_ALC, _READ_ECC, _READ_RXERR, _READ_TXERR = (
    codes.READ_ALC, codes.READ_ECC, codes.READ_RXERR, codes.READ_TXERR,
)  # fmt: skip
_READ_RMC, _READ_RBSA = codes.READ_RMC, codes.READ_RBSA
_WRITE_MODE, _WRITE_CONTROL, _WRITE_COMMAND = codes.WRITE_MODE, codes.WRITE_CONTROL, codes.WRITE_COMMAND
_WRITE_IER, _WRITE_RXERR, _WRITE_TXERR = codes.WRITE_IER, codes.WRITE_RXERR, codes.WRITE_TXERR
_WRITE_RBSA, _WRITE_CDR = codes.WRITE_RBSA, codes.WRITE_CDR
_MOD, _SR, _IER, _ALC, _ECC = names.MOD, names.SR, names.IER, names.ALC, names.ECC
_OCR, _CDR, _TX_RAM, _RX_FIFO = names.OCR, names.CDR, names.TX_RAM, names.RX_FIFO
_RM, _SM = names.MOD_RM, names.MOD_SM
_TR, _AT, _RRB, _CDO, _SRR = names.CMR_TR, names.CMR_AT, names.CMR_RRB, names.CMR_CDO, names.CMR_SRR
_RBS, _DOS, _TBS, _RS, _TS, _BS = (
    names.SR_RBS, names.SR_DOS, names.SR_TBS, names.SR_RS, names.SR_TS, names.SR_BS,
)  # fmt: skip
_RI, _BASIC_IR_ONES, _CDR_ZERO = names.IR_RI, names.BASIC_IR_ONES, 0x10
_QUIET, _RECEIVED_LAST, _RECEIVING, _SENDING = QUIET, RECEIVED_LAST, RECEIVING, SENDING
_FORCED_TXERR = 255
_STOPS_AFTER_BITS = 15


class Sja1000(Modes):
    """One controller; `read` and `write` take the chip's own addresses, whatever it is wired to.

    `bus` is a CanBus, a lab's bus, or None: CanBus.attach(chip) puts it on the copper later. `oscillator_hz` must
    be even; `oscillator_ppm`, how far the crystal is off, takes effect when reset mode is left next.
    `reset_mode_cdr` is what a hardware reset leaves in CDR: 0x00 with the MODE pin high (Intel), 0x05 with it low.
    `on_interrupt` is called when INT becomes active, from inside a write or the bus's calls; it may read and write.
    Raises BadValue or BadTiming for an impossible oscillator or CDR.
    """

    def __init__(self, bus: Any = None, oscillator_hz: int = 16_000_000, *, reset_mode_cdr: int = 0) -> None:
        BitTiming.from_btr(0, 0, oscillator_hz)
        if reset_mode_cdr not in (0x00, 0x05):
            raise BadValue(f"reset_mode_cdr {reset_mode_cdr!r}: 0x00 (Intel) or 0x05 (Motorola)")
        super().__init__(oscillator_hz, reset_mode_cdr)
        self.hardware_reset()
        if bus is not None:
            getattr(bus, "wire", bus).attach(self)

    # the pins

    @property
    def interrupt(self) -> bool:
        """Whether INT is active."""
        return self.interrupts.active

    @property
    def on_interrupt(self) -> Callable[[], None] | None:
        return self.interrupts.handler

    @on_interrupt.setter
    def on_interrupt(self, handler: Callable[[], None] | None) -> None:
        self.interrupts.handler = handler

    @property
    def clkout_hz(self) -> float:
        """Frequency at CLKOUT, 0 when it is switched off or the chip sleeps."""
        divider = self.cells[_CDR]
        if divider & names.CDR_CLOCK_OFF:
            return 0.0
        if self.asleep and (self._now_ns() - self.asleep_from_ns) * 1000 > _STOPS_AFTER_BITS * self.bit_ps:
            return 0.0
        return self.oscillator_hz / names.CLOCK_DIVIDERS[divider & names.CDR_DIVIDER_MASK]

    def output_pins(self, dominant: bool) -> tuple[str, str]:
        """The states of TX0 and TX1 as in output.pins; in reset mode they float, asleep they are recessive."""
        if self._resetting:
            return FLOAT, FLOAT
        return pins(self.cells[_OCR], dominant and not self.asleep)

    # registers

    def read(self, address: int) -> int:
        """Read a register, with the side effects of that; addresses beyond the map alias."""
        code = self._reads[address & 127]
        if code < _SPECIAL:
            return self.cells[code]
        if code >= _WINDOW:  # most of all reads
            return self.cells[self._window(code)]
        if code == _READ_INTERRUPT:
            return self.interrupts.take(_RI) if self.pelican else self.interrupts.take(0) | _BASIC_IR_ONES
        if code == _READ_ALC:
            self._alc_free = True
        elif code == _READ_ECC:
            self._ecc_free = True
        return self._look_at(code)

    def peek(self, address: int) -> int:
        """A register's value without side effects."""
        code = self._reads[address & 127]
        return self.cells[code] if code < _SPECIAL else self._look_at(code)

    def write(self, address: int, value: int) -> None:
        """Write the low eight bits of `value`; read-only bits stay unchanged."""
        code = self._writes[address & 127]
        value &= 255
        if code < _SPECIAL:
            self.cells[code] = value
        elif code >= _BUFFER:
            if self.cells[_SR] & _TBS:
                self.cells[_TX_RAM + code - _BUFFER] = value
        else:
            self._write(code, value)
            self.interrupts.settle()

    def _look_at(self, code: int) -> int:
        if code >= _WINDOW:
            return self.cells[self._window(code)]
        if code == _READ_STATUS:
            return self._status()
        if code == _READ_INTERRUPT:
            return self.interrupts.latched | (0 if self.pelican else _BASIC_IR_ONES)
        if code == _READ_RMC:
            return self.fifo.count & 31
        if code == _READ_RBSA:
            return self.fifo.start
        if code == _READ_RXERR:
            return self.confinement.rec
        if code == _READ_TXERR:
            return self._txerr()
        return self.cells[_ALC if code == _READ_ALC else _ECC]

    def _window(self, code: int) -> int:
        """The cell of a byte of the receive window."""
        return _RX_FIFO + ((self.fifo.start + code - _WINDOW) & 63)

    def _status(self) -> int:
        value = self.cells[_SR]
        if not self.on_bus:
            return value | _TS | _RS if self.pelican and not self.asleep else value
        activity = self.bus.activity(self) if self.bus is not None else _QUIET
        if activity == _QUIET:
            return value
        return value | (_RS if activity in (_RECEIVING, _RECEIVED_LAST) else _TS)

    def _write(self, code: int, value: int) -> None:
        if code == _WRITE_COMMAND:
            self._command(value)
        elif code == _WRITE_MODE:
            self._write_mode(value)
        elif code == _WRITE_CONTROL:
            self._write_control(value)
        elif code == _WRITE_IER:
            self.cells[_IER] = value
            self._enable()
        elif code == _WRITE_CDR:
            self._write_divider(value)
        elif code == _WRITE_RXERR:
            if not self.bus_off:
                self.confinement.rec = value
        elif code == _WRITE_TXERR:
            self._write_txerr(value)
        elif code == _WRITE_RBSA:
            self.fifo.clear(value)
        elif code >= _WINDOW:
            self.cells[self._window(code)] = value

    def _write_txerr(self, value: int) -> None:
        self.confinement.tec = value
        self._forced_off = value == _FORCED_TXERR
        if self.bus_off and not self._forced_off:
            self.bus_off = False
            self._told_off = True
            self.cells[_SR] &= ~_BS

    def _write_divider(self, value: int) -> None:
        """Write CDR: all of it in reset mode, the divider alone in operating mode."""
        if not self._resetting:
            self.cells[_CDR] = (self.cells[_CDR] & 0xF8) | (value & 7)
            return
        self.cells[_CDR] = value & ~_CDR_ZERO
        self._look()

    def _write_mode(self, value: int) -> None:
        if self._resetting:
            self.cells[_MOD] = (value & 0x0E) | _RM
            if not value & _RM:
                self._leave_reset()
        elif value & _RM:
            self._enter_reset()
        elif value & _SM:
            self._sleep()
        elif self.asleep:
            self._wake()

    def _write_control(self, value: int) -> None:
        self.cells[_CONTROL] = (value & 0x5E) | 0x20 | (self.cells[_CONTROL] & _RM)
        self._enable()
        if self._resetting and not value & _RM:
            self._leave_reset()
        elif value & _RM and not self._resetting:
            self._enter_reset()

    # commands

    def _command(self, value: int) -> None:
        if value & _CDO:
            self.cells[_SR] &= ~_DOS
        if value & _RRB:
            self.fifo.release()
            if not self.fifo.count:
                self.cells[_SR] &= ~_RBS
            self.interrupts.released(self.fifo.count != 0)
        if not self._resetting:
            asked = value & (_SRR | _AT | _TR)
            if not self.pelican:
                asked &= _AT | _TR
                if value & _SRR:  # there it is GTS
                    self._sleep()
                elif self.asleep:
                    self._wake()
            if asked == _AT:
                self._abort()
            elif asked:
                self._request(asked & _TR == 0, asked & _AT != 0)

    def _abort(self) -> None:
        """Abort the pending request; a frame on the wire ends, but is not repeated."""
        offer = self.offer
        if offer is None:
            return
        if self.contending is offer and self.bus is not None:
            self.bus.interrupt()  # down to the bit, to know whether it is still in arbitration
            if self.offer is not offer:
                return
            if self.bus is not None and self.bus.activity(self) == _SENDING:
                offer.single_shot = True
                return
        self._give_up()
