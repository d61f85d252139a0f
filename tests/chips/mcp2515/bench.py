"""A bench for MCP2515 chips: one bus, its faults, partners that acknowledge, and time in bits."""

from __future__ import annotations

from canwire import BitTiming
from canwire.boards.can.channel import Channel
from canwire.boards.can.line import Line
from canwire.boards.catalogue import ideal_line, plug
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.bus.can.node import Mailbox
from canwire.chips.mcp2515 import register_map as m
from canwire.chips.mcp2515.controller import Mcp2515
from canwire.drivers.driver import LineSettings
from canwire.timeline import Timeline
from canwire.values.frame import Frame, record_of_frame

BIT_NS = 2_000  # 500 kbit/s, of 16 quanta
TIMING = BitTiming(1, 11, 4, 1, clock_hz=8_000_000)
CNF = ((m.CNF1, 0x00), (m.CNF2, 0xAC), (m.CNF3, 0x03))
SETTLED_BITS = 20


class Partner:
    """An ideal node on the bus: it acknowledges, and writes down what it hears."""

    def __init__(self, bench: Bench, name: str) -> None:
        self.line: Line = ideal_line(name, bench.timeline)
        plug(self.line, bench.bus)
        self.line.driver.configure(LineSettings(TIMING))
        self.line.driver.start(bench.timeline.now_ns)
        self.channel = self.line.open(Channel(4096, 1024))

    def send(self, frame: Frame) -> None:
        self.line.send(self.channel, frame)

    def heard(self) -> list[Frame]:
        return list(self.channel.receive.take_frames(4096))

    def ids(self) -> list[int]:
        return [frame.id for frame in self.heard()]


class Bench:
    """Chips on one bus, in a time of its own or another bench's."""

    def __init__(self, *, bitwise: bool = False, timeline: Timeline | None = None) -> None:
        self.timeline = timeline or Timeline()
        self.bus = CanBus(self.timeline)
        self.bus.bitwise = bitwise
        self.faults = Faults(self.bus, 1)

    def chip(
        self, mode: int = m.NORMAL, *, enabled: int = 0xFF, rxm: int = m.RXM_ALL, bukt: bool = False
    ) -> Mcp2515:
        """A chip on the bus, in this mode, which takes in everything."""
        chip = Mcp2515(self.bus)
        for address, value in CNF:
            chip.write(address, value)
        chip.write(m.CANINTE, enabled)
        chip.write(m.RXBCTRL[0], rxm << m.RX_RXM_SHIFT | (m.RX_BUKT if bukt else 0))
        chip.write(m.RXBCTRL[1], rxm << m.RX_RXM_SHIFT)
        ask(chip, mode)
        self.bits(SETTLED_BITS)
        return chip

    def partner(self, name: str = "partner") -> Partner:
        partner = Partner(self, name)
        self.bits(SETTLED_BITS)
        return partner

    def bits(self, count: float) -> None:
        """Let so many bit times pass."""
        self.timeline.run_until(self.timeline.now_ns + round(count * BIT_NS))


def ask(chip: Mcp2515, mode: int) -> None:
    chip.modify(m.CANCTRL, 0xE0, mode << m.REQOP_SHIFT)


def mode_of(chip: Mcp2515) -> int:
    return chip.read(m.CANSTAT) >> m.REQOP_SHIFT


def octets_of(frame: Frame) -> bytes:
    """A frame as LOAD TX BUFFER wants it."""
    length = frame.dlc | (m.DLC_RTR if frame.remote else 0)
    if frame.extended:
        low = (frame.id >> 18 & 7) << 5 | 0x08 | frame.id >> 16 & 3
        return bytes([frame.id >> 21, low, frame.id >> 8 & 0xFF, frame.id & 0xFF, length]) + frame.data
    return bytes([frame.id >> 3, (frame.id & 7) << 5, 0, 0, length]) + frame.data


def load(chip: Mcp2515, buffer: int, frame: Frame, priority: int = 0) -> None:
    chip.load_buffer(buffer, octets_of(frame))
    chip.write(m.TXBCTRL[buffer], priority)


def send(chip: Mcp2515, frame: Frame, buffer: int = 0) -> None:
    load(chip, buffer, frame)
    chip.request_to_send(1 << buffer)


def frame_of(octets: bytes) -> Frame:
    """What READ RX BUFFER gave, as a frame."""
    high, low, eid8, eid0, length = octets[:5]
    if low & 0x08:
        id, extended = high << 21 | low >> 5 << 18 | (low & 3) << 16 | eid8 << 8 | eid0, True
        remote = bool(length & 0x40)
    else:
        id, extended, remote = high << 3 | low >> 5, False, bool(low & 0x10)
    if remote:
        return Frame(id, extended=extended, remote=True, dlc=length & 15)
    return Frame(id, octets[5 : 5 + min(length & 15, 8)], extended=extended)


def deliver(chip: Mcp2515, frame: Frame) -> None:
    """As the bus does at the end of a frame."""
    box = Mailbox()
    memoryview(box.block)[:] = record_of_frame(frame)
    chip.received(box, 0)
