"""The SJA1000's modes: hardware reset, reset mode and out of it, sleep, and recovery from bus-off.

Source: data sheet 6.3.2, 6.4.1 to 6.4.3, tables 2 and 11; reference/sja1000.md sections 2, 3 and 7.

Interpretations [INT] where the data sheet is silent:
- Sleep cannot be asked for before bus-free was seen; a pending transmission counts as bus activity. A chip that has
  been woken waits for 11 recessive bits with TS = RS = 1, as after reset.
- Recovery from bus-off that reset mode interrupts continues afterwards with the same count.
- BS cleared by a write to TXERR is reported by EI when reset mode is left.
"""

from __future__ import annotations

from typing import Any

from canwire.chips.registers import after_reset
from canwire.chips.sja1000 import register_map as names
from canwire.chips.sja1000.cells import CONTROL_CELL, view
from canwire.chips.sja1000.filter import BASIC_FILTER, DUAL_FILTER, SINGLE_FILTER
from canwire.chips.sja1000.link import BusSide
from canwire.chips.sja1000.register_map import BASIC, PELICAN
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.check import NodeTiming

_MOD, _SR, _IER, _CDR, _ACR0, _AMR0 = names.MOD, names.SR, names.IER, names.CDR, names.ACR0, names.AMR0
_RM, _SM = names.MOD_RM, names.MOD_SM
_RBS, _DOS, _TBS, _RS, _TS = names.SR_RBS, names.SR_DOS, names.SR_TBS, names.SR_RS, names.SR_TS
_EI, _WUI, _CDR_PELICAN, _CONTROL = names.IR_EI, names.IR_WUI, names.CDR_PELICAN, CONTROL_CELL
_RECOVERY_GROUPS = 128
_VIEWS = [view(pelican, resetting) for pelican in (False, True) for resetting in (False, True)]


