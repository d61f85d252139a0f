"""The SJA1000's side towards the bus: frames in and out, errors, counters, captures.

Sja1000 (controller.py) adds the side towards the processor. Source: data sheet 6.4; reference/sja1000.md sections
4 to 8.

Interpretations [INT] where the data sheet is silent:
- A received frame is stored at the sample point of the last EOF bit but one, whatever the last one is.
- TS and RS last to the end of the intermission; TS is also 1 in an error or overload frame that the chip takes part in.
- Beside errors in frames, ECC captures bit errors in active error and overload flags, and every eighth dominant bit
  that is tolerated behind a flag (form error, 0x13); the first dominant bit behind a flag only counts.
- A sender that sees a dominant bit in a delimiter or in EOF captures a bit error, a receiver a form error, even where
  it was about to report a wrong CRC.
- RXERR stops at 255, and is 127 after a reception that finds it above.
- At the end of bus-off there is EI, but no EPI.
"""

from __future__ import annotations

from canwire import _mem
from canwire.bus.can import bits as can_bits
from canwire.bus.can.node import (
    FLAG_BIT_ERROR_RECEIVER,
    FLAG_BIT_ERROR_TRANSMITTER,
    LONG_DOMINANT_RECEIVER,
    LONG_DOMINANT_TRANSMITTER,
    Mailbox,
    Node,
)
from canwire.chips.confinement import Confinement
from canwire.chips.sja1000.cells import CELLS, ONES
from canwire.chips.sja1000.fifo import ReceiveFifo
from canwire.chips.sja1000.filter import AcceptanceFilter
from canwire.chips.sja1000.interrupts import Interrupts
from canwire.chips.sja1000.register_map import (
    ALC,
    ECC,
    ECC_FORM,
    ECC_RX,
    EWLR,
    IR_ALI,
    IR_BEI,
    IR_DOI,
    IR_EI,
    IR_EPI,
    IR_RI,
    IR_TI,
    SR,
    SR_BS,
    SR_DOS,
    SR_ES,
    SR_RBS,
    SR_TBS,
    SR_TCS,
    TX_RAM,
)

_SR, _ALC, _ECC, _EWLR, _TX_RAM = SR, ALC, ECC, EWLR, TX_RAM
_BS, _ES, _TCS, _TBS, _DOS, _RBS = SR_BS, SR_ES, SR_TCS, SR_TBS, SR_DOS, SR_RBS
_RI, _TI, _EI, _DOI, _EPI, _ALI, _BEI = IR_RI, IR_TI, IR_EI, IR_DOI, IR_EPI, IR_ALI, IR_BEI
_FORM_KIND, _CRC_KIND, _DELIMITER_PART, _TOLERATED_PART = 2, 6, 0x17, 0x13
_FORM, _RECEIVING = ECC_FORM, ECC_RX
_TYPES = bytes((0xC0, 0x80, 0x40, 0xC0, 0x00, 0x00, 0xC0))  # of ECC, by ErrorKind
_LONG_TRANSMITTER, _LONG_RECEIVER = LONG_DOMINANT_TRANSMITTER, LONG_DOMINANT_RECEIVER
_FLAG_TRANSMITTER, _FLAG_RECEIVER = FLAG_BIT_ERROR_TRANSMITTER, FLAG_BIT_ERROR_RECEIVER
_BASIC_WARNING_LIMIT, _BUS_OFF_LIMIT = 96, 256
_BUS_OFF_TXERR = 127
_EXTENDED_INFO, _REMOTE_INFO = 1 << 23, 1 << 22


