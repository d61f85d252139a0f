"""Sleep, interrupts, INT, and what is known to be wrong in other models of the SJA1000 (reference section 14)."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import Lab, NotIdle
from canwire.bus.can.bit_layout import BitLayout
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from canwire.values.frame import Frame
from tests.chips.sja1000.bench import Bench, put, send

pytestmark = pytest.mark.core

C04 = Frame(0x123, b"\x11\x22")
MODE = m.MOD_AFM


def sleeping(bench: Bench) -> Sja1000:
    chip = bench.chip()
    chip.write(m.MOD, m.MOD_SM)
    assert chip.read(m.MOD) == MODE | m.MOD_SM
    assert chip.read(m.IR) == 0
    return chip


def test_sleep_ends_with_bus_activity_and_the_waking_frame_is_lost(bench: Bench) -> None:
    chip, sender, _ = sleeping(bench), bench.chip(), bench.chip()
    send(sender, C04)
    bench.bits(1)
    assert (chip.read(m.MOD), chip.read(m.IR), chip.read(m.SR) & 0x30) == (MODE, m.IR_WUI, 0x30)
    bench.bits(100)
    assert (chip.read(m.RMC), chip.read(m.SR) & 0x30) == (0, 0)
    send(sender, C04)
    bench.bits(100)
    assert chip.read(m.RMC) == 1


def test_sleep_ends_with_a_short(bench: Bench) -> None:
    chip = sleeping(bench)
    bench.bus.short(True)
    bench.bits(1)
    assert chip.read(m.IR) == m.IR_WUI
    bench.bits(50)
    assert chip.read(m.RXERR) == 0
    bench.bus.short(False)
    bench.bits(12)
    assert chip.read(m.SR) & 0x30 == 0


def test_sleep_ends_by_the_processor_or_the_line(bench: Bench) -> None:
    chip = sleeping(bench)
    chip.write(m.MOD, 0)
    assert (chip.read(m.MOD), chip.read(m.IR)) == (MODE, m.IR_WUI)
    bench.bits(11)
    assert chip.read(m.SR) & 0x30 == 0
    other = sleeping(bench)
    other.pull_interrupt()
    assert (other.read(m.MOD), other.read(m.IR)) == (MODE, m.IR_WUI)


def test_reset_mode_ends_sleep_quietly(bench: Bench) -> None:
    chip = sleeping(bench)
    chip.write(m.MOD, m.MOD_RM)
    assert (chip.read(m.MOD), chip.read(m.IR)) == (MODE | m.MOD_RM, 0)


def test_a_sleeping_chip_acknowledges_nothing(bench: Bench) -> None:
    sleeping(bench)
    sender = bench.chip()
    send(sender, C04, m.CMR_TR | m.CMR_AT)
    bench.bits(100)
    assert sender.read(m.TXERR) == 8


def test_sleep_is_refused_while_there_is_something_to_do(bench: Bench) -> None:
    chip, sender = bench.chip(), bench.chip()
    send(sender, C04)
    bench.bits(10)
    chip.write(m.MOD, m.MOD_SM)
    assert (chip.read(m.MOD), chip.read(m.IR)) == (MODE, m.IR_WUI)
    bench.bits(100)
    chip.write(m.MOD, m.MOD_SM)  # RI waits
    assert (chip.read(m.MOD), chip.read(m.IR)) == (MODE, m.IR_WUI | m.IR_RI)
    chip.write(m.CMR, m.CMR_RRB)
    chip.write(m.MOD, m.MOD_SM)
    assert chip.read(m.MOD) == MODE | m.MOD_SM


def test_sleep_needs_operating_mode_and_a_bus_that_was_free(bench: Bench) -> None:
    chip = bench.chip()
    chip.write(m.MOD, m.MOD_RM)
    chip.write(m.MOD, m.MOD_RM | m.MOD_SM)
    assert chip.read(m.MOD) == m.MOD_RM
    chip.write(m.MOD, 0)
    chip.write(m.MOD, m.MOD_SM)
    assert (chip.read(m.MOD), chip.read(m.IR)) == (0, 0)


def test_basic_can_sleeps_by_command(bench: Bench) -> None:
    chip, sender, _ = bench.basic_chip(), bench.chip(), bench.chip()
    chip.write(m.BASIC_CMR, m.CMR_GTS)
    assert chip.asleep
    assert chip.clkout_hz == 8e6
    bench.bits(16)
    assert chip.clkout_hz == 0
    send(sender, C04)
    bench.bits(1)
    assert (chip.asleep, chip.read(m.BASIC_IR)) == (False, 0xE0 | m.IR_WUI)
    bench.bits(100)
    chip.write(m.BASIC_CMR, m.CMR_GTS)
    chip.write(m.BASIC_CMR, m.CMR_CDO)
    assert (chip.asleep, chip.read(m.BASIC_IR)) == (False, 0xE0 | m.IR_WUI)


def test_int_tells_of_edges_only_and_never_inside_itself(bench: Bench) -> None:
    sender, chip = bench.chip(), bench.chip(enabled=m.IER_RIE)
    depth, calls = [0], []

    def one_message_a_time() -> None:
        assert depth[0] == 0
        depth[0] += 1
        calls.append(chip.read(m.RX_WINDOW + 1))
        chip.write(m.CMR, m.CMR_RRB)
        depth[0] -= 1

    for k in range(3):
        send(sender, Frame(k << 3))
        bench.bits(100)
    chip.on_interrupt = one_message_a_time
    assert calls == []
    chip.write(m.CMR, m.CMR_RRB)  # INT goes and comes back: an edge
    assert calls == [1, 2]
    assert not chip.interrupt


def test_an_error_in_the_handler_comes_out_and_leaves_the_chip_working(bench: Bench) -> None:
    chip = bench.chip(m.MOD_STM)

    def fail() -> None:
        raise ValueError("driver")

    chip.on_interrupt = fail
    chip.write(m.CMR, m.CMR_TR)
    with pytest.raises(ValueError, match="driver"):
        bench.bits(100)
    calls: list[int] = []
    chip.on_interrupt = lambda: calls.append(chip.read(m.IR))
    chip.read(m.IR)
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(100)
    assert calls == [m.IR_TI]


def test_reset_mode_inside_the_handler(bench: Bench) -> None:
    sender, chip, third = bench.chip(), bench.chip(enabled=m.IER_RIE), bench.chip()
    chip.on_interrupt = lambda: chip.write(m.MOD, m.MOD_RM)
    for bitwise in (False, True):
        bench.bus.bitwise = bitwise
        chip.write(m.MOD, 0)
        bench.bits(20)
        send(sender, C04)
        bench.bits(100)
        assert (chip.read(m.MOD) & m.MOD_RM, chip.read(m.SR)) == (m.MOD_RM, 0x3C)
        assert sender.read(m.SR) & m.SR_TCS
    assert third.read(m.RMC) == 2


def test_chips_hang_on_a_bus_of_the_lab_among_its_nodes() -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000)
        chip, node = Sja1000(bus), bus.node("n")
        chip.write(m.BTR1, 0x1C)
        chip.write(m.CDR, m.CDR_PELICAN)
        put(chip, m.AMR0, "FFFFFFFF")
        chip.write(m.MOD, MODE)
        node.send(C04)
        lab.run_for(0.001)
        assert (chip.read(m.RMC), node.delivered) == (1, 1)
        send(chip, Frame(0x7F0, b"\x42"))
        lab.run_for(0.001)
        assert node.receive_many(9) == [Frame(0x7F0, b"\x42")]


def test_the_lab_tells_of_a_chip_that_nobody_acknowledges() -> None:
    with Lab() as lab:
        chip = Sja1000(lab.can_bus("body", bit_rate=500_000))
        chip.write(m.BTR1, 0x1C)
        chip.write(m.BASIC_CR, 0)
        lab.run_for(0.001)
        chip.write(m.CMR, m.CMR_TR)
        with pytest.raises(NotIdle, match=r"body: no frame got through for 1 s: a chip repeats its frame"):
            lab.run_until_idle()


def test_an_fd_frame_is_destroyed() -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=500_000, data_bit_rate=2_000_000)
        chip, node, _ = Sja1000(bus), bus.node("n"), bus.node("o")
        chip.write(m.BTR1, 0x1C)
        chip.write(m.CDR, m.CDR_PELICAN)
        chip.write(m.MOD, MODE)
        lab.run_for(0.001)
        node.send(Frame(0x123, bytes(16), fd=True))
        lab.run_for(0.0004)
        assert node.delivered == 0
        assert chip.read(m.RXERR) > 0
        assert chip.read(m.ECC) & m.ECC_RX


# known deviations of public models: not shared


def test_not_qemu_s(bench: Bench) -> None:
    """It sends at once, counts no errors, sets interrupts that nobody enabled, and filters no BasicCAN frame."""
    sender, chip, basic = bench.chip(enabled=0), bench.chip(enabled=0), bench.basic_chip(acr=0x55, amr=0)
    send(sender, C04)
    assert sender.read(m.SR) & m.SR_TBS == 0
    bench.bits(40)
    assert sender.read(m.SR) & m.SR_TBS == 0
    bench.bits(60)
    assert sender.read(m.SR) & m.SR_TBS
    assert (sender.read(m.IR), chip.read(m.IR), chip.read(m.RMC)) == (0, 0, 1)
    assert basic.read(m.BASIC_SR) & m.SR_RBS == 0
    chip.write(m.CMR, m.CMR_RRB)
    assert chip.read(m.RBSA) == 5


def test_not_freecores(bench: Bench) -> None:
    """TXERR 128 after bus-off; AT sets TCS; no OCR, RBSA, RAM; ECC 0 once read."""
    chip = bench.chip()
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(60)
    chip.write(m.CMR, m.CMR_AT)
    bench.bits(60)
    assert chip.read(m.SR) & m.SR_TCS == 0
    assert (chip.read(m.ECC), chip.read(m.ECC)) == (0xD9, 0xD9)
    chip.write(m.MOD, 1)
    chip.write(m.OCR, 0x6A)
    chip.write(m.RBSA, 24)
    chip.write(m.RX_FIFO + 24, 0x77)
    chip.write(m.TXERR, 255)
    chip.write(m.MOD, 0)
    assert chip.read(m.TXERR) == 127
    assert (chip.read(m.OCR), chip.read(m.RBSA), chip.read(m.RX_FIFO + 24)) == (0x6A, 24, 0x77)


def test_direction_is_that_of_the_frame_even_after_an_acknowledge(bench: Bench) -> None:
    """freecores tells TX for a receiver that has just acknowledged."""
    sender, chip = bench.chip(), bench.chip()
    bench.faults.flip(bit="ack delimiter", seen_by=chip)
    send(sender, C04, m.CMR_TR | m.CMR_AT)
    bench.bits(100)
    assert chip.read(m.ECC) == 0x7B


def test_overrun_messages_are_not_counted(bench: Bench) -> None:
    sender, chip = bench.chip(), bench.chip()
    for _ in range(8):
        send(sender, Frame(1, bytes(8)))
        bench.bits(150)
    assert chip.read(m.RMC) == 5


def test_what_linux_relies_on(bench: Bench) -> None:
    """RM reads back, counters can be written in reset mode, reading ECC re-arms it, 20 passes over IR end."""
    chip = bench.chip(m.MOD_AFM)
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(200)
    chip.write(m.MOD, m.MOD_RM)
    assert chip.read(m.MOD) & m.MOD_RM
    for register in (m.TXERR, m.RXERR):
        chip.write(register, 0)
    chip.read(m.ECC)
    chip.write(m.MOD, 0)
    assert chip.read(m.MOD) & m.MOD_RM == 0
    bench.bits(20)
    assert (chip.read(m.TXERR), chip.read(m.RXERR)) == (0, 0)
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(70)
    passes = 0
    while chip.read(m.IR) and passes < 20:
        chip.read(m.ECC)
        passes += 1
    assert passes == 1


# ECC by parts of the frame


@pytest.mark.parametrize(
    ("bit", "seen_by", "code"),
    [("crc delimiter", "receivers", 0x78), ("ack delimiter", "receivers", 0x7B), ("eof", "receivers", 0x7A)],
)
def test_parts_behind_the_crc(bench: Bench, bit: str, seen_by: str, code: int) -> None:
    sender, chip = bench.chip(), bench.chip()
    bench.faults.flip(bit=bit, seen_by=seen_by)
    send(sender, C04, m.CMR_TR | m.CMR_AT)
    bench.bits(120)
    assert chip.read(m.ECC) == code


SFF_PARTS = [
    (0, 0, 0x03), (1, 8, 0x02), (9, 11, 0x06), (12, 12, 0x04), (13, 13, 0x05), (14, 14, 0x09), (15, 18, 0x0B),
    (19, 26, 0x0A), (27, 41, 0x08),
]  # fmt: skip
EFF_PARTS = [
    (14, 18, 0x07), (19, 26, 0x0F), (27, 31, 0x0E), (32, 32, 0x0C), (33, 33, 0x0D), (34, 34, 0x09), (35, 38, 0x0B),
    (39, 46, 0x0A), (47, 61, 0x08),
]  # fmt: skip


@pytest.mark.parametrize(
    ("frame", "parts"),
    [(Frame(0x2AA, b"\x55"), SFF_PARTS), (Frame(0x0AAAAAAA, b"\x55", extended=True), EFF_PARTS)],
    ids=["SFF", "EFF"],
)
def test_each_bit_of_a_frame_belongs_to_its_part(bench: Bench, frame: Frame, parts: Any) -> None:
    """Inverted for the sender where that is a bit error, up to the first stuff bit."""
    sender = bench.chip(m.MOD_STM)
    layout = BitLayout(frame)
    first_stuff = next((k for k, stuffed in enumerate(layout.stuffed) if stuffed), len(layout.stuffed))
    for first, last, code in parts:
        for bit in range(first, last + 1):
            arbitration = bit <= (32 if frame.extended else 13)
            if bit >= first_stuff or (arbitration and layout.levels[bit] == 1):
                continue
            bench.faults.flip(bit=bit, seen_by="sender")
            send(sender, frame, m.CMR_TR | m.CMR_AT)
            bench.bits(200)
            assert sender.read(m.ECC) == code, bit
            sender.write(m.MOD, 1)
            sender.write(m.TXERR, 0)
            sender.write(m.MOD, m.MOD_STM)
            bench.bits(30)


def test_a_bit_error_in_the_error_flag(bench: Bench) -> None:
    """Nobody else sends: the flag is read recessive where a fault inverts it for its sender."""
    chip = bench.chip()
    bench.bus.bitwise = True
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(40)
    chip.segment = 0x11
    before = chip.peek(m.TXERR)
    chip.count(4, 0)
    assert chip.peek(m.TXERR) == before + 8
    assert chip.read(m.ECC) == 0x11
    chip.segment = 0x1C
    chip.count(5, 0)
    assert chip.read(m.ECC) == 0x3C
    chip.count(7, 0)
    assert chip.read(m.ECC) == 0x73