class Modes(BusSide):
    """The chip's mode, and the view of its registers in that mode.

    `oscillator_ppm`, how far the crystal is off, takes effect when reset mode is left next. `power_up_cdr` is what a
    hardware reset leaves in CDR.
    """

    def __cinit__(self, *_: object, **__: object) -> None:
        """As BusSide's."""
        self._reads, self._writes = _VIEWS[1]

    def __init__(self, oscillator_hz: int, power_up_cdr: int) -> None:
        super().__init__()
        self.oscillator_hz = oscillator_hz
        self.oscillator_ppm = 0.0
        self.power_up_cdr = power_up_cdr
        self.asleep_from_ns = 0
        self.transceiver: Any = None  # its look() is called when reset mode is left
        self._resetting = True
        self._forced_off = False  # TXERR was written 255
        self._told_off = False  # BS was cleared by a write
        self._reads, self._writes = _VIEWS[1]

    def hardware_reset(self) -> None:
        """Act on the RST pin: set every register to its value after power-up; RAM and undefined bits stay."""
        self._leave_bus()
        for register in PELICAN.registers:
            if register.address < _CDR and register.after_hardware != "xxxxxxxx":
                self.cells[register.address] = after_reset(
                    register.after_hardware, self.cells[register.address]
                )
        self.cells[_CONTROL] = after_reset(BASIC.named("CR").after_hardware, self.cells[_CONTROL])
        self.cells[_SR] &= ~(_TS | _RS)
        self.cells[_CDR] = self.power_up_cdr
        self.fifo.clear(0)
        self.confinement.reset()
        self.interrupts.latched = 0
        self.bus_off = self._forced_off = self._told_off = False
        self.passive = self.tainted = False
        self._alc_free = self._ecc_free = True
        self._look()
        self.interrupts.settle()

    def pull_interrupt(self) -> None:
        """Wake a sleeping chip, as another device pulls the INT line."""
        if self.asleep:
            self._wake()
            self.interrupts.settle()

    def woken(self, at_ns: int) -> None:
        self.pull_interrupt()

    def _sleep(self) -> None:
        """Fall asleep; with bus activity, a pending interrupt or transmission, request WUI instead."""
        if not self.on_bus or self.bus is None:
            return
        if self.interrupts.active or self.offer is not None or not self.bus.idle():
            self.interrupts.request(_WUI)
            return
        self.cells[_MOD] |= _SM
        self.asleep_from_ns = self._now_ns()
        self.asleep = True
        self.on_bus = False
        self.bus.changed()

    def _wake(self) -> None:
        self.asleep = False
        self.cells[_MOD] &= ~_SM
        self.interrupts.request(_WUI)
        if self.bus is not None:
            self.bus.interrupt()
        self._wait(1, 0)

    # reset mode

    def _leave_bus(self) -> None:
        """Leave the bus immediately, even in the middle of a bit; requests are discarded."""
        if self.bus is not None:
            self.bus.interrupt()
        self.asleep = self.on_bus = False
        self.waiting = 0
        self.offer = None
        if self.bus is not None:
            self.bus.changed()

    def _enter_reset(self) -> None:
        tec = self._txerr()
        self._leave_bus()
        self.confinement.tec = tec
        self.cells[_MOD] = after_reset(PELICAN.named("MOD").after_software, self.cells[_MOD])
        self.cells[_CONTROL] |= _RM
        self.cells[_SR] = (self.cells[_SR] | _TBS) & ~(_DOS | _RBS)
        self.fifo.clear(self.fifo.start)
        self.interrupts.reset()
        self._look()

    def _leave_reset(self) -> None:
        if self._forced_off:
            self._forced_off = False
            self._go_bus_off()
            return
        self.cells[_MOD] &= ~_RM
        self.cells[_CONTROL] &= ~_RM
        self._look()
        self._take_settings()
        if self.transceiver is not None:
            self.transceiver.look()
        if self._told_off:
            self._told_off = False
            self.interrupts.request(_EI)
        if self.bus is not None:
            self.bus.interrupt()
        if self.bus_off:
            self._wait(_RECOVERY_GROUPS, _RECOVERY_GROUPS - 1 - self.confinement.tec)
        else:
            self._weigh()
            self._wait(1, 0)

    def _take_settings(self) -> None:
        """Apply the settings of reset mode: filter, role on the bus, bit times with the present oscillator."""
        cells = self.cells
        mode = cells[_MOD] if self.pelican else 0
        self.filter.mode = BASIC_FILTER
        if self.pelican:
            self.filter.mode = SINGLE_FILTER if mode & names.MOD_AFM else DUAL_FILTER
        self.filter.code = int.from_bytes(cells[_ACR0 : _ACR0 + 4], "big")
        self.filter.care = int.from_bytes(cells[_AMR0 : _AMR0 + 4], "big") ^ 0xFFFFFFFF
        self.listen_only = mode & names.MOD_LOM != 0
        self.self_test = mode & names.MOD_STM != 0
        timing = BitTiming.from_btr(cells[names.BTR0], cells[names.BTR1], self.oscillator_hz)
        self.timing = NodeTiming("SJA1000", timing, None, self.oscillator_ppm)
        scale = 1.0 / (1.0 + self.oscillator_ppm * 1e-6)
        quantum = timing.quantum_ps
        self.bit_ps = round(timing.bit_time_ps * scale)
        self.sample_ps = round(timing.sample_time_ps * scale)
        self.quantum_ps = round(quantum * scale)
        self.phase1_ps = round(timing.phase1 * quantum * scale)
        self.jump_ps = round(timing.jump * quantum * scale)
        self.sample_gap_ps = self.quantum_ps if timing.triple_sampling else 0

    def _look(self) -> None:
        """Choose the view of the registers, by CDR.7 and RM."""
        pelican = self.cells[_CDR] & _CDR_PELICAN != 0
        if pelican != self.pelican:
            self.pelican = pelican
            self.cells[_MOD] |= _RM
            self.cells[_CONTROL] |= _RM
        self._resetting = self.cells[_MOD if pelican else _CONTROL] & _RM != 0
        self._reads, self._writes = _VIEWS[2 * pelican + self._resetting]
        self._enable()

    def _wait(self, groups: int, seen: int) -> None:
        """Leave the bus until `groups` groups of 11 recessive bits have passed."""
        self.on_bus = False
        self.waiting = groups
        self.sequences = seen
        self.waiting_from_ns, self.waiting_from_ps = self._now_ns(), 0
        if self.bus is not None:
            self.bus.changed()

    def _now_ns(self) -> int:
        return 0 if self.bus is None else self.bus.timeline.now_ns

    def _txerr(self) -> int:
        """TXERR; during recovery the number of the 128 groups that are still to come, from 127 down."""
        if self.waiting != _RECOVERY_GROUPS or self.bus is None:
            return self.confinement.tec
        left = _RECOVERY_GROUPS - 1 - self.bus.recessive_groups(self)
        return left if left > 0 else 0

    def _enable(self) -> None:
        """Update the enabled interrupts; BasicCAN always enables WUI."""
        if self.pelican:
            self.interrupts.enabled = self.cells[_IER]
            self.interrupts.level(self.cells[_SR] & _RBS != 0)
        else:
            self.interrupts.enabled = (self.cells[_CONTROL] >> 1 & 15) | _WUI
