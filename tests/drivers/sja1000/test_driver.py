"""The SJA1000's driver: over registers that are nothing but notes, and over the model of the chip."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from canwire import BitTiming, BusEvent, ErrorKind, ErrorState, EventKind, Frame
from canwire.boards.can.channel import Channel
from canwire.boards.can.line import Line
from canwire.boards.catalogue import ideal_line, plug
from canwire.bus.can.bus import CanBus
from canwire.bus.can.faults.faults import Faults
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from canwire.drivers.driver import LineSettings
from canwire.drivers.sja1000.driver import Sja1000Driver
from canwire.drivers.sja1000.error_code import error_kind
from canwire.drivers.sja1000.polled import PERIOD_NS, PortDriver, port_driver
from canwire.drivers.sja1000.port_access import PortAccess
from canwire.errors import BadTiming, BadValue, Closed, NoSuchBoard, Unsupported
from canwire.timeline import Timeline
from canwire.values.isa_address import port_of
from canwire.values.record import ABORT_ON_ERROR, SINGLE_SHOT
from tests.cases import each
from tests.descriptors import open_descriptors

TIMING = BitTiming.for_bit_rate(500_000, clock_hz=8_000_000)
EVENTS = frozenset(
    {EventKind.ERROR, EventKind.STATE, EventKind.ARBITRATION_LOST, EventKind.ABORTED, EventKind.OVERRUN}
)
ACAN_IER = 0xAD
BIT_NS = 2_000


class Notes:
    """Registers that keep what is written, read as a test says, and write everything down; nothing else is there."""

    __slots__ = ("_values", "log")

    def __init__(self, **values: int) -> None:
        self._values = {getattr(m, name): value for name, value in values.items()}
        self.log: list[tuple[str, int, int]] = []

    def read(self, address: int) -> int:
        value = self._values.get(address, 0)
        self.log.append(("r", address, value))
        return value

    def write(self, address: int, value: int) -> None:
        assert 0 <= address < 128
        assert 0 <= value <= 0xFF
        self.log.append(("w", address, value))
        self._values[address] = value

    def written(self) -> list[tuple[int, int]]:
        found = [(address, value) for what, address, value in self.log if what == "w"]
        self.log.clear()
        return found


class Wire:
    """A chip's two wires, and a count of what goes through them."""

    __slots__ = ("_chip", "log")

    def __init__(self, chip: Sja1000) -> None:
        self._chip = chip
        self.log: list[tuple[str, int, int]] = []

    def read(self, address: int) -> int:
        value = self._chip.read(address)
        self.log.append(("r", address, value))
        return value

    def write(self, address: int, value: int) -> None:
        self.log.append(("w", address, value))
        self._chip.write(address, value)

    def commands(self) -> list[int]:
        found = [value for what, address, value in self.log if (what, address) == ("w", m.CMR)]
        self.log.clear()
        return found


class Bench:
    """A line over a wired chip, and an ideal one beside it that acknowledges."""

    def __init__(self, *, alone: bool = False, **settings: object) -> None:
        self.timeline = Timeline()
        self.bus = CanBus(self.timeline)
        self.faults = Faults(self.bus, seed=0)
        self.line = Line("line", self.timeline)
        self.chip = Sja1000()
        self.wire = Wire(self.chip)
        self.driver = Sja1000Driver(self.line, self.wire, lambda: self.timeline.now_ns)
        self.chip.on_interrupt = self.driver.service
        self.line.connect(self.driver, self.chip)
        plug(self.line, self.bus)
        self.driver.configure(LineSettings(TIMING, **settings))  # type: ignore[arg-type]
        self.driver.start(0)
        self.channel = self.line.open(Channel(256, 256, events=EVENTS))
        self.other = ideal_line("other", self.timeline)
        self.heard = self.other.open(Channel(256, 256))
        if not alone:
            plug(self.other, self.bus)
            self.other.driver.configure(LineSettings(TIMING))
            self.other.driver.start(0)
        self.run(1e-3)
        self.told()

    def run(self, seconds: float = 0.05) -> None:
        self.timeline.run_until(self.timeline.now_ns + round(seconds * 1e9))

    def send(self, *ids: int, flags: int = 0) -> None:
        for id in ids:
            self.line.send(self.channel, Frame(id), flags)

    def told(self) -> list[BusEvent]:
        found = []
        while (block := self.channel.receive.take_bytes()) is not None:
            if block[12]:
                found.append(BusEvent.from_record(block))
        return found

    def ids(self) -> list[int]:
        return [frame.id for frame in self.heard.receive.take_frames(999)]


