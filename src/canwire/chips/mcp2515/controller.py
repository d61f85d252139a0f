"""The MCP2515 CAN controller, register by register and instruction by instruction.

The map is data (register_map.py); here is what reads, writes and the other instructions bring about. Its modes are
modes.py's, the side towards the bus is link.py's.
Source: Microchip DS20001801 (MCP2515 data sheet).

Interpretations [INT] where the data sheet is silent, besides those of the other two files:
- An instruction takes effect immediately, with its last byte; SPI itself takes no time.
- A transmit buffer whose TXREQ is set keeps its bytes whatever is written; TXP may change.
- At power-up, registers and RAM are 0 where the data sheet says x; RESET leaves them as they are.
- The pins TXnRTS, RXnBF and CLKOUT are modelled; SOF on CLKOUT is not.
"""

from __future__ import annotations

from typing import Any

from canwire.bus.can.node import SENDING
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.modes import Modes, timing_of
from canwire.chips.registers import after_reset
from canwire.errors import BadValue

_CANSTAT, _CANCTRL, _CANINTE, _CANINTF, _EFLG = m.CANSTAT, m.CANCTRL, m.CANINTE, m.CANINTF, m.EFLG
_CNF = (m.CNF1, m.CNF2, m.CNF3)
_LARGEST_COUNT = 0xFF
_CLOCK_DIVIDERS = (1, 2, 4, 8)


