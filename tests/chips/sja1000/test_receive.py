"""What the SJA1000 keeps: acceptance filter F01 to F36, the FIFO, overruns, receive interrupts (R32 to R38)."""

from __future__ import annotations

from collections import deque

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire.bus.can.bus import CanBus
from canwire.bus.can.node import Mailbox
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from canwire.timeline import Timeline
from canwire.values import acceptance_orders
from canwire.values.acceptance import Acceptance
from canwire.values.frame import Frame, record_of_frame
from tests.cases import each
from tests.chips.sja1000.bench import Bench, get, put, send
from tests.effort import examples
from tests.tables import sja1000_vectors
from tests.tables.sja1000_acceptance import VECTORS as FILTERS

pytestmark = pytest.mark.core


def receiver(mode: str, acr: bytes, amr: bytes, enabled: int = 0xFF) -> Sja1000:
    """A chip in operating mode, without a bus: B BasicCAN, S single filter, D dual filter."""
    chip = Sja1000()
    if mode == "B":
        chip.write(m.BASIC_ACR, acr[0])
        chip.write(m.BASIC_AMR, amr[0])
        chip.write(m.BASIC_CR, 0x1E)
        return chip
    chip.write(m.CDR, m.CDR_PELICAN)
    chip.write(m.IER, enabled)
    for k in range(4):
        chip.write(m.ACR0 + k, acr[k])
        chip.write(m.AMR0 + k, amr[k])
    chip.write(m.MOD, m.MOD_AFM if mode == "S" else 0)
    return chip


def open_receiver(mode: str = "S", enabled: int = 0xFF) -> Sja1000:
    return receiver(mode, bytes(4), b"\xff" * 4, enabled)


def deliver(chip: Sja1000, frame: Frame) -> None:
    """As the bus does at the end of a frame."""
    box = Mailbox()
    memoryview(box.block)[:] = record_of_frame(frame)
    chip.received(box, 0)


def stored(chip: Sja1000) -> int:
    return chip.read(m.SR) & m.SR_RBS


@each(
    ("number", "mode", "acr", "amr", "id", "remote", "data", "accepted"),
    FILTERS,
    ids=[row[0] for row in FILTERS],
)
def test_filter_vectors(
    number: str, mode: str, acr: str, amr: str, id: str, remote: bool, data: str, accepted: bool
) -> None:
    chip = receiver(mode, bytes.fromhex(acr), bytes.fromhex(amr))
    deliver(chip, Frame(int(id, 16), bytes.fromhex(data), extended=len(id) == 8, remote=remote))
    assert stored(chip) == accepted


FOUR = st.binary(min_size=4, max_size=4)


@st.composite
def filtered_frames(draw: st.DrawFn) -> tuple[str, bytes, bytes, Frame]:
    """A filter and a frame that is close to its code in one of the layouts."""
    acr, amr = draw(FOUR), draw(FOUR)
    extended = draw(st.booleans())
    code = int.from_bytes(acr, "big")
    if extended:
        near = draw(st.sampled_from([code >> 3, code >> 16 << 13, (code & 0xFFFF) << 13]))
    else:
        near = draw(st.sampled_from([code >> 21, code >> 5 & 0x7FF]))
    flips = draw(st.sampled_from([0, 1 << draw(st.integers(0, 28 if extended else 10))]))
    remote = draw(st.booleans())
    pieces = [acr[2:3], bytes([(acr[1] & 15) << 4 | acr[3] & 15]), acr[2:4], draw(st.binary(max_size=8))]
    data = b"" if remote else draw(st.sampled_from(pieces))
    frame = Frame(near & (0x1FFFFFFF if extended else 0x7FF) ^ flips, data, extended=extended, remote=remote)
    return draw(st.sampled_from("BSD")), acr, amr, frame


