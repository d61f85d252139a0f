"""Where chips sample a bit, once or thrice, and at which bit of a frame they store it: the same whole and bit by bit.

Sources: SJA1000 data sheet 6.4.5 (RBS) and 6.5.2 (SAM); DS20001801 chapter 5 (SAM); ISO 11898-1 10.7.
"""

from __future__ import annotations

from typing import Any

import pytest

from canwire.chips.mcp2515 import register_map as mcp
from canwire.chips.mcp2515.controller import Mcp2515
from canwire.chips.sja1000 import register_map as sja
from canwire.chips.sja1000.controller import Sja1000
from canwire.values.frame import Frame
from tests.chips.mcp2515.bench import BIT_NS, CNF, Bench, Partner, ask, mode_of

pytestmark = pytest.mark.core

FRAME = Frame(0x123, b"\x11\x22")  # 62 bits; its identifier begins with 001
BITS, LAST_BUT_ONE = 62, 60
SAMPLE_NS = {"sja1000": 1_750, "mcp2515": 1_500}
QUANTUM_NS = 125
CHIPS = pytest.mark.parametrize("kind", ["sja1000", "mcp2515"])


@pytest.fixture(params=[False, True], ids=["whole frames", "bit by bit"])
def bench(request: pytest.FixtureRequest) -> Bench:
    return Bench(bitwise=request.param)


def some_chip(bench: Bench, kind: str, *, thrice: bool = False) -> Any:
    """One on the bench's bus that takes in everything, and samples each bit once or thrice."""
    chip: Any
    if kind == "sja1000":
        chip = Sja1000(bench.bus)
        btr1 = 0x1C | (sja.BTR1_SAM if thrice else 0)
        put = ((sja.CDR, sja.CDR_PELICAN), (sja.BTR0, 0), (sja.BTR1, btr1), (sja.IER, sja.IER_RIE))
        for address, value in (*put, *((sja.AMR0 + k, 0xFF) for k in range(4)), (sja.MOD, sja.MOD_AFM)):
            chip.write(address, value)
    else:
        chip = Mcp2515(bench.bus)
        for address, value in (*CNF, (mcp.CANINTE, mcp.INT_RX0 | mcp.INT_RX1)):
            sampled = mcp.CNF2_SAM if thrice and address == mcp.CNF2 else 0
            chip.write(address, value | sampled)
        for control in mcp.RXBCTRL:
            chip.write(control, mcp.RXM_ALL << mcp.RX_RXM_SHIFT)
        ask(chip, mcp.NORMAL)
    bench.bits(20)
    return chip


def stored(chip: Any) -> int:
    """How many frames wait in it."""
    if isinstance(chip, Sja1000):
        return chip.read(sja.RMC)
    return sum(chip.read(mcp.CANINTF) & flag != 0 for flag in (mcp.INT_RX0, mcp.INT_RX1))


def send_at_once(bench: Bench, partner: Partner) -> int:
    """The time of its SOF."""
    partner.send(FRAME)
    return bench.timeline.now_ns


# the bit at which a frame is stored


@CHIPS
def test_a_frame_is_stored_at_the_last_bit_of_eof_but_one(bench: Bench, kind: str) -> None:
    partner, chip = bench.partner(), some_chip(bench, kind)
    told: list[tuple[int, int]] = []
    chip.on_interrupt = lambda: told.append((bench.timeline.now_ns, stored(chip)))
    sof_ns = send_at_once(bench, partner)
    valid_ns = sof_ns + LAST_BUT_ONE * BIT_NS + SAMPLE_NS[kind]
    bench.timeline.run_until(valid_ns - 1)
    assert (stored(chip), chip.frames_received) == (0, 0)
    bench.timeline.run_until(valid_ns)
    assert (stored(chip), chip.frames_received) == (1, 1)
    bench.bits(20)
    assert told == [(valid_ns, 1)]
    assert (stored(chip), chip.frames_received) == (1, 1)


@CHIPS
def test_its_sender_is_told_where_eof_ends(bench: Bench, kind: str) -> None:
    chip, partner = some_chip(bench, kind), bench.partner()
    sof_ns = bench.timeline.now_ns
    if kind == "sja1000":
        for at, octet in enumerate(bytes.fromhex("0224601122")):
            chip.write(sja.TX_BUFFER + at, octet)
        chip.write(sja.CMR, sja.CMR_TR)
    else:
        chip.load_buffer(0, bytes.fromhex("24600000021122"))
        chip.request_to_send(1)
    bench.timeline.run_until(sof_ns + BITS * BIT_NS - 1)
    assert chip.frames_sent == 0
    bench.timeline.run_until(sof_ns + BITS * BIT_NS)
    assert (chip.frames_sent, partner.heard()) == (1, [FRAME])


