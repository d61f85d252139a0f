"""The MCP2515's side towards the bus: frames in and out, errors, counters, interrupts.

Modes (modes.py) and Mcp2515 (controller.py) add the side towards the processor.
Source: DS20001801 chapters 3, 4, 6 and 7.

Interpretations [INT] where the data sheet is silent:
- TXREQ is 1 until an aborted frame on the wire has ended. A request while ABAT is set is aborted immediately.
- TXnIF reports success alone; an arbitration loss with OSM set shows in TXBnCTRL only.
- ERRIF follows every change of EFLG's state bits, for the better too; what cannot be cleared because "the condition
  still prevails" (7.7) is ERRIF while an overflow flag is set.
- In bus-off TEC reads 255. Frames that are to be sent stay so, and go out after recovery.
- A received frame is stored at the sample point of the last EOF bit but one, where ISO 11898-1 has a receiver take it
  as valid.
- Bytes of a receive buffer beyond a frame's own are 0. RXM = 11 does not take in frames that end in an error.
"""

from __future__ import annotations

from canwire.bus.can import bits as can_bits
from canwire.bus.can.node import Mailbox
from canwire.chips.confinement import BUS_OFF_LIMIT, PASSIVE_LIMIT, WARNING_LIMIT, Confinement
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.filter import Acceptance
from canwire.chips.mcp2515.frames import DLC_SHIFT, EXTENDED, RECORD, REMOTE, compose, head_of
from canwire.chips.mcp2515.interrupts import InterruptPin

_CANINTF, _CANCTRL, _EFLG, _BUFFER_SIZE = m.CANINTF, m.CANCTRL, m.EFLG, m.BUFFER_SIZE
_TXREQ, _ABTF, _MLOA, _TXERR, _TXP = m.TX_TXREQ, m.TX_ABTF, m.TX_MLOA, m.TX_TXERR, m.TX_TXP
_RX0IF, _RX1IF, _ERRIF = m.INT_RX0, m.INT_RX1, m.INT_ERR
_RX0CTRL, _RX1CTRL = m.RXBCTRL
_RXM_SHIFT, _RXM_ALL, _BUKT = m.RX_RXM_SHIFT, m.RXM_ALL, m.RX_BUKT
_RECORD, _REMOTE, _EXTENDED, _DLC_SHIFT = RECORD, REMOTE, EXTENDED, DLC_SHIFT
_RECOVERY_GROUPS = 128
_EVERY_BUFFER = range(m.TX_BUFFERS)