def acceptance(mode: str, acr: bytes, amr: bytes) -> Acceptance:
    """The other implementation: pairs over 64-bit keys."""
    if mode == "B":
        return acceptance_orders.sja1000_basic(acr[0], amr[0])
    return (acceptance_orders.sja1000_single if mode == "S" else acceptance_orders.sja1000_dual)(acr, amr)


@examples(100)
@given(filtered_frames())
def test_the_filter_agrees_with_another_one(case: tuple[str, bytes, bytes, Frame]) -> None:
    mode, acr, amr, frame = case
    chip = receiver(mode, acr, amr)
    deliver(chip, frame)
    assert bool(stored(chip)) == acceptance(mode, acr, amr).accepts(frame)


@each("bits", range(9))
@each("mode", ["B", "S", "E"])
def test_capacity(mode: str, bits: int) -> None:
    names = {"B": "BASIC_CAPACITY", "S": "STANDARD_CAPACITY", "E": "EXTENDED_CAPACITY"}
    capacity = getattr(sja1000_vectors, names[mode])[bits]
    chip = open_receiver("B" if mode == "B" else "S")
    for k in range(capacity + 1):
        assert chip.read(m.SR) & m.SR_DOS == 0
        deliver(chip, Frame(k, bytes(bits), extended=mode == "E"))
    assert chip.read(m.SR) & 3 == 3
    if mode != "B":
        assert chip.read(m.RMC) == capacity
    kept = 0
    while stored(chip):
        chip.write(m.CMR, m.CMR_RRB)
        kept += 1
    assert kept == capacity


def test_r32_overrun_release_and_start_addresses(bench: Bench) -> None:
    sender, chip = bench.chip(), bench.chip()
    for k in range(6):
        send(sender, Frame(0x100 + k, bytes(8)))
        bench.bits(150)
    assert (chip.read(m.RMC), chip.read(m.SR) & 3) == (5, 3)
    assert chip.read(m.IR) & 0x09 == 0x09
    starts = []
    for _ in range(5):
        chip.write(m.CMR, m.CMR_RRB)
        starts.append(chip.read(m.RBSA))
    assert starts == [11, 22, 33, 44, 55]
    assert (chip.read(m.RMC), chip.read(m.SR) & 3) == (0, 2)
    chip.write(m.CMR, m.CMR_CDO)
    assert chip.read(m.SR) & 3 == 0


@pytest.mark.parametrize(("extended", "length", "received", "kept"), sja1000_vectors.CAPACITIES)
def test_r33_what_does_not_fit_is_dropped_whole(
    bench: Bench, extended: bool, length: int, received: int, kept: int
) -> None:
    sender, chip = bench.chip(), bench.chip()
    for _ in range(received):
        send(sender, Frame(0x100, bytes(length), extended=extended))
        bench.bits(170)
    assert (chip.read(m.RMC), chip.read(m.SR) & m.SR_DOS) == (kept, m.SR_DOS)


def test_r34_basic_can_holds_six(bench: Bench) -> None:
    sender, chip = bench.basic_chip(), bench.basic_chip()
    put(sender, m.BASIC_TX_BUFFER, "24 68 01 02 03 04 05 06 07 08")
    for _ in range(7):
        sender.write(m.BASIC_CMR, m.CMR_TR)
        bench.bits(170)
    assert chip.read(m.BASIC_SR) & 3 == 3
    for _ in range(6):
        assert get(chip, m.BASIC_RX_WINDOW, 10) == "24 68 01 02 03 04 05 06 07 08"
        chip.write(m.BASIC_CMR, m.CMR_RRB)
    assert chip.read(m.BASIC_SR) & 3 == 2


def test_r35_one_overrun_interrupt_until_it_is_cleared() -> None:
    chip = open_receiver(enabled=m.IER_DOIE)
    for _ in range(6):
        deliver(chip, Frame(1, bytes(8)))
    assert chip.read(m.IR) == m.IR_DOI
    deliver(chip, Frame(1, bytes(8)))
    assert chip.read(m.IR) == 0
    chip.write(m.CMR, m.CMR_CDO)
    assert chip.read(m.SR) & m.SR_DOS == 0
    deliver(chip, Frame(1, bytes(8)))
    assert chip.read(m.IR) == m.IR_DOI


