"""Driver of an MCP2515, simulated or real, that uses only the chip's instructions.

Each of the three transmit buffers has its mailbox. Of the loaded ones, the frame with the lowest identifier is sent
first; of frames with the same identifier, the one that was loaded first.
Source: DS20001801.

Limits of the chip:
- It does not report the kind of an error (so ErrorKind.OTHER), nor whose error it was (a guess from TXERR and the
  counters).
- It does not report in which bit arbitration was lost. A lost arbitration shows only once something else happens (the
  winner's frame arrives, an error, success), and only once for each frame.
- One-shot mode applies to all buffers: the driver requests other frames again if they failed because of it.
- It does not report whether a frame is on the wire: an aborted frame that is, is not repeated if it fails.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from canwire.chips.mcp2515 import register_map as m
from canwire.drivers.driver import LineSettings
from canwire.drivers.mcp2515.access import Instructions
from canwire.drivers.mcp2515.confinement import Confined
from canwire.drivers.mcp2515.frames import take_frame
from canwire.drivers.mcp2515.settings import KEPT, USUAL, set_up
from canwire.errors import BadValue, WrongState
from canwire.values.event import ErrorState, EventKind
from canwire.values.register import RegisterValue

if TYPE_CHECKING:
    from canwire.chips.host import Host

_REQOP = 7 << m.REQOP_SHIFT
_ANY_TX = m.INT_TX0 | m.INT_TX1 | m.INT_TX2
_RX0, _RX1, _RECEIVED = m.INT_RX0, m.INT_RX1, m.INT_RX0 | m.INT_RX1
_CANINTF = m.CANINTF


class Mcp2515Driver(Confined):
    """The Driver (drivers/driver.py) of an MCP2515. `now` returns the time in ns; `peek` reads for display."""

    def __init__(
        self,
        host: Host | None,
        access: Instructions,
        now: Callable[[], int],
        *,
        oscillator_hz: int = 16_000_000,
        peek: Callable[[int], int] | None = None,
    ) -> None:
        super().__init__(host, access, now)
        self._peek = peek or access.read
        self._oscillator_hz = oscillator_hz
        self._pending = self._flags
        self._registers = dict(USUAL)
        self._enabled = USUAL[m.CANINTE]
        self._mode = m.NORMAL

    # settings

    def check(self, settings: LineSettings) -> None:
        set_up(settings, self._oscillator_hz)

    def configure(self, settings: LineSettings) -> None:
        self._registers, self._mode = set_up(settings, self._oscillator_hz)
        self._bit_ns = settings.timing.bit_time_ps // 1000
        self.listen_only = settings.listen_only
        self._reset()
        if self.running:
            self._operate()

    # taking part

    def start(self, at_ns: int, integrated: bool = False) -> None:
        """Take part with counters at 0, always after 11 recessive bits: the chip cannot skip them."""
        self._reset()
        self.running = True
        self._off = False
        self._state = ErrorState.ERROR_ACTIVE
        self._operate()
        self.tell(EventKind.STATE)
        self.fill()

    def stop(self, at_ns: int) -> None:
        was_running, self.running = self.running, False
        self._off = False
        self._reset()
        if was_running:
            self.tell(EventKind.STATE)

    def rejoin(self, at_ns: int) -> None:
        """Take part after 11 recessive bits; the only way to make the chip wait for them clears its counters."""
        if self.running and not self._off:
            self._reset()
            self._operate()
            self._state_changed(self._read(m.EFLG))

    def sleep(self, at_ns: int) -> None:
        """Sleep once no frame waits to be sent and the bus is idle; raises WrongState unless running."""
        if not self.running or self._off:
            raise WrongState("a stopped controller cannot sleep; start the line first")
        if not self._dozing:
            self._dozing = True
            self._enabled |= m.INT_WAK
            self._chip.modify(m.CANINTE, m.INT_WAK, m.INT_WAK)
            self._chip.modify(m.CANCTRL, _REQOP, m.SLEEP << m.REQOP_SHIFT)
            self._look_asleep()

    def wake(self, at_ns: int) -> None:
        """Take part again after the start of the oscillator and 11 recessive bits; no effect unless it sleeps."""
        if self._dozing:
            self._look_asleep()
            if self._asleep:
                self._chip.modify(_CANINTF, m.INT_WAK, m.INT_WAK)
                self.service()
            else:
                self._awake()

    def _reset(self) -> None:
        """Enter configuration mode immediately; the chip's buffers are cleared, frames in the mailboxes stay."""
        self._chip.reset()
        self._forget_buffers()
        self._dozing = self._asleep = False
        self._tec = self._rec = 0
        self._enabled = self._registers[m.CANINTE]
        for address, value in self._registers.items():
            self._chip.write(address, value)

    def _operate(self) -> None:
        if self._off:
            return
        self._chip.modify(m.CANCTRL, _REQOP, self._mode << m.REQOP_SHIFT)
        self._transmits = not self.listen_only
        self._send_all()

    def _awake(self) -> None:
        self._dozing = self._asleep = False
        self._chip.modify(m.CANCTRL, _REQOP, self._mode << m.REQOP_SHIFT)

    def _look_asleep(self) -> None:
        """Find out whether a chip that was requested to sleep is asleep."""
        if not self._asleep and self._read(m.CANSTAT) >> m.REQOP_SHIFT == m.SLEEP:
            self._asleep = True
            self.tell(EventKind.SLEEPING)

    # what it says of itself

    def registers(self) -> list[RegisterValue]:
        resetting = self._peek(m.CANSTAT) >> m.REQOP_SHIFT == m.CONFIGURATION
        return [
            RegisterValue(register.name, register.address, value, register.describe(value))
            for register in m.MAP.readable(resetting)
            for value in (self._peek(register.address),)
        ]

    def read_register(self, address: int, reset_mode: bool) -> int:
        """Filters and masks can only be read in configuration mode; entering it clears the error counters."""
        self._check_address(address)
        if not reset_mode or not self.running:
            return self._read(address)
        self._reset()
        value = self._read(address)
        self._operate()
        return value

    def write_register(self, address: int, value: int, reset_mode: bool) -> None:
        self._check_address(address, value)
        if reset_mode and self.running:
            self._reset()
        kept = address in m.AT_REST | KEPT and (reset_mode or not self.running or address not in m.AT_REST)
        if kept:
            self._registers[address] = value
        if address == m.CANINTE:
            self._enabled = value  # before the chip has it, and perhaps calls
        if address == m.EFLG:
            self._tell_overflows(self._read(m.EFLG) & ~value)
        self._chip.write(address, value)
        if reset_mode and self.running:
            self._operate()

    def _check_address(self, address: int, value: int = 0) -> None:
        if not 0 <= address < m.ADDRESSES or not 0 <= value <= 0xFF:
            raise BadValue(f"register {address} = {value}: an MCP2515 has 0..127, each 0..255")

    # interrupts

    def _flags(self) -> int:
        return self._read(_CANINTF) & self._enabled

    def _serve(self, flags: int) -> None:
        if flags & m.INT_WAK:
            self._chip.modify(_CANINTF, m.INT_WAK, 0)
            if self._dozing:
                if not self._asleep:  # nobody has noticed
                    self.tell(EventKind.SLEEPING)
                self._awake()
                self.tell(EventKind.WOKEN)
        if flags & (_RECEIVED | m.INT_MERR):
            self._review(False)  # what was lost was lost before
        if flags & m.INT_MERR:
            self._chip.modify(_CANINTF, m.INT_MERR, 0)
            self._error()
        if flags & _RX0:
            self._receive(0)
        if flags & _RX1:
            self._receive(1)
        if flags & m.INT_ERR:
            self._error_flags()
        if flags & _ANY_TX:
            self._chip.modify(_CANINTF, flags & _ANY_TX, 0)
            for buffer in self._buffers:
                if flags & buffer.flag and buffer.in_chip:
                    self._look_for_loss(buffer, self._read(buffer.control))
                    self._finished(buffer, True)
        if flags & ~_ANY_TX:
            self._review()
        if self._dozing:
            self._look_asleep()

    def _receive(self, number: int) -> None:
        box, host = self._incoming, self.host
        take_frame(self._chip.read_buffer(number), box)
        self._received += 1
        if host is not None:
            host.received(box, self._now())