@pytest.fixture
def bench() -> Bench:
    return Bench()


# registers that are nothing but notes


def noted(notes: Notes, **settings: object) -> Sja1000Driver:
    driver = Sja1000Driver(None, notes, lambda: 0)
    driver.configure(LineSettings(TIMING, **settings))  # type: ignore[arg-type]
    return driver


def test_what_is_written_at_the_start() -> None:
    """Reset mode, PeliCAN with the comparator bypassed, all settings; and once more IER as the chip needs a mode."""
    registers = Notes()
    driver = noted(registers)
    written = registers.written()
    assert written[:3] == [(m.MOD, m.MOD_RM), (m.CDR, 0xC0), (m.MOD, m.MOD_RM)]
    values = dict(written)
    btr = TIMING.to_btr()
    assert (values[m.BTR0], values[m.BTR1], values[m.OCR], values[m.EWLR]) == (*btr, 0x6A, 96)
    assert [values[m.ACR0 + k] for k in range(8)] == [0] * 4 + [0xFF] * 4
    assert not values[m.IER] & m.IER_TIE
    driver.start(0)
    assert registers.written()[-1] == (m.MOD, 0)


@pytest.mark.parametrize(("listen_only", "mode"), [(False, 0), (True, m.MOD_LOM)])
def test_the_mode_it_runs_in(listen_only: bool, mode: int) -> None:
    registers = Notes()
    noted(registers, listen_only=listen_only).start(0)
    assert registers.written()[-1] == (m.MOD, mode)


@pytest.mark.conforms("AC-13", "AC-19")
def test_registers_that_settings_name() -> None:
    registers = Notes()
    named = {"OCR": 0x1A, "IER": ACAN_IER, "EWLR": 80, "ACR0": 1, "ACR3": 2, "AMR0": 3, "AMR3": 4}
    noted(registers, registers=tuple(named.items()))
    written = dict(registers.written())
    assert {name: written[getattr(m, name)] for name in named} == named


def test_what_is_refused_before_anything_is_written() -> None:
    registers = Notes()
    driver = Sja1000Driver(None, registers, lambda: 0)
    impossible: list[tuple[LineSettings, type[Exception]]] = [
        (LineSettings(TIMING, TIMING), Unsupported),
        (LineSettings(TIMING, oscillator_ppm=1.0), BadTiming),
        (LineSettings(TIMING, registers=(("BTR0", 1),)), BadValue),
        (LineSettings(TIMING, registers=(("OCR", 256),)), BadValue),
        (LineSettings(TIMING, registers=(("ocr", 1),)), BadValue),
        (LineSettings(BitTiming.for_bit_rate(2_000_000, clock_hz=80_000_000)), BadTiming),
    ]
    for settings, error in impossible:
        with pytest.raises(error):
            driver.configure(settings)
    assert registers.log == []


def test_a_timing_by_another_clock_is_made_by_this_one() -> None:
    registers = Notes()
    driver = Sja1000Driver(None, registers, lambda: 0)
    driver.configure(LineSettings(BitTiming.for_bit_rate(250_000, clock_hz=80_000_000)))
    written = dict(registers.written())
    made = BitTiming.from_btr(written[m.BTR0], written[m.BTR1])
    assert made.bit_rate == 250_000


def test_interrupts_without_end_do_not_hold_it_up() -> None:
    """A chip that is broken, or not there (every register reads FFh): the program goes on."""
    registers = Notes(IR=m.IR_EI)
    driver = noted(registers)
    driver.start(0)
    registers.log.clear()
    driver.service()
    assert 0 < len(registers.log) < 1000


def test_no_interrupt_costs_one_read() -> None:
    registers = Notes()
    driver = noted(registers)
    registers.log.clear()
    driver.service()
    assert registers.log == [("r", m.IR, 0)]


# over the model


@pytest.mark.conforms("AC-13")
@each(("ier", "shown"), [(None, 0xED), (ACAN_IER, ACAN_IER), (0xEF, 0xEF)])
def test_the_transmit_interrupt_is_on_while_a_frame_is_in_the_chip(ier: int | None, shown: int) -> None:
    """So that IER reads what it was set to whenever nothing is being sent."""
    bench = Bench(registers=() if ier is None else (("IER", ier),))
    assert bench.chip.peek(m.IER) == shown
    bench.send(1, 2)
    bench.run(30e-6)
    assert bench.chip.peek(m.IER) == shown | m.IER_TIE
    bench.run()
    assert (bench.chip.peek(m.IER), bench.ids()) == (shown, [1, 2])


