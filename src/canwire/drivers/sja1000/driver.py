"""Driver of an SJA1000 in PeliCAN mode, through its registers alone: a model's, or a real chip's.

Whoever wires the chip's INT calls `service`. One frame is in the chip at a time; TIE is only set while one is, unless
the settings' IER asks for it always. Source: SJA1000 data sheet 6.4; reference/sja1000.md.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.bus.node import Mailbox
from canwire.chips import sja1000_map as m
from canwire.drivers.driver import Counters, Driver, LineSettings
from canwire.drivers.sja1000.error_code import error_kind
from canwire.drivers.sja1000.frames import frame_bytes, take_frame
from canwire.errors import BadTiming, BadValue, Unsupported
from canwire.values.bit_timing import BitTiming
from canwire.values.event import ErrorKind, ErrorState, EventKind
from canwire.values.register import RegisterValue
from canwire.values.timing_limits import TimingLimits

if TYPE_CHECKING:
    from canwire.chips.host import Host
    from canwire.chips.registers import RegisterAccess

USUAL_OCR = 0x6A  # normal mode, TX0 pull-down, TX1 pull-down inverted: seed 001, hi_ocr
USUAL_IER = m.IER_BEIE | m.IER_ALIE | m.IER_EPIE | m.IER_DOIE | m.IER_EIE | m.IER_RIE
SETTABLE = {
    "OCR": m.OCR, "IER": m.IER, "EWLR": m.EWLR,
    "ACR0": m.ACR0, "ACR1": m.ACR1, "ACR2": m.ACR2, "ACR3": m.ACR3,
    "AMR0": m.AMR0, "AMR1": m.AMR1, "AMR2": m.AMR2, "AMR3": m.AMR3,
}  # fmt: skip
"""Registers that LineSettings.registers may set."""
_USUAL = {m.OCR: USUAL_OCR, m.EWLR: 96, **dict.fromkeys(range(m.ACR0, m.ACR3 + 1), 0)}
_USUAL |= dict.fromkeys(range(m.AMR0, m.AMR3 + 1), 0xFF)
_PASSES = 20  # through the interrupt register in one go; the next interrupt takes up the rest
_PASSIVE = 127
_SIDE_EFFECTS = {m.IR, m.ALC, m.ECC}  # to read these changes the chip


class Sja1000Driver(Driver):
    """drivers/driver.py's seam over registers. `now` tells the time in ns, `peek` reads without side effects."""

    def __init__(
        self,
        host: Host | None,
        access: RegisterAccess,
        now: Callable[[], int],
        *,
        oscillator_hz: int = 16_000_000,
        peek: Callable[[int], int] | None = None,
    ) -> None:
        box = Mailbox()
        super().__init__(host, box, box)
        self._read = access.read
        self._write = access.write
        self._peek = peek
        self._now = now
        self._oscillator_hz = oscillator_hz
        self._incoming = Mailbox()
        self._mode = 0
        self._interrupts = USUAL_IER
        self._transmits = False  # the chip can be told to send: it is in operating mode
        self._in_chip = False  # the frame in the mailbox is in the chip's buffer too
        self._servicing = False
        self._state = ErrorState.ERROR_ACTIVE
        self._errors = self._losses = self._sent = self._received = self._last_error = 0

    # settings

    def configure(self, settings: LineSettings) -> None:
        """Raises BadTiming, Unsupported or BadValue before anything is changed."""
        btr = self._registers_of(settings.timing)
        if settings.data_timing is not None:
            raise Unsupported("an SJA1000 knows classic CAN only: no data bit rate, no long frames")
        if settings.oscillator_ppm:
            raise BadTiming(f"oscillator_ppm {settings.oscillator_ppm}: the crystal is the board's")
        wanted = {**_USUAL, m.IER: USUAL_IER}
        for name, value in settings.registers:
            if name not in SETTABLE or not 0 <= value <= 0xFF:
                raise BadValue(f"register {name} = {value!r}: {', '.join(SETTABLE)}, each 0..255")
            wanted[SETTABLE[name]] = value
        self._enter_reset()
        self._interrupts = wanted.pop(m.IER)
        for address, value in ((m.BTR0, btr[0]), (m.BTR1, btr[1]), *wanted.items()):
            self._write(address, value)
        self._write(m.IER, self._interrupts)
        self.listen_only = settings.listen_only
        self._mode = m.MOD_LOM if settings.listen_only else 0
        if self.running:
            self._operate()

    def _registers_of(self, timing: BitTiming) -> tuple[int, int]:
        """BTR0 and BTR1 for this timing, or for its rate and sample point by this chip's clock."""
        clock_hz = self._oscillator_hz // 2
        if timing.clock_hz != clock_hz:
            timing = BitTiming.for_bit_rate(
                timing.bit_rate, timing.sample_point, clock_hz=clock_hz, limits=TimingLimits.SJA1000
            )
        return timing.to_btr()

    # taking part

    def start(self, at_ns: int, integrated: bool = False) -> None:
        """With clean counters, after 11 recessive bits; a chip cannot be told that they were seen."""
        self._enter_reset()
        self._write(m.TXERR, 0)  # ends bus-off too, without its 128 sequences (data sheet 6.4.12)
        self._write(m.RXERR, 0)
        for address in (m.IR, m.ALC, m.ECC):
            self._read(address)
        self.running = True
        self._state = ErrorState.ERROR_ACTIVE
        self._operate()
        self._tell(EventKind.STATE)
        self._fill()

    def stop(self, at_ns: int) -> None:
        was_running, self.running = self.running, False
        self._enter_reset()
        if was_running:
            self._tell(EventKind.STATE)

    def restart(self, at_ns: int) -> None:
        if self.running and self._state is ErrorState.BUS_OFF and not self._transmits:
            self._operate()

    def rejoin(self, at_ns: int) -> None:
        if self.running and self._state is not ErrorState.BUS_OFF:
            self._enter_reset()
            self._operate()

    def on_wire(self) -> bool:
        return self._read(m.SR) & (m.SR_TS | m.SR_RS) == m.SR_TS

    def _enter_reset(self) -> None:
        """PeliCAN, in reset mode; a frame in the chip's buffer is gone, that in the mailbox stays."""
        self._write(m.MOD, m.MOD_RM)
        self._write(m.CDR, m.CDR_PELICAN | m.CDR_CBP)
        self._write(m.MOD, m.MOD_RM)  # what was a BasicCAN control register is the mode register now
        self._transmits = self._in_chip = False

    def _operate(self) -> None:
        self._write(m.IER, self._interrupts)
        self._write(m.MOD, self._mode)
        self._transmits = not self.listen_only
        if self.normal.occupied:
            self._send()

    # what it says of itself

    def counters(self) -> Counters:
        off = self.running and self._state is ErrorState.BUS_OFF
        state = self._read_state(self._read(m.SR)) if self.running else ErrorState.STOPPED
        return Counters(
            256 if off else self._read(m.TXERR), self._read(m.RXERR), state,
            self._errors, self._losses, self._sent, self._received, self._last_error,
        )  # fmt: skip

    def registers(self) -> list[RegisterValue]:
        resetting = bool(self._read(m.MOD) & m.MOD_RM)
        values = []
        for register in m.PELICAN.readable(resetting):
            if register.address >= m.RX_FIFO or (self._peek is None and register.address in _SIDE_EFFECTS):
                continue
            value = (self._peek or self._read)(register.address)
            values.append(RegisterValue(register.name, register.address, value, register.describe(value)))
        return values

    def _read_state(self, status: int) -> ErrorState:
        if status & m.SR_BS:
            return ErrorState.BUS_OFF
        if self._read(m.TXERR) > _PASSIVE or self._read(m.RXERR) > _PASSIVE:
            return ErrorState.ERROR_PASSIVE
        return ErrorState.ERROR_WARNING if status & m.SR_ES else ErrorState.ERROR_ACTIVE

    # sending

    def transmit(self, box: Mailbox, at_ns: int) -> None:
        if self._transmits:
            self._send()

    def abort(self, box: Mailbox, at_ns: int) -> bool:
        if not box.occupied or (self._in_chip and self.on_wire()):
            return False
        if self._in_chip:
            self._write(m.CMR, m.CMR_AT)
            if not self._read(m.SR) & m.SR_TBS:
                return False
        if box.occupied:  # no transmit interrupt has told of it
            self._finished(False)
        return True

    def _send(self) -> None:
        """Put the mailbox's frame into the transmit buffer and request its transmission."""
        write = self._write
        for at, value in enumerate(frame_bytes(self.normal), m.TX_BUFFER):
            write(at, value)
        if not self._interrupts & m.IER_TIE:
            write(m.IER, self._interrupts | m.IER_TIE)
        self._in_chip = True
        write(m.CMR, m.CMR_TR | m.CMR_AT if self.normal.single_shot else m.CMR_TR)

    def _finished(self, delivered: bool) -> None:
        """The frame in the mailbox went through, or was given up; the next one may come."""
        box, at_ns = self.normal, self._now()
        if self._in_chip and not self._interrupts & m.IER_TIE:
            self._write(m.IER, self._interrupts)
        self._in_chip = False
        if self.host is not None:
            if delivered:
                self._sent += 1
                self.host.transmitted(box, at_ns)
            else:
                self.host.aborted(box, at_ns)
        box.occupied = False
        self._fill()

    def _fill(self) -> None:
        if self.host is not None:
            self.host.fill(self._now())

    # interrupts

    def service(self) -> None:
        """Serve the chip's interrupts until there are none; safe to call when there are none."""
        if self._servicing:
            return  # the loop below looks again
        self._servicing = True
        try:
            for _ in range(_PASSES):
                interrupts = self._read(m.IR)
                if not interrupts:
                    break
                self._serve(interrupts)
        finally:
            self._servicing = False

    def _serve(self, interrupts: int) -> None:
        if interrupts & m.IR_ALI:
            self._losses += 1
            self._tell(EventKind.ARBITRATION_LOST, bit=self._read(m.ALC), transmitting=True)
        if interrupts & m.IR_BEI:
            self._bus_error(self._read(m.ECC))
        if interrupts & m.IR_RI:
            self._receive()
        if interrupts & m.IR_DOI:
            self._write(m.CMR, m.CMR_CDO)
            self._tell(EventKind.OVERRUN)
        if interrupts & (m.IR_EI | m.IR_EPI):
            self._state_changed()
        if interrupts & m.IR_TI and self._in_chip:
            status = self._read(m.SR)
            if status & m.SR_TBS:
                self._finished(bool(status & m.SR_TCS))

    def _bus_error(self, code: int) -> None:
        self._errors += 1
        sends = not code & m.ECC_RX
        kind = error_kind(code)
        self._last_error = int(kind)
        self._tell(EventKind.ERROR, kind, code=code, transmitting=sends)
        if sends and self._in_chip and self.normal.abort_on_error:
            self._write(m.CMR, m.CMR_AT)

    def _state_changed(self) -> None:
        state = self._read_state(self._read(m.SR))
        if state is self._state:
            return
        self._state = state
        if state is ErrorState.BUS_OFF:
            self._transmits = self._in_chip = False  # the chip has gone into reset mode by itself
        self._tell(EventKind.STATE)

    def _receive(self) -> None:
        """Take every frame out of the FIFO."""
        read, write, box, host = self._read, self._write, self._incoming, self.host
        while read(m.SR) & m.SR_RBS:
            take_frame(read, box)
            write(m.CMR, m.CMR_RRB)
            self._received += 1
            if host is not None:
                host.received(box, self._now())

    def _tell(
        self,
        kind: EventKind,
        error: ErrorKind = ErrorKind.NONE,
        *,
        bit: int = -1,
        transmitting: bool = False,
        code: int = 0,
    ) -> None:
        if self.host is not None:
            self.host.event(int(kind), int(error), bit, transmitting, self._now(), code)