def test_r36_pelican_s_receive_interrupt_is_a_level() -> None:
    chip = open_receiver(enabled=m.IER_RIE)
    for _ in range(2):
        deliver(chip, Frame(1))
    read = [chip.read(m.IR), chip.read(m.IR)]
    for _ in range(2):
        chip.write(m.CMR, m.CMR_RRB)
        read.append(chip.read(m.IR))
    assert read == [1, 1, 1, 0]
    assert not chip.interrupt


def test_r37_basic_can_s_receive_interrupt_is_cleared_by_reading() -> None:
    chip = open_receiver("B")
    for _ in range(2):
        deliver(chip, Frame(1))
    read = [chip.read(m.BASIC_IR), chip.read(m.BASIC_IR)]
    assert not chip.interrupt
    chip.write(m.BASIC_CMR, m.CMR_RRB)
    assert chip.interrupt
    assert [*read, chip.read(m.BASIC_IR)] == [0xE1, 0xE0, 0xE1]


def test_r38_disabling_drops_the_receive_interrupt() -> None:
    chip = open_receiver()
    deliver(chip, Frame(1))
    assert (chip.read(m.IR), chip.interrupt) == (1, True)
    chip.write(m.IER, 0)
    assert (chip.read(m.IR), chip.interrupt) == (0, False)
    chip.write(m.IER, 1)
    assert (chip.read(m.IR), chip.interrupt) == (1, True)


def test_release_and_clear_overrun_go_in_one_command() -> None:
    chip = open_receiver()
    for _ in range(6):
        deliver(chip, Frame(1, bytes(8)))
    chip.write(m.CMR, m.CMR_CDO | m.CMR_RRB)
    assert (chip.read(m.RMC), chip.read(m.SR) & 3) == (4, 1)


def test_a_long_code_stays_in_the_window_and_brings_eight_bytes() -> None:
    chip = open_receiver()
    deliver(chip, Frame(1, bytes(range(8)), dlc=15))
    deliver(chip, Frame(2, remote=True, dlc=15))
    assert get(chip, m.RX_WINDOW, 11) == "0F 00 20 00 01 02 03 04 05 06 07"
    chip.write(m.CMR, m.CMR_RRB)
    assert (get(chip, m.RX_WINDOW, 3), chip.read(m.RBSA), chip.read(m.RMC)) == ("4F 00 50", 11, 1)


def test_frames_of_29_bits_are_nothing_to_basic_can() -> None:
    chip = open_receiver("B")
    deliver(chip, Frame(1, extended=True))
    assert (chip.read(m.BASIC_SR) & m.SR_RBS, chip.read(m.BASIC_IR)) == (0, 0xE0)


def test_the_ram_keeps_its_bytes_in_reset_mode() -> None:
    chip = open_receiver()
    deliver(chip, Frame(0x123, b"\x11\x22"))
    deliver(chip, Frame(0x124))
    chip.write(m.CMR, m.CMR_RRB)
    chip.write(m.MOD, m.MOD_RM)
    assert (chip.read(m.RMC), chip.read(m.RBSA), chip.read(m.IR)) == (0, 5, 0)
    assert get(chip, m.RX_FIFO, 8) == "02 24 60 11 22 00 24 80"
    chip.write(m.RX_FIFO + 40, 0xAB)
    chip.write(m.RBSA, 40)
    chip.write(m.MOD, 0)
    assert chip.read(m.RX_WINDOW) == 0xAB
    deliver(chip, Frame(0x123, b"\x33"))
    assert get(chip, m.RX_FIFO + 40, 4) == "01 24 60 33"


