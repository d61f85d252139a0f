"""Driver of an SJA1000 in PeliCAN mode, simulated or real, that uses only the chip's registers.

The chip has one frame at a time. TIE is only set while it has one, unless IER of the settings contains TIE.
Source: SJA1000 data sheet 6.4; reference/sja1000.md.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from canwire.bus.can.node import Mailbox
from canwire.chips.sja1000 import register_map as m
from canwire.drivers.driver import Counters, LineSettings
from canwire.drivers.reporting import ChipDriver
from canwire.drivers.sja1000.chip import Chip
from canwire.drivers.sja1000.error_code import error_kind
from canwire.drivers.sja1000.frames import frame_bytes, take_frame
from canwire.errors import WrongState
from canwire.values.event import ErrorState, EventKind
from canwire.values.register import RegisterValue

if TYPE_CHECKING:
    from canwire.chips.host import Host
    from canwire.chips.registers import RegisterAccess


_INTERRUPTS = {
    int(EventKind.ERROR): m.IER_BEIE,
    int(EventKind.ARBITRATION_LOST): m.IER_ALIE,
    int(EventKind.STATE): m.IER_EIE | m.IER_EPIE,
    int(EventKind.OVERRUN): m.IER_DOIE,
}
"""The interrupts that report each kind of event."""


class Sja1000Driver(ChipDriver):
    """The Driver (drivers/driver.py) of an SJA1000. `now` returns the time in ns; `peek` reads without side effects."""

    def __init__(
        self,
        host: Host | None,
        access: RegisterAccess,
        now: Callable[[], int],
        *,
        oscillator_hz: int = 16_000_000,
        peek: Callable[[int], int] | None = None,
    ) -> None:
        super().__init__(host, now, access.read)
        self._write = access.write
        self._pending = partial(access.read, m.IR)
        self._chip = Chip(access, oscillator_hz, peek)
        self._in_chip = False  # the frame in the mailbox is in the chip's buffer too

    # settings

    def check(self, settings: LineSettings) -> None:
        self._chip.values_of(settings)

    def configure(self, settings: LineSettings) -> None:
        self._chip.set_up(settings)
        self._transmits = self._in_chip = False
        self.listen_only = settings.listen_only
        if self.running:
            self._operate()

    def report(self, kinds: frozenset[int], frames: bool) -> None:
        needed = m.IER_RIE if frames else 0
        for kind in kinds:
            needed |= _INTERRUPTS.get(kind, 0)
        self._chip.need(needed, transmits=self._in_chip)

    # taking part

    def start(self, at_ns: int, integrated: bool = False) -> None:
        """Take part with counters at 0, always after 11 recessive bits: the chip cannot skip them."""
        self._enter_reset()
        self._chip.clear()
        self.running = True
        self._asleep = False
        self._state = ErrorState.ERROR_ACTIVE
        self._operate()
        self.tell(EventKind.STATE)
        self.fill()

    def stop(self, at_ns: int) -> None:
        was_running, self.running = self.running, False
        self._enter_reset()
        if was_running:
            self.tell(EventKind.STATE)

    def restart(self, at_ns: int) -> None:
        if self.running and self._state is ErrorState.BUS_OFF and not self._transmits:
            self._operate()

    def rejoin(self, at_ns: int) -> None:
        if self.running and self._state is not ErrorState.BUS_OFF:
            self._enter_reset()
            self._operate()

    def on_wire(self) -> bool:
        return self._chip.on_wire()

    def idle(self) -> bool:
        return not self._read(m.SR) & (m.SR_TS | m.SR_RS)

    def sleep(self, at_ns: int) -> None:
        if not self.running:
            raise WrongState("a stopped controller cannot sleep; start the line first")
        if not self._asleep:
            self._asleep = True
            self.tell(EventKind.SLEEPING)
            self._chip.sleep()

    def wake(self, at_ns: int) -> None:
        if self._asleep:
            self._chip.wake()
            self._woken()

    def _enter_reset(self) -> None:
        """Enter reset mode; a frame in the chip's buffer is lost, the one in the mailbox stays."""
        self._chip.enter_reset()
        self._transmits = self._in_chip = False

    def _operate(self) -> None:
        self._chip.operate()
        self._transmits = not self.listen_only
        if self.normal.occupied and self._transmits:
            self._send()

    def _woken(self) -> None:
        if self._asleep:
            self._asleep = False
            self._chip.expect_transmit(self._in_chip)
            self.tell(EventKind.WOKEN)

    # what it says of itself

    def counters(self) -> Counters:
        off = self.running and self._state is ErrorState.BUS_OFF
        state = self._chip.state() if self.running else ErrorState.STOPPED
        return self.counted(256 if off else self._read(m.TXERR), self._read(m.RXERR), state)

    def registers(self) -> list[RegisterValue]:
        return self._chip.registers()

    def _operates(self) -> bool:
        """The chip is in operating mode; in bus-off it has gone into reset mode by itself, and stays there."""
        return self.running and self._state is not ErrorState.BUS_OFF

    def read_register(self, address: int, reset_mode: bool) -> int:
        self._chip.check_address(address)
        if not reset_mode or not self._operates():
            return self._read(address)
        self._enter_reset()
        value = self._read(address)
        self._operate()
        return value

    def write_register(self, address: int, value: int, reset_mode: bool) -> None:
        self._chip.check_address(address, value)
        if not reset_mode or not self._operates():
            self._write(address, value)
            return
        self._enter_reset()
        self._write(address, value)
        self._operate()

    # sending

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        if self._transmits:
            self.wake(at_ns)
            self._send()

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        if not box.occupied:
            return False
        delivered = False
        if self._in_chip:
            self._write(m.CMR, m.CMR_AT)  # a frame on the wire continues, and is not repeated if it fails
            status = self._read(m.SR)
            if not status & m.SR_TBS:
                return False
            delivered = bool(status & m.SR_TCS)
        if box.occupied:  # no transmit interrupt has reported it
            self._finished(delivered)
        return not delivered

    def _send(self) -> None:
        """Put the mailbox's frame into the transmit buffer and request its transmission."""
        write = self._write
        for at, value in enumerate(frame_bytes(self.normal), m.TX_BUFFER):
            write(at, value)
        self._chip.expect_transmit(True)
        self._in_chip = True
        request = m.CMR_SRR if self._chip.loops_back else m.CMR_TR
        write(m.CMR, request | m.CMR_AT if self.normal.single_shot else request)

    def _finished(self, delivered: bool) -> None:
        """The frame in the mailbox was delivered or aborted; the next one may be loaded."""
        if self._in_chip:
            self._chip.expect_transmit(False)
        self._in_chip = False
        self.over(self.normal, delivered)

    # interrupts

    def _serve(self, interrupts: int) -> None:
        if interrupts & m.IR_ALI:
            self.arbitration_lost(self._read(m.ALC))
        if interrupts & m.IR_BEI:
            self._capture(self._read(m.ECC))
        if interrupts & m.IR_WUI:
            self._woken()
        if interrupts & m.IR_RI:
            self._receive()
        if interrupts & m.IR_DOI:
            self._write(m.CMR, m.CMR_CDO)
            self.tell(EventKind.OVERRUN)
        if interrupts & (m.IR_EI | m.IR_EPI):
            self._state_changed()
        if interrupts & m.IR_TI and self._in_chip:
            status = self._read(m.SR)
            if status & m.SR_TBS:
                self._finished(bool(status & m.SR_TCS))

    def _capture(self, code: int) -> None:
        """The error code capture of a bus error."""
        sends = not code & m.ECC_RX
        self.bus_error(error_kind(code), code=code, transmitting=sends)
        if sends and self._in_chip and self.normal.abort_on_error:
            self._write(m.CMR, m.CMR_AT)

    def _state_changed(self) -> None:
        state = self._chip.state()
        if state is self._state:
            return
        self._state = state
        if state is ErrorState.BUS_OFF:
            self._transmits = self._in_chip = False  # the chip has gone into reset mode by itself
        self.tell(EventKind.STATE)

    def _receive(self) -> None:
        """Take every frame out of the FIFO."""
        read, write, box, host = self._read, self._write, self._incoming, self.host
        while read(m.SR) & m.SR_RBS:
            take_frame(read, box)
            write(m.CMR, m.CMR_RRB)
            self._received += 1
            if host is not None:
                host.received(box, self._now())
