"""The register-accurate SJA1000: what an access costs, and a saturated bus received by polling."""

from __future__ import annotations

import time

from shared import pour, sender, served
from workloads import median

import canwire
from canwire.bus.can.bus import CanBus
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from canwire.timeline import Timeline

MILLION = 1_000_000


def chip_on(bus: CanBus | None, enabled: int) -> Sja1000:
    """A chip in PeliCAN mode that takes everything, at 1 Mbit/s."""
    chip = Sja1000(bus)
    chip.write(m.BTR0, 0x00)
    chip.write(m.BTR1, 0x14)
    chip.write(m.CDR, m.CDR_PELICAN)
    for k in range(4):
        chip.write(m.AMR0 + k, 0xFF)
    chip.write(m.IER, enabled)
    chip.write(m.MOD, m.MOD_AFM)
    return chip


def accesses(count: int) -> tuple[float, float]:
    """ns for a read of SR, and for a write of a byte of the transmit buffer; the loop's own time taken off."""
    timeline = Timeline()
    chip = chip_on(CanBus(timeline), 0)
    timeline.run_until(MILLION)
    read, write, turns = chip.read, chip.write, range(count)
    began = time.perf_counter_ns()
    for _ in turns:
        pass
    empty = time.perf_counter_ns()
    for _ in turns:
        read(m.SR)
    between = time.perf_counter_ns()
    for _ in turns:
        write(m.TX_BUFFER, 8)
    ended = time.perf_counter_ns()
    loop = empty - began
    return (between - empty - loop) / count, (ended - between - loop) / count


def polling(seconds: float) -> tuple[float, float]:
    """One chip sends 8-byte frames without a pause, one is polled: frames/s of processor, times real time."""
    timeline = Timeline()
    bus = CanBus(timeline)
    sender, receiver = chip_on(bus, m.IER_TIE), chip_on(bus, 0)
    sender.write(m.TX_BUFFER, 8)

    def again() -> None:
        sender.read(m.IR)
        sender.write(m.CMR, m.CMR_TR)

    sender.on_interrupt = again
    sender.write(m.CMR, m.CMR_TR)
    read, write, frames = receiver.read, receiver.write, 0
    began = time.perf_counter()
    for now_ns in range(0, round(seconds * 1e9), 300_000):
        timeline.run_until(now_ns)
        while read(m.SR) & m.SR_RBS:
            for address in range(m.RX_WINDOW, m.RX_WINDOW + 11):
                read(address)
            write(m.CMR, m.CMR_RRB)
            frames += 1
    spent = time.perf_counter() - began
    return frames / spent, seconds / spent


def real_time(seconds: float) -> tuple[float, float, int]:
    """A saturated 1 Mbit/s bus from one SJA1000 line to another: the hub's share of a core in %, frames/s, losses."""
    timing = canwire.BitTiming.from_btr(0x00, 0x14)
    with served("real") as hub_process, canwire.connect(hub_process.address) as hub:
        boards = [hub.plug("pc-i04").id for _ in range(2)]
        for board in boards:
            control = hub.open_control(board, 0)
            control.initialise(canwire.LineMode(timing))
            control.start()
        listener = hub.open_channel(boards[1], 0)
        listener.set_up(canwire.ChannelMode(1 << 18, 0))
        listener.activate()
        channel = sender(hub, boards[0])
        used, began = hub_process.processor_s(), time.perf_counter()
        pour(channel, round(8000 * seconds))
        while channel.status().pending:
            time.sleep(0.05)
        spent = time.perf_counter() - began
        share = 100 * (hub_process.processor_s() - used) / spent
        sent, got = channel.status().delivered, len(listener.receive_array())
    return share, sent / spent, sent - got


def rows(scale: int, runs: int) -> list[tuple[str, str, str, str]]:
    """For the table of run.py."""
    reads = median(lambda: accesses(MILLION // scale)[0], runs)
    writes = median(lambda: accesses(MILLION // scale)[1], runs)
    frames = median(lambda: polling(10 / scale)[0], runs)
    faster = median(lambda: polling(10 / scale)[1], runs)
    share, speed, missing = real_time(max(2.0, 20 / scale))
    return [
        ("SJA1000, a register read / written", f"{reads:.0f} / {writes:.0f} ns", "", "2,000 ns"),
        (
            "  one sends at 1 Mbit/s, one is polled",
            f"{frames:,.0f} frames/s, {faster:.0f} x real time",
            "",
            "2 x",
        ),
        (
            "  real time, 1 Mbit/s saturated, SJA1000 to SJA1000 line",
            f"hub {share:.0f} % of a core, {speed:,.0f} frames/s, {missing} lost",
            "",
            "< 60 %, 0 lost",
        ),
    ]