class Mcp2515(Modes):
    """One controller; `read`, `write` and `modify` take the chip's own addresses.

    `bus` is a CanBus, a lab's bus, or None: CanBus.attach(chip) puts it on the copper later. `oscillator_hz` must
    be even; `oscillator_ppm`, how far the crystal is off, takes effect when configuration mode is left next.
    `on_interrupt` is called when INT becomes active, from inside a write or the bus's calls; it may read and write.
    Raises BadTiming for an impossible oscillator.
    """

    def __init__(self, bus: Any = None, oscillator_hz: int = 16_000_000) -> None:
        timing_of(0, 0, 0, oscillator_hz)
        super().__init__(oscillator_hz)
        self.rts_levels = 0b111  # of the TXnRTS pins, pulled up
        self.reset()
        if bus is not None:
            getattr(bus, "wire", bus).attach(self)

    # instructions

    def reset(self) -> None:
        """RESET, or the RESET pin: enter configuration mode, clear requests and flags."""
        self._leave_bus()
        for register in m.MAP.registers:
            at = register.address
            self.cells[at] = after_reset(register.after_hardware, self.cells[at])
        self.mode = self._wanted = m.CONFIGURATION
        self._forget_counters()
        self._aborting = [False] * m.TX_BUFFERS
        self.offer = None
        self._signal()

    def read(self, address: int) -> int:
        """READ of one register; reading changes nothing."""
        at = m.canonical(address)
        if at == _CANSTAT:
            return self.mode << m.REQOP_SHIFT | self._icod() << 1
        if at == m.TEC:
            return min(self.confinement.tec, _LARGEST_COUNT)
        if at == m.REC:
            return self.confinement.rec
        if at == m.TXRTSCTRL:
            return self.cells[at] | self._rts_inputs()
        if at in m.HIDDEN and self.mode != m.CONFIGURATION:
            return 0
        return self.cells[at]

    peek = read

    def write(self, address: int, value: int) -> None:
        """WRITE of one register's low eight bits; read-only bits stay unchanged."""
        self.modify(m.canonical(address), 0xFF, value, written=True)

    def modify(self, address: int, mask: int, value: int, *, written: bool = False) -> None:
        """BIT MODIFY: change the bits in `mask`; registers that do not support it get all bits of `value`."""
        at = m.canonical(address)
        if at not in m.MODIFIABLE or written:
            mask = 0xFF
        mask &= m.WRITABLE.get(at, 0)
        if not mask or (at in m.AT_REST and self.mode != m.CONFIGURATION):
            return
        before = self.cells[at]
        after = (before & ~mask) | (value & mask)
        if at == _CANCTRL:
            self._control(after, mask)
        elif at == _CANINTF:
            self._flags(after)
        elif at in m.TXBCTRL:
            self._transmit_control(m.TXBCTRL.index(at), after)
        elif not (m.TXBCTRL[0] <= at < m.RXBCTRL[0] and self.cells[at & 0xF0] & m.TX_TXREQ):
            self.cells[at] = after
            if at == m.RXBCTRL[0]:
                self.cells[at] = (after & ~m.RX_BUKT1) | (m.RX_BUKT1 if after & m.RX_BUKT else 0)
            elif at == _CANINTE:
                self._wake_if_flagged()
        self._signal()

    def load_buffer(self, buffer: int, data: bytes) -> None:
        """LOAD TX BUFFER: up to 13 bytes from SIDH on, into a buffer (0 to 2) with no pending request."""
        if not 0 <= buffer < m.TX_BUFFERS or len(data) > m.BUFFER_SIZE:
            raise BadValue(f"buffer {buffer}, {len(data)} bytes: buffers 0..2 take {m.BUFFER_SIZE} bytes")
        at = m.TXBCTRL[buffer]
        if self.cells[at] & m.TX_TXREQ:
            return
        self.cells[at + m.SIDH : at + m.SIDH + len(data)] = data
        self.cells[at + m.SIDL] &= m.WRITABLE[m.TXBCTRL[0] + m.SIDL]
        self.cells[at + m.DLC] &= m.WRITABLE[m.TXBCTRL[0] + m.DLC]

    def read_buffer(self, buffer: int) -> bytes:
        """READ RX BUFFER: all 13 bytes from SIDH on of buffer 0 or 1; clears its RXnIF."""
        if not 0 <= buffer < m.RX_BUFFERS:
            raise BadValue(f"receive buffer {buffer}: 0 or 1")
        at = m.RXBCTRL[buffer] + m.SIDH
        data = bytes(self.cells[at : at + m.BUFFER_SIZE])
        self.cells[_CANINTF] &= ~m.INT_RX[buffer]
        self._signal()
        return data

    def request_to_send(self, buffers: int) -> None:
        super().request_to_send(buffers)
        self._progress()

    def read_status(self) -> int:
        """READ STATUS: RX0IF, RX1IF, and of each transmit buffer TXREQ and TXnIF, from bit 0 up."""
        flags = self.cells[_CANINTF]
        status = flags & (m.INT_RX0 | m.INT_RX1)
        for number, at in enumerate(m.TXBCTRL):
            status |= (1 if self.cells[at] & m.TX_TXREQ else 0) << 2 + 2 * number
            status |= (1 if flags & m.INT_TX[number] else 0) << 3 + 2 * number
        return status

    def rx_status(self) -> int:
        """RX STATUS: which buffers are full, what kind of frame is in the first of them, and by which filter."""
        flags = self.cells[_CANINTF] & (m.INT_RX0 | m.INT_RX1)
        if not flags:
            return 0
        buffer = 0 if flags & m.INT_RX0 else 1
        at = m.RXBCTRL[buffer]
        extended = self.cells[at + m.SIDL] & m.SIDL_EXIDE
        remote = self.cells[at] & m.RX_RXRTR
        hit = self.cells[at] & (m.RX_FILHIT if buffer else m.RX_FILHIT0)
        if buffer and hit < 2:  # rolled over
            hit += 6
        return flags << 6 | (0x10 if extended else 0) | (0x08 if remote else 0) | hit

    # pins

    def set_rts(self, pin: int, high: bool) -> None:
        """Set the level at TXnRTS; a falling edge requests transmission if TXRTSCTRL enables that."""
        before = self.rts_levels >> pin & 1
        self.rts_levels = (self.rts_levels & ~(1 << pin)) | (high << pin)
        if before and not high and self.cells[m.TXRTSCTRL] >> pin & m.RTS_RTSM:
            self.request_to_send(1 << pin)

    def buffer_full_pin(self, pin: int) -> bool | None:
        """The level at RXnBF: high, low, or None while it is switched off."""
        control = self.cells[m.BFPCTRL] >> pin
        if not control & m.BFP_BFE:
            return None
        if control & m.BFP_BFM:
            return not self.cells[_CANINTF] & m.INT_RX[pin]
        return bool(control & m.BFP_BFS)

    @property
    def clkout_hz(self) -> float:
        """Frequency at CLKOUT, 0 when it is switched off or the chip sleeps."""
        control = self.cells[_CANCTRL]
        if self.asleep or not control & m.CTRL_CLKEN:
            return 0.0
        return self.oscillator_hz / _CLOCK_DIVIDERS[control & m.CTRL_CLKPRE]

    # what a write brings about

    def _icod(self) -> int:
        pending = self.cells[_CANINTF] & self.cells[_CANINTE]
        for code, flag in enumerate(m.ICOD_ORDER, 1):
            if pending & flag:
                return code
        return 0

    def _rts_inputs(self) -> int:
        """Levels of the TXnRTS pins that are plain inputs, in the positions of TXRTSCTRL."""
        return (self.rts_levels & ~self.cells[m.TXRTSCTRL] & 7) * m.RTS_RTS

    def _control(self, value: int, mask: int) -> None:
        self.cells[_CANCTRL] = value
        if value & m.CTRL_ABAT:
            for number in range(m.TX_BUFFERS):
                self._abort(number, m.TX_ABTF)
        if mask >> m.REQOP_SHIFT:
            self._ask_mode(value >> m.REQOP_SHIFT)
        self._progress()

    def _flags(self, value: int) -> None:
        if self.cells[_EFLG] & m.EFLG_OVERFLOWS:
            value |= self.cells[_CANINTF] & m.INT_ERR
        self.cells[_CANINTF] = value
        self._wake_if_flagged()

    def _transmit_control(self, number: int, value: int) -> None:
        at = m.TXBCTRL[number]
        pending = self.cells[at] & m.TX_TXREQ
        self.cells[at] = (self.cells[at] & ~m.TX_TXP) | (value & m.TX_TXP)
        if value & m.TX_TXREQ:
            self.request_to_send(1 << number)
            return
        if pending:
            self._abort(number, 0)
        self._kick()
        self._progress()

    def _abort(self, number: int, flag: int) -> None:
        """Abort a pending frame; one that is on the wire continues, but is not repeated if it fails."""
        if not self.cells[m.TXBCTRL[number]] & m.TX_TXREQ:
            return
        box = self._boxes[number]
        if self._looping is box:
            self._aborting[number] = True
            return
        if self.contending is box and self.bus is not None:
            self.bus.interrupt()  # down to the bit, to know whether it is still in arbitration
            if self._number(box) < 0:
                return
            if self.bus.activity(self) == SENDING:
                self._aborting[number] = True
                return
        self._finish(number, flag)