def test_only_commands_that_the_chip_knows(bench: Bench) -> None:
    bench.send(1)
    bench.run()
    assert bench.wire.commands() == [m.CMR_TR]
    bench.send(1, flags=SINGLE_SHOT)
    bench.run()
    assert bench.wire.commands() == [m.CMR_TR | m.CMR_AT]
    bench.other.send(bench.heard, Frame(5))
    bench.run()
    assert bench.wire.commands() == [m.CMR_RRB]


def test_an_abort_before_the_frame_is_on_the_wire(bench: Bench) -> None:
    bench.other.send(bench.heard, Frame(0, bytes(8)))
    bench.run(20e-6)
    bench.send(1)
    assert bench.line.cancel(bench.channel) == 1
    assert bench.wire.commands() == [m.CMR_TR, m.CMR_AT]
    assert [event.kind for event in bench.told()] == [EventKind.ABORTED]
    bench.send(2)
    bench.run()
    assert bench.ids() == [2]


def test_an_abort_of_the_frame_on_the_wire_changes_nothing(bench: Bench) -> None:
    bench.send(1)
    bench.run(40e-6)
    assert bench.line.cancel(bench.channel) == 0
    bench.run()
    assert (bench.ids(), bench.told()) == ([1], [])


@pytest.mark.conforms("AC-33")
def test_a_frame_that_is_given_up_at_its_first_error() -> None:
    bench = Bench(alone=True)
    bench.send(1, flags=ABORT_ON_ERROR)
    bench.run()
    assert [event.kind for event in bench.told()] == [EventKind.ERROR, EventKind.ABORTED]
    assert (bench.driver.counters().tec, bench.channel.aborted) == (8, 1)


@pytest.mark.conforms("AC-34")
def test_bus_off_with_a_frame_in_the_chip(bench: Bench) -> None:
    """The chip forgets its buffer; the frame waits in the mailbox, and goes out after the next start."""
    bench.faults.flip(frame_id=1, bit="crc delimiter", times=None, seen_by="sender")
    bench.send(1, 2)
    bench.run(0.2)
    counters = bench.driver.counters()
    assert (counters.state, counters.tec) == (ErrorState.BUS_OFF, 256)
    assert bench.chip.peek(m.MOD) & m.MOD_RM
    assert bench.channel.pending() == 2
    bench.faults.clear()
    bench.ids()
    bench.driver.start(bench.timeline.now_ns)
    bench.run()
    assert bench.ids() == [1, 2]
    assert (bench.driver.counters().tec, bench.channel.pending()) == (0, 0)


@pytest.mark.conforms("FS-58")
def test_registers_of_a_bus_off_chip_do_not_bring_it_back(bench: Bench) -> None:
    bench.faults.flip(frame_id=1, bit="crc delimiter", times=None, seen_by="sender")
    bench.send(1)
    bench.run(0.2)
    bench.faults.clear()
    bench.driver.write_register(m.ACR0, 0x55, True)
    assert bench.driver.read_register(m.ACR0, True) == 0x55
    bench.run()
    assert bench.driver.counters().state is ErrorState.BUS_OFF
    assert bench.chip.peek(m.MOD) & m.MOD_RM


def test_recovery_takes_128_times_11_recessive_bits(bench: Bench) -> None:
    bench.faults.flip(frame_id=1, bit="crc delimiter", times=None, seen_by="sender")
    bench.send(1)
    bench.run(0.2)
    bench.faults.clear()
    bench.told()
    bench.driver.restart(bench.timeline.now_ns)
    begun_ns = bench.timeline.now_ns
    bench.driver.restart(begun_ns)  # once is enough
    bench.run()
    states = [event for event in bench.told() if event.kind is EventKind.STATE]
    assert [event.state for event in states] == [ErrorState.ERROR_ACTIVE]
    assert 128 * 11 * BIT_NS <= states[0].timestamp_ns - begun_ns <= 129 * 11 * BIT_NS
    assert bench.channel.pending() == 0


