"""A bench for SJA1000 chips: one bus, its faults, and time in bits."""

from __future__ import annotations

from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from canwire.timeline import Timeline
from canwire.values.frame import Frame

BIT_NS = 2_000  # BTR0 0x00, BTR1 0x1C at 16 MHz: 500 kbit/s
SETTLED_BITS = 20


class Bench:
    """Chips on one bus; `bitwise` sends everything bit by bit."""

    def __init__(self) -> None:
        self.timeline = Timeline()
        self.bus = CanBus(self.timeline)
        self.faults = Faults(self.bus, 1)

    def bare(self) -> Sja1000:
        """A chip in hardware reset, its timing registers set already (they keep their values)."""
        chip = Sja1000(self.bus)
        chip.write(m.BASIC_BTR0, 0x00)
        chip.write(m.BASIC_BTR1, 0x1C)
        chip.hardware_reset()
        return chip

    def chip(
        self, mode: int = m.MOD_AFM, *, enabled: int = 0xFF, acr: str = "00000000", amr: str = "FFFFFFFF"
    ) -> Sja1000:
        """A PeliCAN chip on the bus."""
        chip = self.bare()
        chip.write(m.CDR, m.CDR_PELICAN)
        chip.write(m.IER, enabled)
        put(chip, m.ACR0, acr)
        put(chip, m.AMR0, amr)
        chip.write(m.MOD, mode)
        self.bits(SETTLED_BITS)
        return chip

    def basic_chip(self, control: int = 0x1E, *, acr: int = 0, amr: int = 0xFF) -> Sja1000:
        """A BasicCAN chip on the bus."""
        chip = self.bare()
        chip.write(m.BASIC_ACR, acr)
        chip.write(m.BASIC_AMR, amr)
        chip.write(m.BASIC_CR, control)
        self.bits(SETTLED_BITS)
        return chip

    def bits(self, count: int) -> None:
        """Let so many bit times pass."""
        self.timeline.run_until(self.timeline.now_ns + count * BIT_NS)


def put(chip: Sja1000, address: int, octets: str) -> None:
    """Write bytes in hex from an address on."""
    for k, octet in enumerate(bytes.fromhex(octets)):
        chip.write(address + k, octet)


def get(chip: Sja1000, address: int, count: int) -> str:
    """Read bytes from an address on, as hex."""
    return bytes(chip.read(address + k) for k in range(count)).hex(" ").upper()


def octets_of(frame: Frame) -> str:
    """A frame as PeliCAN's transmit buffer wants it."""
    head = frame.dlc | (m.FI_RTR if frame.remote else 0)
    if frame.extended:
        return (bytes([head | m.FI_FF]) + (frame.id << 3).to_bytes(4, "big") + frame.data).hex()
    return (bytes([head]) + (frame.id << 5).to_bytes(2, "big") + frame.data).hex()


def send(chip: Sja1000, frame: Frame, command: int = m.CMR_TR) -> None:
    """Ask a PeliCAN chip to transmit a frame."""
    put(chip, m.TX_BUFFER, octets_of(frame))
    chip.write(m.CMR, command)