class BusSide(InterruptPin):
    """The bus side of an MCP2515.

    `mode` is OPMOD. In bus-off `bus_off` is True.
    """

    def __init__(self) -> None:
        super().__init__()
        self.attentive = self.validates_early = True
        self.acceptance = Acceptance()
        self.confinement = Confinement()
        self.mode = m.CONFIGURATION
        self.bus_off = False
        self.frames_sent = 0
        self.errors = 0
        self.overflows = 0  # frames lost for want of a free receive buffer; no register counts them
        self._boxes = [Mailbox() for _ in _EVERY_BUFFER]
        self._spares = [Mailbox() for _ in _EVERY_BUFFER]  # a newly loaded frame is never the one on the wire
        self._aborting = [False] * m.TX_BUFFERS
        self._inside = 0  # the bus is calling: an offer needs no `poll`

    # the bus's calls

    def received(self, box: Mailbox, at_ns: int) -> None:
        self._inside += 1
        self.frames_received += 1
        self._take_in(box)
        self._settle()

    def transmitted(self, box: Mailbox, at_ns: int) -> None:
        self._inside += 1
        if self.confinement.tec:
            self.confinement.transmitted()
            self._weigh()
        self._sent(box)
        self._settle()

    def arbitration_lost(self, box: Mailbox, bit: int, at_ns: int) -> None:
        self._inside += 1
        self._failed(box, _MLOA)
        self._settle()

    def error(self, kind: int, bit: int, transmitting: bool, rule: int, at_ns: int) -> None:
        self._inside += 1
        self.errors += 1
        self.cells[_CANINTF] |= m.INT_MERR
        box = self.contending
        if transmitting and box is not None:
            self._failed(box, _TXERR)
        self.confinement.apply(rule)
        self._weigh()
        self._settle()

    def count(self, rule: int, at_ns: int) -> None:
        self._inside += 1
        self.confinement.apply(rule)
        self._weigh()
        self._settle()

    def joined(self, at_ns: int) -> None:
        self._inside += 1
        self.on_bus = True
        self.waiting = 0
        if self.bus_off:
            self.bus_off = False
            self.confinement.reset()
            self._weigh()
        if self.bus is not None:
            self.bus.changed()
        self._settle()

    # frames in

    def _take_in(self, box: Mailbox) -> None:
        """Store a good frame, if a buffer accepts it and is free."""
        cells = self.cells
        _, id, info, data = _RECORD.unpack_from(box.block)
        extended = info & _EXTENDED != 0
        control = cells[_RX0CTRL]
        if control >> _RXM_SHIFT == _RXM_ALL:
            hit = 0
        else:
            seen = b"" if info & _REMOTE else data[: info >> _DLC_SHIFT & 15]
            hit = self.acceptance.hit(0, control >> _RXM_SHIFT, id, extended, seen)
            if hit < 0:
                hit = self.acceptance.hit(1, cells[_RX1CTRL] >> _RXM_SHIFT, id, extended, seen)
                if hit < 0:
                    return
        full = cells[_CANINTF]
        if hit < 2 and not full & _RX0IF:
            cells[_RX0CTRL] = (
                (control & ~(m.RX_RXRTR | m.RX_FILHIT0)) | (m.RX_RXRTR if info & _REMOTE else 0) | hit
            )
            at, flag = _RX0CTRL, _RX0IF
        elif full & _RX1IF or (hit < 2 and not control & _BUKT):
            self._overflow(m.EFLG_RX0OVR if hit < 2 and not control & _BUKT else m.EFLG_RX1OVR)
            return
        else:
            if hit < 2:
                cells[_RX0CTRL] = (control & ~m.RX_FILHIT0) | hit
            other = cells[_RX1CTRL] & ~(m.RX_RXRTR | m.RX_FILHIT)
            cells[_RX1CTRL] = other | (m.RX_RXRTR if info & _REMOTE else 0) | hit
            at, flag = _RX1CTRL, _RX1IF
        cells[at + 1 : at + 1 + _BUFFER_SIZE] = head_of(id, info) + data
        cells[_CANINTF] = full | flag

    def _overflow(self, flag: int) -> None:
        self.overflows += 1
        self.cells[_EFLG] |= flag
        self.cells[_CANINTF] |= _ERRIF

    # frames out

    def request_to_send(self, buffers: int) -> None:
        """RTS: set TXREQ of the transmit buffers whose bits (0 to 2) are set."""
        for number in _EVERY_BUFFER:
            if buffers >> number & 1:
                self._request(number)
        self._kick()

    def _request(self, number: int) -> None:
        """Request the transmission of a buffer's frame; the caller then calls `_kick`."""
        at = m.TXBCTRL[number]
        cells = self.cells
        if cells[at] & _TXREQ:
            return
        cells[at] = (cells[at] & _TXP) | (_ABTF if cells[_CANCTRL] & m.CTRL_ABAT else _TXREQ)
        self._aborting[number] = False
        if cells[at] & _ABTF:
            return
        self._boxes[number], self._spares[number] = self._spares[number], self._boxes[number]
        box = self._boxes[number]
        compose(box, cells, at)
        can_bits.measure(box, 0)
        box.ready_ns = self._now_ns()

    def _kick(self) -> None:
        """Update the offer, as the pending frames may have changed."""
        self._make_offer()
        bus = self.bus
        if self.offer is not None and bus is not None and not self._inside:
            bus.poll(self)

    def _make_offer(self) -> None:
        """Offer the frame with the highest TXP; of equal ones that of the highest buffer number (3.2)."""
        cells = self.cells
        offer = None
        highest = 0
        for number in _EVERY_BUFFER:
            control = cells[0x30 + 16 * number]
            if control & _TXREQ and control & _TXP >= highest:
                highest = control & _TXP
                offer = self._boxes[number]
        self.offer = offer

    def _sent(self, box: Mailbox) -> None:
        """Count a transmitted frame and free its buffer."""
        self.frames_sent += 1
        number = self._number(box)
        if number >= 0:
            self.cells[_CANINTF] |= m.INT_TX0 << number
            self._finish(number, 0)

    def _failed(self, box: Mailbox, flag: int) -> None:
        """Note a lost arbitration or an error; in one-shot mode or after an abort the frame is not repeated."""
        number = self._number(box)
        if number < 0:
            return
        self.cells[m.TXBCTRL[number]] |= flag
        control = self.cells[_CANCTRL]
        if control & m.CTRL_OSM or self._aborting[number]:
            self._finish(number, _ABTF if control & (m.CTRL_OSM | m.CTRL_ABAT) else 0)

    def _finish(self, number: int, flag: int) -> None:
        at = m.TXBCTRL[number]
        self.cells[at] = (self.cells[at] & ~_TXREQ) | flag
        self._aborting[number] = False
        self._make_offer()

    def _number(self, box: Mailbox) -> int:
        """The number of the transmit buffer of this frame; -1 if it is no longer pending."""
        for number in _EVERY_BUFFER:
            if self._boxes[number] is box and self.cells[0x30 + 16 * number] & _TXREQ:
                return number
        return -1

    # what the counters make of it

    def _weigh(self) -> None:
        """Update EFLG, error passive and bus-off from the counters."""
        tec, rec = self.confinement.tec, self.confinement.rec
        flags = 0
        if tec or rec:
            if tec >= WARNING_LIMIT:
                flags |= m.EFLG_TXWAR | m.EFLG_EWARN
            if rec >= WARNING_LIMIT:
                flags |= m.EFLG_RXWAR | m.EFLG_EWARN
            if tec >= PASSIVE_LIMIT:
                flags |= m.EFLG_TXEP
            if rec >= PASSIVE_LIMIT:
                flags |= m.EFLG_RXEP
            if tec >= BUS_OFF_LIMIT:
                flags |= m.EFLG_TXBO
        self.passive = flags & (m.EFLG_TXEP | m.EFLG_RXEP) != 0 and tec < BUS_OFF_LIMIT
        self.tainted = rec > 0 and tec < BUS_OFF_LIMIT
        before = self.cells[_EFLG]
        if flags != before & ~m.EFLG_OVERFLOWS:
            self.cells[_EFLG] = (before & m.EFLG_OVERFLOWS) | flags
            self.cells[_CANINTF] |= _ERRIF
            if flags & m.EFLG_TXBO and not self.bus_off:
                self._go_bus_off()

    def _go_bus_off(self) -> None:
        """Leave the bus; the chip recovers by itself after 128 times 11 recessive bits."""
        self.bus_off = True
        self._wait(_RECOVERY_GROUPS)

    def _wait(self, groups: int, from_ns: int = 0) -> None:
        """Leave the bus until `groups` groups of 11 recessive bits have passed."""
        if self.bus is not None:
            self.bus.interrupt()
        self.on_bus = False
        self.waiting = groups
        self.sequences = 0
        self.waiting_from_ns, self.waiting_from_ps = max(from_ns, self._now_ns()), 0
        if self.bus is not None:
            self.bus.changed()

    def _now_ns(self) -> int:
        return 0 if self.bus is None else self.bus.timeline.now_ns

    # afterwards

    def _settle(self) -> None:
        """End a call of the bus: change the mode if possible, then let the handler of INT access registers."""
        try:
            self._progress()
            self._signal()
        finally:
            self._inside -= 1

    def _progress(self) -> None:
        """Enter a requested mode if that is possible now."""
