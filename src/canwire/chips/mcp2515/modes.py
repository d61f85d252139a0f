"""The MCP2515's modes: configuration, normal, listen-only, loop-back, sleep, and the way from one to another.

Source: DS20001801 chapter 10; 5 for the bit timing; 8.1 for the start-up time of the oscillator.

Interpretations [INT] where the data sheet is silent:
- A mode changes when no frame is to be sent (in a mode that sends) and none is on the wire; configuration mode is left
  for 11 recessive bits. From normal to listen-only mode and back the bus is not left. A REQOP of 5 to 7 is none.
- Listen-only mode has no counters, so it ends bus-off, too.
- Sleep is only left by bus activity or WAKIF, each with WAKIE set; WAKIF may have been set before (docs/mcp2515.md).
  REQOP keeps what was written, and counts again when it is written. A chip that has been woken waits for 128 periods
  of its oscillator and 11 recessive bits.
- In loop-back mode a frame takes as long as on the wire, intermission included.
- A PHSEG2 of one quantum counts as two. With SAM set a bit is what two of three samples are, the last at the sample
  point, half a quantum apart. WAKFIL and SOF change nothing.
"""

from __future__ import annotations

from functools import partial

from canwire.bus.can.node import RECEIVING, Mailbox
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.link import BusSide
from canwire.timeline import Timer
from canwire.values.timing.bit_timing import BitTiming
from canwire.values.timing.check import NodeTiming

_NORMAL, _SLEEP, _LOOP_BACK, _LISTEN_ONLY, _CONFIGURATION = (
    m.NORMAL, m.SLEEP, m.LOOP_BACK, m.LISTEN_ONLY, m.CONFIGURATION,
)  # fmt: skip
_START_UP_PERIODS = 128
_LOOK_AGAIN_BITS = 2  # an intermission has three, which a busy bus rests for
_INTERMISSION = 3


def timing_of(cnf1: int, cnf2: int, cnf3: int, oscillator_hz: int) -> BitTiming:
    """The bit timing in CNF1 to CNF3; a quantum is 2 (BRP + 1) periods of the oscillator."""
    phase1 = (cnf2 >> m.CNF2_PHSEG1_SHIFT & 7) + 1
    prop = (cnf2 & m.CNF2_PRSEG) + 1
    phase2 = (cnf3 & m.CNF3_PHSEG2) + 1 if cnf2 & m.CNF2_BTLMODE else phase1
    return BitTiming(
        (cnf1 & m.CNF1_BRP) + 1,
        prop + phase1,
        max(phase2, m.SHORTEST_PHASE2),
        (cnf1 >> m.CNF1_SJW_SHIFT) + 1,
        oscillator_hz // 2,
        prop,
        cnf2 & m.CNF2_SAM != 0,
    )