class BusSide(Node):
    """The bus side of an SJA1000.

    `cells` are its bytes (cells.py), `cells[SR]` without TS and RS. `confinement` holds its counters; in
    bus-off `bus_off` is True and TXERR shows its TEC.
    """

    def __cinit__(self, *_: object, **__: object) -> None:
        """Compiled: nothing that C reads is None, not even in what was never initialised."""
        self._take_parts()

    def __init__(self) -> None:
        super().__init__()
        self.attentive = self.validates_early = True
        self._take_parts()
        self.pelican = self.bus_off = False
        self.frames_sent = self.errors = 0
        self._self_reception = False
        self._alc_free = self._ecc_free = True
        self._inside = 0  # the bus is calling: an offer needs no `poll`

    def _take_parts(self) -> None:
        self.cells = bytearray(CELLS)
        self.cells[ONES] = 0xFF
        self.interrupts = Interrupts()
        self.fifo = ReceiveFifo(self.cells)
        self.filter = AcceptanceFilter()
        self.confinement = Confinement()
        self._box = Mailbox()
        self._spare = Mailbox()  # so that a newly loaded frame is never taken for the one on the wire

    # the bus's calls

    def received(self, box: Mailbox, at_ns: int) -> None:
        self._inside += 1
        self.frames_received += 1
        self._take_in(box.words)
        self._settle()

    def transmitted(self, box: Mailbox, at_ns: int) -> None:
        if self.offer is not box:
            return  # somebody who received it has reset this chip at that very moment
        self._inside += 1
        self.frames_sent += 1
        if self.confinement.tec:
            self.confinement.transmitted()
            self._weigh()
        self.offer = None
        self.cells[_SR] |= _TCS | _TBS
        self.interrupts.request(_TI)
        if self._self_reception:
            self._take_in(box.words)
        else:
            self.fifo.compose(box.words, self.pelican)
            self.fifo.show()
        self._settle()

    def arbitration_lost(self, box: Mailbox, bit: int, at_ns: int) -> None:
        self._inside += 1
        if self._alc_free:
            self._alc_free = False
            self.cells[_ALC] = bit
            self.interrupts.request(_ALI)
        if box is self.offer and box.single_shot:
            self._give_up()
        self._settle()

    def error(self, kind: int, bit: int, transmitting: bool, rule: int, at_ns: int) -> None:
        self._inside += 1
        self.errors += 1
        found = _TYPES[kind]
        if kind == _FORM_KIND and transmitting and self.segment != _DELIMITER_PART:
            found = 0
        elif kind == _CRC_KIND and self.read_dominant:
            found = _FORM
        self._capture(found | self.segment | (0 if transmitting else _RECEIVING))
        offer = self.offer
        if transmitting and offer is not None and offer.single_shot and self.contending is offer:
            self._give_up()
        self.confinement.apply(rule)
        self._weigh()
        self._settle()

    def count(self, rule: int, at_ns: int) -> None:
        self._inside += 1
        if rule == _FLAG_TRANSMITTER or rule == _FLAG_RECEIVER:
            self._capture(self.segment | (0 if rule == _FLAG_TRANSMITTER else _RECEIVING))
        elif rule == _LONG_TRANSMITTER or rule == _LONG_RECEIVER:
            self._capture(_FORM | _TOLERATED_PART | (0 if rule == _LONG_TRANSMITTER else _RECEIVING))
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
            self.tainted = False
            self.cells[_SR] &= ~(_BS | _ES)
            self.interrupts.request(_EI)
            self._weigh()
        if self.bus is not None:
            self.bus.changed()
        self._settle()

    # what follows from them

    def _take_in(self, words: _mem.Words) -> None:
        """Store a good frame, if it passes the filter and fits."""
        if not self.filter.accepts(words):
            return
        self.fifo.compose(words, self.pelican)
        status = self.cells[_SR]
        if self.fifo.store():
            if not status & _RBS:
                self.cells[_SR] = status | _RBS
                self.interrupts.request(_RI)
        elif not status & _DOS:
            self.cells[_SR] = status | _DOS
            self.interrupts.request(_DOI)

    def _capture(self, code: int) -> None:
        """Capture a bus error in ECC and BEI, which keep the first one until ECC is read."""
        if self._ecc_free:
            self._ecc_free = False
            self.cells[_ECC] = code
            self.interrupts.request(_BEI)

    def _weigh(self) -> None:
        """Update error status, error passive and bus-off from the counters."""
        tec, rec = self.confinement.tec, self.confinement.rec
        if tec >= _BUS_OFF_LIMIT:
            self._go_bus_off()
            return
        limit = self.cells[_EWLR] if self.pelican else _BASIC_WARNING_LIMIT
        status = self.cells[_SR]
        warned = _ES if tec >= limit or rec >= limit else 0
        if warned != status & _ES:
            self.cells[_SR] = status ^ _ES
            self.interrupts.request(_EI)
        passive = tec > 127 or rec > 127
        if passive != self.passive:
            self.passive = passive
            self.interrupts.request(_EPI)
        self.tainted = rec > 0

    def _go_bus_off(self) -> None:
        """Enter reset mode with TXERR 127, RXERR 0; recovery begins when the processor clears RM."""
        self.bus_off = True
        self._enter_reset()
        self.confinement.reset()
        self.confinement.tec = _BUS_OFF_TXERR
        self.passive = self.tainted = False
        self.cells[_SR] |= _BS | _ES
        self.interrupts.request(_EI)

    def _enter_reset(self) -> None:
        raise NotImplementedError

    def _give_up(self) -> None:
        """End the transmission request without success."""
        self.offer = None
        self.cells[_SR] |= _TBS
        self.interrupts.request(_TI)

    def _settle(self) -> None:
        """End a call of the bus; now the handler of INT may read and write registers."""
        try:
            self.interrupts.settle()
        finally:
            self._inside -= 1

    # frames out

    def _request(self, self_reception: bool, single_shot: bool) -> None:
        """Request the transmission of the frame in the transmit buffer."""
        status = self.cells[_SR]
        offer = self.offer
        if not status & _TBS:
            if single_shot and offer is not None:
                offer.single_shot = True
            return
        self._box, self._spare = self._spare, self._box
        box = self._box
        self._compose(box.words)
        box.single_shot = single_shot
        can_bits.measure(box, 0)
        self._self_reception = self_reception
        self.cells[_SR] = status & ~(_TBS | _TCS)
        bus = self.bus
        box.ready_ns = 0 if bus is None else bus.timeline.now_ns
        self.offer = box
        if bus is not None and not self._inside:
            bus.poll(self)

    def _compose(self, words: _mem.Words) -> None:
        """Write the frame in the transmit buffer to a record."""
        cells = self.cells
        at = _TX_RAM
        first, second = cells[at], cells[at + 1]
        remote = 0
        info = 0
        if not self.pelican:
            identifier = first << 3 | second >> 5
            dlc = second & 15
            remote = second & 0x10
            at += 2
        elif first & 0x80:
            identifier = second << 21 | cells[at + 2] << 13 | cells[at + 3] << 5 | cells[at + 4] >> 3
            info = _EXTENDED_INFO
            at += 5
        else:
            identifier = second << 3 | cells[at + 2] >> 5
            at += 3
        if self.pelican:
            dlc = first & 15
            remote = first & 0x40
        if remote:
            info |= _REMOTE_INFO
        length = 0 if remote else dlc if dlc < 8 else 8
        head = info | dlc << 16
        words[0] = 0
        words[1] = identifier | head << 32
        data = 0
        for k in range(length):
            octet = cells[at + length - 1 - k]
            data = data << 8 | octet
        words[2] = data