def test_a_frame_of_its_own_passes_through_the_ram_unlocked(bench: Bench) -> None:
    sender, other = bench.chip(), bench.chip()
    send(sender, Frame(0x123, b"\x11\x22"))
    bench.bits(100)
    assert (sender.read(m.RMC), get(sender, m.RX_FIFO, 5)) == (0, "02 24 60 11 22")
    send(other, Frame(0x124))
    bench.bits(100)
    assert (sender.read(m.RMC), get(sender, m.RX_FIFO, 5)) == (1, "00 24 80 11 22")


def window_of(frame: Frame, mode: str) -> bytes:
    """The bytes of a message, worked out from the frame's bits."""
    bits = f"{frame.dlc:04b}"
    if mode == "B":
        text = f"{frame.id:011b}{frame.remote:b}{bits}"
    elif frame.extended:
        text = f"1{frame.remote:b}00{bits}{frame.id:029b}{frame.remote:b}00"
    else:
        text = f"0{frame.remote:b}00{bits}{frame.id:011b}{frame.remote:b}0000"
    return bytes(int(text[k : k + 8], 2) for k in range(0, len(text), 8)) + frame.data


FRAMES = st.one_of(
    st.builds(Frame, st.integers(0, 0x7FF), st.binary(max_size=8)),
    st.builds(Frame, st.integers(0, 0x1FFFFFFF), st.binary(max_size=8), extended=st.just(True)),
    st.builds(Frame, st.integers(0, 0x7FF), remote=st.just(True), dlc=st.integers(0, 15)),
)


@examples(100)
@given(st.sampled_from("BSD"), st.lists(st.one_of(st.none(), st.none(), FRAMES), max_size=120))
def test_the_fifo_against_a_model(mode: str, happenings: list[Frame | None]) -> None:
    """A queue of whole messages with a limit of 64 bytes; None releases one."""
    chip = open_receiver(mode)
    window = m.BASIC_RX_WINDOW if mode == "B" else m.RX_WINDOW
    model: deque[bytes] = deque()
    overrun = False
    for frame in happenings:
        if frame is None:
            chip.write(m.CMR, m.CMR_RRB)
            if model:
                model.popleft()
        elif not (mode == "B" and frame.extended):
            deliver(chip, frame)
            message = window_of(frame, mode)
            if sum(map(len, model)) + len(message) <= 64:
                model.append(message)
            else:
                overrun = True
        assert chip.read(m.SR) & 3 == (2 * overrun | bool(model))
        if mode != "B":
            assert chip.read(m.RMC) == len(model)
        if model:
            shown = bytes(chip.read(window + k) for k in range(len(model[0])))
            assert shown == model[0]


def test_a_saturated_bus_loses_nothing_to_a_driver_that_listens(bench: Bench) -> None:
    timeline = Timeline()
    bus = CanBus(timeline)
    chips = []
    for _ in range(2):
        chip = Sja1000(bus)
        chip.write(m.BTR1, 0x14)
        chip.write(m.CDR, m.CDR_PELICAN)
        put(chip, m.AMR0, "FFFFFFFF")
        chip.write(m.IER, m.IER_RIE | m.IER_TIE)
        chip.write(m.MOD, m.MOD_AFM)
        chips.append(chip)
    sender, chip = chips
    timeline.run_until(100_000)
    got: list[int] = []
    sent = [0]

    def refill() -> None:
        sender.read(m.IR)
        sent[0] += 1
        put(sender, m.TX_BUFFER, "08" + f"{sent[0] << 5 & 0xFFE0:04X}" + "00" * 8)
        sender.write(m.CMR, m.CMR_TR)

    def take() -> None:
        while chip.read(m.SR) & m.SR_RBS:
            got.append(chip.read(m.RX_WINDOW + 1) << 3 | chip.read(m.RX_WINDOW + 2) >> 5)
            chip.write(m.CMR, m.CMR_RRB)

    sender.on_interrupt, chip.on_interrupt = refill, take
    refill()
    timeline.run_until(100_000_000)
    assert len(got) > 750
    assert got == [k & 0x7FF for k in range(1, len(got) + 1)]
    assert chip.read(m.SR) & m.SR_DOS == 0