@pytest.mark.conforms("AC-34")
def test_a_frame_that_waits_in_bus_off_can_be_given_up(bench: Bench) -> None:
    bench.faults.flip(frame_id=1, bit="crc delimiter", times=None, seen_by="sender")
    bench.send(1)
    bench.run(0.2)
    assert bench.line.cancel(bench.channel) == 1
    bench.faults.clear()
    bench.driver.start(bench.timeline.now_ns)
    bench.send(2)
    bench.run()
    assert 2 in bench.ids()
    assert (bench.channel.aborted, bench.channel.delivered) == (1, 1)


@pytest.mark.conforms("AC-27", "AC-28")
def test_an_overrun_is_told_and_cleared(bench: Bench) -> None:
    """Nobody serves the chip for a while: five frames of 8 bytes fit its FIFO."""
    bench.chip.on_interrupt = None
    for id in range(8):
        bench.other.send(bench.heard, Frame(id, bytes(8)))
    bench.run()
    assert bench.chip.peek(m.SR) & m.SR_DOS
    bench.driver.service()
    assert [event.kind for event in bench.told()] == [EventKind.OVERRUN]
    assert not bench.chip.peek(m.SR) & (m.SR_DOS | m.SR_RBS)
    assert bench.driver.counters().frames_received == 5
    bench.chip.on_interrupt = bench.driver.service
    bench.other.send(bench.heard, Frame(9))
    bench.run()
    assert bench.driver.counters().frames_received == 6


@pytest.mark.parametrize(
    ("bit", "error"), [("crc delimiter", ErrorKind.FORM), ("ack", ErrorKind.ACK), (30, ErrorKind.BIT)]
)
def test_what_a_sender_finds_wrong(bench: Bench, bit: str | int, error: ErrorKind) -> None:
    bench.faults.flip(frame_id=0x555, bit=bit, seen_by="sender")
    bench.line.send(bench.channel, Frame(0x555, b"\x55" * 8))
    bench.run()
    event = next(event for event in bench.told() if event.kind is EventKind.ERROR)
    assert (event.error, event.transmitting) == (error, True)
    assert event.code


@each(
    ("code", "kind"),
    [
        (0x03, ErrorKind.BIT), (0x23, ErrorKind.BIT), (0x18, ErrorKind.FORM), (0x38, ErrorKind.BIT),
        (0x1A, ErrorKind.FORM), (0x58, ErrorKind.FORM), (0x7A, ErrorKind.FORM), (0xA4, ErrorKind.STUFF),
        (0xD9, ErrorKind.ACK), (0xF8, ErrorKind.CRC),
    ],
)  # fmt: skip
def test_what_error_codes_mean(code: int, kind: ErrorKind) -> None:
    """ECC: type, direction (20h receiving), segment."""
    assert error_kind(code) is kind


def test_registers_are_read_without_side_effects() -> None:
    bench = Bench()
    peeking = Sja1000Driver(bench.line, bench.chip, lambda: 0, peek=bench.chip.peek)
    bench.chip.on_interrupt = None
    bench.other.send(bench.heard, Frame(5))
    bench.run()
    before = [bench.chip.peek(address) for address in range(128)]
    shown = {value.name: value for value in peeking.registers()}
    assert [bench.chip.peek(address) for address in range(128)] == before
    assert (shown["MOD"].value, shown["IR"].value) == (0, m.IR_RI)
    assert "RBS" in shown["SR"].text
    assert shown["BTR0"].address == m.BTR0
    assert {"ALC", "ECC", "IR"} <= shown.keys()


def test_a_real_chips_registers_are_shown_but_for_those_that_reading_changes(bench: Bench) -> None:
    names = {value.name for value in bench.driver.registers()}
    assert not names & {"IR", "ALC", "ECC"}
    assert {"MOD", "SR", "IER", "BTR0", "TXERR"} <= names


def test_in_reset_mode_the_filters_are_shown(bench: Bench) -> None:
    bench.driver.stop(0)
    names = {value.name for value in bench.driver.registers()}
    assert {"ACR0", "AMR3"} <= names


# behind ports


class Ports(PortAccess):
    """A chip at the ports of a machine whose device is a file that nobody looks at."""

    def __init__(self, chip: Sja1000, path: str) -> None:
        super().__init__(0x280, path)
        self._chip = chip
        self.reads: list[int] = []

    def read(self, address: int) -> int:
        self._port(address)
        self.reads.append(address)
        return self._chip.read(address)

    def write(self, address: int, value: int) -> None:
        self._port(address)
        self._chip.write(address, value)


