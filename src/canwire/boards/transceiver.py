"""The transceiver between the output pins of an SJA1000 and its bus: pins that float drive nothing (rulings.md 41).

OCR decides when the chip leaves reset mode. With both pins floating no other node sees what the chip sends: the chip
receives its own frames, gets no acknowledge, and neither acknowledges nor disturbs the frames of others. It still
receives those, except while it sends.
The chip is then alone on a private stub bus, and an `Ear` replaces it on the real bus.
"""

from __future__ import annotations

from canwire.bus.can.bus import CanBus
from canwire.bus.can.node import Mailbox, Node
from canwire.chips.sja1000.controller import Sja1000
from canwire.chips.sja1000.output import FLOAT
from canwire.timeline import Timeline

_TIMING = ("bit_ps", "sample_ps", "quantum_ps", "phase1_ps", "jump_ps")


class Transceiver:
    """The transceiver of one chip; checks the chip's pins whenever it leaves reset mode."""

    def __init__(self, chip: Sja1000, timeline: Timeline) -> None:
        self._chip = chip
        self._timeline = timeline
        self._home: CanBus | None = None  # where the chip belongs while it is on the stub
        self._stub: CanBus | None = None
        self._ear = Ear(chip)
        chip.transceiver = self

    def look(self) -> None:
        """Connect the chip to its bus or to the stub, by the present value of OCR; it leaves reset mode."""
        if self._chip.output_pins(True) != (FLOAT, FLOAT):
            self.go_home()
            return
        bus = self._chip.bus
        if self._home is None and isinstance(bus, CanBus):
            self._home = bus
            self._stub = CanBus(self._timeline, f"{self._chip.name} (outputs float)")
            bus.detach(self._chip)
            self._stub.attach(self._chip)
            bus.attach(self._ear)
        self._ear.begin(self._timeline.now_ns)

    def go_home(self) -> None:
        """Put the chip itself back on its bus; does nothing if it is there already."""
        home, stub = self._home, self._stub
        if home is None or stub is None:
            return
        self._home = self._stub = None
        stub.detach(self._chip)
        self._timeline.remove(stub)
        home.detach(self._ear)
        home.attach(self._chip)


class Ear(Node):
    """Receives from the bus for the chip, while the chip runs."""

    def __init__(self, chip: Sja1000) -> None:
        super().__init__()
        self.listen_only = True
        self._chip = chip

    def begin(self, now_ns: int) -> None:
        """Start to receive with the chip's bit timing, once there were 11 recessive bits."""
        for name in _TIMING:
            setattr(self, name, getattr(self._chip, name))
        self.on_bus = False
        self.waiting, self.sequences = 1, 0
        self.waiting_from_ns, self.waiting_from_ps = now_ns, 0
        if self.bus is not None:
            self.bus.changed()

    def received(self, box: Mailbox, at_ns: int) -> None:
        if self._chip.on_bus and self._chip.contending is None:
            self._chip.received(box, at_ns)

    def joined(self, at_ns: int) -> None:
        self.on_bus = True
        self.waiting = 0
        if self.bus is not None:
            self.bus.changed()

    def error(self, kind: int, bit: int, transmitting: bool, rule: int, at_ns: int) -> None:
        if self._chip.on_bus and self._chip.contending is None:
            self._chip.segment, self._chip.read_dominant = self.segment, self.read_dominant
            self._chip.error(kind, bit, False, rule, at_ns)

    def count(self, rule: int, at_ns: int) -> None:
        """Does nothing: an ear has no counters, and reports no errors."""