class Modes(BusSide):
    """The chip's present mode, and the requested one.

    `oscillator_ppm`, how far the crystal is off, takes effect when configuration mode is left next.
    """

    def __init__(self, oscillator_hz: int) -> None:
        super().__init__()
        self.oscillator_hz = oscillator_hz
        self.oscillator_ppm = 0.0
        self._wanted = _CONFIGURATION
        self._looking = False
        self._looping: Mailbox | None = None
        self._loop_timer: Timer | None = None

    def woken(self, at_ns: int) -> None:
        if self.asleep and self.cells[m.CANINTE] & m.INT_WAK:
            self._wake()
            self._signal()

    def _wake_if_flagged(self) -> None:
        """Wake up if a wake-up interrupt is pending, which prevents sleep."""
        if self.asleep and self.cells[m.CANINTF] & self.cells[m.CANINTE] & m.INT_WAK:
            self._wake()

    def _wake(self) -> None:
        """Start the oscillator; frames on the bus meanwhile are lost."""
        self.asleep = False
        self.cells[m.CANINTF] |= m.INT_WAK
        self.mode = self._wanted = _LISTEN_ONLY
        self.listen_only = True
        self._take_settings()
        started_ns = self._now_ns() + _START_UP_PERIODS * 1_000_000_000 // self.oscillator_hz
        self._wait(1, started_ns)

    def _ask_mode(self, mode: int) -> None:
        """Request the mode that was written to REQOP."""
        if mode <= _CONFIGURATION and not self.asleep:
            self._wanted = mode
            self._progress()

    def _progress(self) -> None:
        if self._looping is None and self.mode == _LOOP_BACK:
            self._loop()
        if self._wanted == self.mode or self.asleep:
            return
        if self.offer is not None and self.mode in (_NORMAL, _LOOP_BACK):
            return
        bus = self.bus
        if bus is not None and self.on_bus and bus.activity(self) >= RECEIVING:
            self._look_later()
            return
        self._enter(self._wanted)

    def _look_later(self) -> None:
        """Check again later: no call reports that the bus is idle after a stored frame or an error."""
        if not self._looking and self.bus is not None:
            self._looking = True
            later_ns = self._now_ns() + _LOOK_AGAIN_BITS * self.bit_ps // 1000
            self.bus.timeline.at(later_ns, self._look)

    def _look(self) -> None:
        self._looking = False
        self._progress()
        self._signal()

    def _enter(self, mode: int) -> None:
        before, self.mode = self.mode, mode
        if mode == _CONFIGURATION:
            self._leave_bus()
            self._forget_counters()
        elif mode == _SLEEP:
            self._leave_bus()
            self.asleep = True
            if self.bus is not None:
                self.bus.changed()
            self._wake_if_flagged()
        elif mode == _LOOP_BACK:
            self._leave_bus()
            self._take_settings()
            self._loop()
        else:
            self._come_on_bus(before, mode == _LISTEN_ONLY)

    def _come_on_bus(self, before: int, listen_only: bool) -> None:
        bus = self.bus
        was_off = self.bus_off
        if bus is not None:
            bus.interrupt()
        self.listen_only = listen_only
        if listen_only:
            self._forget_counters()
        if before not in (_NORMAL, _LISTEN_ONLY):
            self._take_settings()
            self._wait(1)
        elif was_off and listen_only:
            self._wait(1)
        elif bus is not None:
            bus.changed()

    def _forget_counters(self) -> None:
        self.bus_off = False
        self.confinement.reset()
        self.cells[m.EFLG] &= m.EFLG_OVERFLOWS
        self.passive = self.tainted = False

    def _leave_bus(self) -> None:
        """Leave the bus immediately, even in the middle of a bit."""
        if self.bus is not None:
            self.bus.interrupt()
        self.asleep = self.on_bus = self.listen_only = False
        self.waiting = 0
        if self._loop_timer is not None:
            self._loop_timer.cancel()
            self._loop_timer = None
        self._looping = None
        if self.bus is not None:
            self.bus.changed()

    def _take_settings(self) -> None:
        """Apply the settings of configuration mode: filters, and bit times with the present oscillator."""
        cells = self.cells
        self.acceptance.load(cells)
        timing = timing_of(cells[m.CNF1], cells[m.CNF2], cells[m.CNF3], self.oscillator_hz)
        self.timing = NodeTiming("MCP2515", timing, None, self.oscillator_ppm)
        scale = 1.0 / (1.0 + self.oscillator_ppm * 1e-6)
        quantum = timing.quantum_ps
        self.bit_ps = round(timing.bit_time_ps * scale)
        self.sample_ps = round(timing.sample_time_ps * scale)
        self.quantum_ps = round(quantum * scale)
        self.phase1_ps = round(timing.phase1 * quantum * scale)
        self.jump_ps = round(timing.jump * quantum * scale)
        self.sample_gap_ps = self.quantum_ps // 2 if timing.triple_sampling else 0

    # loop-back

    def _loop(self) -> None:
        """Send the next frame to the chip itself."""
        box, bus = self.offer, self.bus
        if box is None or bus is None:
            return
        self._looping = box
        length_ns = (box.bits + _INTERMISSION) * self.bit_ps // 1000
        self._loop_timer = bus.timeline.at(self._now_ns() + length_ns, partial(self._looped, box))

    def _looped(self, box: Mailbox) -> None:
        self._looping = self._loop_timer = None
        self._inside += 1
        self._sent(box)
        self.frames_received += 1
        self._take_in(box)
        self._settle()