@pytest.fixture
def device(tmp_path: Path) -> str:
    path = tmp_path / "port"
    path.write_bytes(b"\xff" * 0x10000)
    return str(path)


@pytest.fixture
def polled(device: str) -> Iterator[tuple[Bench, Ports, PortDriver]]:
    """The bench's line with a driver that looks by the clock."""
    bench = Bench()
    ports = Ports(bench.chip, device)
    driver = PortDriver(bench.line, ports, bench.timeline)
    bench.driver.stop(0)
    bench.chip.on_interrupt = None
    bench.driver = driver
    bench.line.connect(driver, bench.chip)
    driver.configure(LineSettings(TIMING))
    driver.start(bench.timeline.now_ns)
    bench.run(1e-3)
    bench.told()
    yield bench, ports, driver
    driver.close()


def test_without_interrupts_frames_go_both_ways(polled: tuple[Bench, Ports, PortDriver]) -> None:
    bench, _, driver = polled
    bench.send(1, 2, 3)
    for id in range(20):
        bench.other.send(bench.heard, Frame(0x100 + id, bytes(8)))
    bench.run()
    assert bench.ids() == [1, 2, 3]
    assert driver.counters().frames_received == 20
    assert [event.kind for event in bench.told()] == []


def test_an_idle_chip_is_looked_at_once_a_period(polled: tuple[Bench, Ports, PortDriver]) -> None:
    bench, ports, driver = polled
    ports.reads.clear()
    bench.run(100 * PERIOD_NS / 1e9)
    assert set(ports.reads) == {m.IR}
    assert 99 <= len(ports.reads) <= 101
    driver.stop(0)
    ports.reads.clear()
    bench.run()
    assert ports.reads == []
    assert bench.timeline.idle()


def test_starting_twice_looks_no_oftener(polled: tuple[Bench, Ports, PortDriver]) -> None:
    bench, ports, driver = polled
    driver.start(bench.timeline.now_ns)
    ports.reads.clear()
    bench.run(100 * PERIOD_NS / 1e9)
    assert len(ports.reads) <= 101


def test_closed_it_lets_go_of_the_device(polled: tuple[Bench, Ports, PortDriver]) -> None:
    bench, ports, driver = polled
    driver.close()
    with pytest.raises(Closed):
        ports.read(0)
    bench.run()


def test_closing_twice(polled: tuple[Bench, Ports, PortDriver]) -> None:
    _, _, driver = polled
    driver.close()
    driver.close()
    driver.stop(0)


def test_closed_with_a_frame_in_the_chip_that_is_given_up_then(
    polled: tuple[Bench, Ports, PortDriver],
) -> None:
    """What a line does whose board is pulled out."""
    bench, _, driver = polled
    bench.send(1, 2)
    bench.run(40e-6)
    driver.close()
    assert driver.abort(driver.normal, 0)
    assert [event.kind for event in bench.told()] == [EventKind.STATE, EventKind.ABORTED]
    assert driver.counters().state is ErrorState.STOPPED
    assert (bench.channel.aborted, bench.channel.pending()) == (1, 1)


@pytest.mark.conforms("AC-05")
def test_no_board_at_the_ports(device: str) -> None:
    before = open_descriptors()
    with pytest.raises(NoSuchBoard, match="no SJA1000 answers at 280h"):
        port_driver(None, 0x280, Timeline(), device)
    assert open_descriptors() == before


@pytest.mark.conforms("AC-05")
def test_a_board_at_the_ports(device: str) -> None:
    """A file keeps what is written, as a clock divider does; the driver does not look further."""
    with open(device, "r+b") as file:
        file.seek(port_of(31, 0x280))
        file.write(b"\0")
    driver = port_driver(None, 0x280, Timeline(), device)
    driver.configure(LineSettings(TIMING))
    content = Path(device).read_bytes()
    assert [content[port_of(address, 0x280)] for address in (m.BTR0, m.BTR1)] == list(TIMING.to_btr())
    assert content[port_of(m.OCR, 0x280)] == 0x6A
    driver.close()


def test_speed_of_nothing(bench: Bench) -> None:
    """A frame out costs a bounded number of register accesses: speed on real ports is theirs."""
    bench.wire.log.clear()
    bench.line.send(bench.channel, Frame(1, bytes(8)))
    bench.run()
    assert len(bench.wire.log) <= 25