@CHIPS
@pytest.mark.parametrize(("bit", "copies"), [(LAST_BUT_ONE - 1, 1), (LAST_BUT_ONE, 1), (LAST_BUT_ONE + 1, 2)])
def test_an_error_in_the_last_bit_alone_makes_two_of_it(
    bench: Bench, kind: str, bit: int, copies: int
) -> None:
    """ISO 11898-1: the sender repeats what its receivers have taken."""
    partner, chip = bench.partner(), some_chip(bench, kind)
    bench.faults.flip(bit=bit, seen_by="all")
    send_at_once(bench, partner)
    bench.bits(300)
    assert chip.frames_received == copies
    assert bench.bus.tally.frames == 1


@CHIPS
def test_a_chip_that_leaves_the_bus_when_it_has_a_frame_has_it_once(bench: Bench, kind: str) -> None:
    partner, other = bench.partner(), bench.partner("other")
    chip = some_chip(bench, kind)

    def leave() -> None:
        if kind == "sja1000":
            chip.write(sja.MOD, sja.MOD_RM)
        else:
            ask(chip, mcp.CONFIGURATION)

    chip.on_interrupt = leave
    sof_ns = send_at_once(bench, partner)
    bench.bits(200)
    assert chip.frames_received == 1
    assert not chip.on_bus
    assert [frame.id for frame in other.heard()] == [FRAME.id]
    assert bench.bus.busy_ns() == (BITS + 3) * BIT_NS, sof_ns


def test_a_mode_that_was_asked_for_comes_between_two_frames_of_a_full_bus(bench: Bench) -> None:
    partner, chip = bench.partner(), some_chip(bench, "mcp2515")
    for _ in range(50):
        partner.send(FRAME)
    bench.bits(30)
    ask(chip, mcp.LISTEN_ONLY)
    assert mode_of(chip) == mcp.NORMAL
    bench.bits(BITS)
    assert mode_of(chip) == mcp.LISTEN_ONLY


def test_a_looker_in_the_last_bits_changes_nothing(bench: Bench) -> None:
    """Between storing and the end of the frame somebody else comes and goes."""
    partner, chip = bench.partner(), some_chip(bench, "sja1000")
    sof_ns = send_at_once(bench, partner)
    bench.timeline.run_until(sof_ns + LAST_BUT_ONE * BIT_NS + SAMPLE_NS["sja1000"] + 100)
    assert stored(chip) == 1
    bench.bus.interrupt()
    bench.bits(20)
    assert (stored(chip), chip.frames_received) == (1, 1)


# three samples


@CHIPS
@pytest.mark.parametrize("thrice", [False, True], ids=["once", "thrice"])
@pytest.mark.parametrize(
    ("begin", "end", "errors"),
    [(1 / 2, -1 / 4, (1, 0)), (5 / 4, -1 / 4, (1, 1)), (5 / 4, 3 / 4, (0, 0)), (9 / 4, 3 / 4, (0, 1))],
    ids=["the last sample", "the last two", "the middle one", "the first two"],
)
def test_of_three_samples_two_decide(
    bench: Bench, kind: str, thrice: bool, begin: float, end: float, errors: tuple[int, int]
) -> None:
    """A recessive glitch in a dominant bit, from and to so many gaps between samples before the sample point."""
    partner, chip = bench.partner(), some_chip(bench, kind, thrice=thrice)
    gap_ns = QUANTUM_NS if kind == "sja1000" else QUANTUM_NS / 2
    bench.faults.glitch(
        "recessive", at=bench.faults.place("frame", 2), from_ns=SAMPLE_NS[kind] - begin * gap_ns,
        width_ns=(begin - end) * gap_ns, seen_by=[chip],
    )  # fmt: skip
    send_at_once(bench, partner)
    bench.bits(300)
    assert (chip.errors, stored(chip)) == (errors[thrice], 1)


@CHIPS
def test_frames_of_a_bus_that_is_sampled_thrice_are_stepped_over(bench: Bench, kind: str) -> None:
    partner, chip = bench.partner(), some_chip(bench, kind, thrice=True)
    bench.bus.bits.clocks.clear()
    send_at_once(bench, partner)
    bench.bits(100)
    assert stored(chip) == 1
    assert (bench.bus.bits.now_ps > 0) == bench.bus.bitwise


@CHIPS
def test_a_drifting_chip_that_samples_thrice_hears_what_is_sent(bench: Bench, kind: str) -> None:
    partner, chip = bench.partner(), some_chip(bench, kind)
    thrice = some_chip(bench, kind, thrice=True)
    for one, ppm in ((chip, 1_000.0), (thrice, -1_000.0)):
        one.oscillator_ppm = ppm
        if kind == "sja1000":
            one.write(sja.MOD, sja.MOD_RM)
            one.write(sja.MOD, sja.MOD_AFM)
        else:
            ask(one, mcp.CONFIGURATION)
            ask(one, mcp.NORMAL)
    bench.bits(20)
    send_at_once(bench, partner)
    bench.bits(200)
    assert [one.errors for one in (chip, thrice)] == [0, 0]
    assert [stored(one) for one in (chip, thrice)] == [1, 1]
