"""The MCP2515 on a bus: three transmit buffers, aborts, one-shot mode, errors, bus-off."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import Frame
from canwire.chips.mcp2515 import register_map as m
from tests.chips.mcp2515.bench import BIT_NS, CNF, Bench, ask, frame_of, load, send
from tests.effort import examples
from tests.tables import mcp2515_vectors as table

pytestmark = pytest.mark.core


A, B, C = Frame(0x111, b"a"), Frame(0x222, b"bb"), Frame(0x333, b"ccc")
TXREQ, ABTF, MLOA, TXERR = m.TX_TXREQ, m.TX_ABTF, m.TX_MLOA, m.TX_TXERR


@pytest.fixture(params=[False, True], ids=["skipping", "bitwise"])
def bench(request: pytest.FixtureRequest) -> Bench:
    return Bench(bitwise=request.param)


@pytest.mark.parametrize("frame", [A, Frame(0x1ABCDEF5, bytes(8), extended=True), Frame(0x7FF, remote=True, dlc=3),
                                   Frame(0x1FFFFFFF, extended=True, remote=True, dlc=0)])  # fmt: skip
@pytest.mark.parametrize("buffer", range(3))
def test_frames_there_and_back(bench: Bench, frame: Frame, buffer: int) -> None:
    partner, chip = bench.partner(), bench.chip()
    send(chip, frame, buffer)
    assert chip.read(m.TXBCTRL[buffer]) == TXREQ
    bench.bits(200)
    assert partner.heard() == [frame]
    assert (chip.read(m.TXBCTRL[buffer]), chip.read(m.CANINTF)) == (0, m.INT_TX[buffer])
    partner.send(frame)
    bench.bits(200)
    assert frame_of(chip.read_buffer(0)) == frame


@pytest.mark.parametrize(("priorities", "order"), table.ORDER)
def test_transmit_priorities(bench: Bench, priorities: tuple[int, ...], order: tuple[int, ...]) -> None:
    partner, chip = bench.partner(), bench.chip()
    for buffer, priority in enumerate(priorities):
        load(chip, buffer, Frame(0x100 + buffer, b""), priority)
    chip.request_to_send(0b111)
    bench.bits(400)
    assert partner.ids() == [0x100 + buffer for buffer in order]


def test_a_higher_priority_goes_before_what_waits(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    load(chip, 2, C)
    load(chip, 1, B)
    chip.request_to_send(0b110)
    bench.bits(10)  # C is on the wire
    load(chip, 0, A, 3)
    chip.request_to_send(0b001)
    bench.bits(400)
    assert partner.heard() == [C, A, B]


def test_a_lost_arbitration_is_told_and_tried_again(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    partner.send(A)
    send(chip, B)
    bench.bits(75)
    assert chip.read(m.TXBCTRL[0]) == TXREQ | MLOA
    bench.bits(200)
    assert partner.heard() == [B]
    assert (chip.read(m.TXBCTRL[0]), chip.read(m.TEC)) == (MLOA, 0)
    send(chip, C)
    assert chip.read(m.TXBCTRL[0]) == TXREQ
    bench.bits(200)
    assert partner.heard() == [C]


def test_one_shot_mode_and_a_lost_arbitration(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    chip.modify(m.CANCTRL, m.CTRL_OSM, m.CTRL_OSM)
    partner.send(A)
    send(chip, B)
    bench.bits(300)
    assert partner.heard() == []
    assert chip.read(m.TXBCTRL[0]) == ABTF | MLOA
    assert not chip.read(m.CANINTF) & m.INT_TX0
    send(chip, C)
    bench.bits(200)
    assert (partner.heard(), chip.read(m.TXBCTRL[0])) == ([C], 0)


def test_a_handler_of_another_bus_can_send_whatever_happened_before(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    partner.send(A)
    send(chip, B)  # it loses, sends, and has received
    bench.bits(300)
    bench.faults.flip(bit="data", seen_by="sender")
    send(chip, B)
    bench.bits(300)
    assert (len(partner.heard()), chip.errors, chip.frames_received) == (2, 1, 1)
    near = Bench(timeline=bench.timeline)
    sender, ear = near.partner(), near.chip()
    ear.on_interrupt = lambda: send(chip, C)
    sender.send(A)
    bench.bits(300)
    assert partner.heard() == [C]


def test_one_shot_mode_and_an_error(bench: Bench) -> None:
    chip = bench.chip()
    chip.modify(m.CANCTRL, m.CTRL_OSM, m.CTRL_OSM)
    send(chip, A)
    bench.bits(2000)
    assert (chip.read(m.TXBCTRL[0]), chip.read(m.TEC)) == (ABTF | TXERR, 8)
    assert chip.read(m.CANINTF) == m.INT_MERR


def test_an_error_and_then_success(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    bench.faults.flip(bit="data", seen_by="sender")
    send(chip, A)
    bench.bits(60)
    assert (chip.read(m.TXBCTRL[0]), chip.read(m.TEC)) == (TXREQ | TXERR, 8)
    assert chip.read(m.CANINTF) == m.INT_MERR
    bench.bits(200)
    assert (partner.heard(), chip.read(m.TEC)) == ([A], 7)
    assert (chip.read(m.TXBCTRL[0]), chip.read(m.CANINTF)) == (TXERR, m.INT_MERR | m.INT_TX0)


def test_receive_errors_count(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    bench.faults.flip(bit="data", seen_by=chip)
    partner.send(C)
    bench.bits(300)
    assert (chip.read(m.REC), chip.read(m.CANINTF)) == (9 - 1, m.INT_MERR | m.INT_RX0)


def test_what_waits_is_given_up_at_once(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    load(chip, 2, C)
    load(chip, 1, B)
    chip.request_to_send(0b110)
    bench.bits(10)
    chip.modify(m.TXBCTRL[1], TXREQ, 0)
    assert chip.read(m.TXBCTRL[1]) == 0  # without ABTF, which only ABAT sets
    bench.bits(300)
    assert partner.heard() == [C]


def test_abat_gives_up_all_that_waits(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    for buffer, frame in enumerate((A, B, C)):
        load(chip, buffer, frame)
    chip.request_to_send(0b111)
    bench.bits(10)
    chip.modify(m.CANCTRL, m.CTRL_ABAT, m.CTRL_ABAT)
    assert [chip.read(at) for at in m.TXBCTRL] == [ABTF, ABTF, TXREQ]
    bench.bits(300)
    assert (partner.heard(), chip.read(m.TXBCTRL[2])) == ([C], 0)
    send(chip, A)
    assert chip.read(m.TXBCTRL[0]) == ABTF  # until ABAT is cleared
    chip.modify(m.CANCTRL, m.CTRL_ABAT, 0)
    send(chip, A)
    bench.bits(200)
    assert partner.heard() == [A]


@pytest.mark.parametrize("by_abat", [False, True])
def test_a_frame_on_the_wire_that_is_given_up_is_not_repeated(bench: Bench, by_abat: bool) -> None:
    partner, chip = bench.partner(), bench.chip()
    bench.faults.flip(bit="crc delimiter", seen_by="sender")
    send(chip, A)
    bench.bits(20)
    if by_abat:
        chip.modify(m.CANCTRL, m.CTRL_ABAT, m.CTRL_ABAT)
    else:
        chip.modify(m.TXBCTRL[0], TXREQ, 0)
    assert chip.read(m.TXBCTRL[0]) & TXREQ
    bench.bits(300)
    assert (partner.heard(), chip.read(m.TXBCTRL[0])) == ([], TXERR | (ABTF if by_abat else 0))


def test_given_up_after_a_lost_arbitration(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    partner.send(A)
    send(chip, B)
    bench.bits(20)  # A is ahead
    chip.modify(m.TXBCTRL[0], TXREQ, 0)
    assert chip.read(m.TXBCTRL[0]) == MLOA
    send(chip, C)
    bench.bits(300)
    assert partner.heard() == [C]
    assert frame_of(chip.read_buffer(0)) == A


def test_a_lone_sender_becomes_error_passive_and_stays_so(bench: Bench) -> None:
    chip = bench.chip()
    chip.write(m.CANINTE, m.INT_ERR)
    flags: list[int] = []

    def serve() -> None:
        flags.append(chip.read(m.EFLG))
        chip.modify(m.CANINTF, m.INT_ERR, 0)

    chip.on_interrupt = serve
    send(chip, A)
    bench.bits(10_000)
    assert (chip.read(m.TEC), flags) == (128, [0x05, 0x15])
    partner = bench.partner()
    bench.bits(5_000)
    assert partner.heard() == [A]
    assert (chip.read(m.TEC), flags) == (127, [0x05, 0x15, 0x05])


def test_bus_off_and_recovery_by_itself(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    bench.faults.flip(bit="dlc", seen_by="sender", times=32)
    send(chip, A)
    while chip.read(m.EFLG) & m.EFLG_TXBO == 0:
        bench.bits(1)
    off_ns = bench.timeline.now_ns
    assert (chip.read(m.EFLG), chip.read(m.TEC), chip.read(m.CANSTAT) >> 5) == (0x35, 255, m.NORMAL)
    assert chip.read(m.TXBCTRL[0]) == TXREQ | TXERR
    bench.bits(128 * 11 - 1)
    assert chip.read(m.EFLG) & m.EFLG_TXBO
    bench.bits(60)
    assert (chip.read(m.EFLG), chip.read(m.TEC)) == (0, 0)
    bench.bits(100)
    assert partner.heard() == [A]
    assert bench.timeline.now_ns - off_ns < 1700 * BIT_NS


def test_the_interrupt_handler_loads_the_next_frame(bench: Bench) -> None:
    partner, chip = bench.partner(), bench.chip()
    left = list(range(50))

    def serve() -> None:
        chip.modify(m.CANINTF, 0xFF, 0)
        if left:
            send(chip, Frame(left.pop(0), b""))

    chip.on_interrupt = serve
    serve()
    bench.bits(50 * 60)
    assert partner.ids() == list(range(50))


FRAMES = st.builds(
    lambda id, data, extended: Frame(id if extended else id & 0x7FF, data, extended=extended),
    st.integers(0, 0x1FFFFFFF), st.binary(max_size=8), st.booleans(),
)  # fmt: skip
STEP = st.tuples(
    st.sampled_from(["send", "partner", "abort", "abat", "osm", "noise"]),
    FRAMES,
    st.integers(0, 2),
    st.integers(1, 200),
)


@examples(30)
@given(st.lists(STEP, max_size=14))
def test_whole_frames_and_single_bits_come_to_the_same(steps: list[tuple[str, Frame, int, int]]) -> None:
    outcomes = []
    for bitwise in (False, True):
        bench = Bench(bitwise=bitwise)
        partner, chip = bench.partner(), bench.chip(bukt=True)
        for what, frame, buffer, pause in steps:
            if what == "send":
                load(chip, buffer, frame, pause & 3)
                chip.request_to_send(1 << buffer)
            elif what == "partner":
                partner.send(frame)
            elif what == "abort":
                chip.modify(m.TXBCTRL[buffer], TXREQ, 0)
            elif what == "noise":
                bench.faults.flip(bit="dlc", seen_by="all")
            else:
                bit = m.CTRL_ABAT if what == "abat" else m.CTRL_OSM
                chip.modify(m.CANCTRL, bit, ~chip.read(m.CANCTRL))
            bench.bits(pause + 0.15)  # never at the very moment when a bit begins
            if pause & 1:
                chip.modify(m.CANINTF, 0xFF, 0)
        bench.bits(3000)
        registers = bytes(chip.read(at) for at in range(128))
        outcomes.append(
            (registers, [(frame.id, frame.data, frame.timestamp_ns) for frame in partner.heard()])
        )
    assert outcomes[0] == outcomes[1]


ACCESS = st.tuples(
    st.sampled_from("wmlrsx"),
    st.integers(0, 127),
    st.integers(0, 255),
    st.integers(0, 255),
    st.integers(0, 90),
)


@examples(60)
@given(st.lists(ACCESS, max_size=40), st.booleans())
def test_whatever_is_done_to_it_a_reset_puts_right(
    accesses: list[tuple[str, int, int, int, int]], bitwise: bool
) -> None:
    """Random accesses in the middle of traffic: the chip makes sense throughout, and the bus lives on."""
    bench = Bench(bitwise=bitwise)
    partner, another, chip = bench.partner(), bench.partner("another"), bench.chip()
    for kind, address, mask, value, pause in accesses:
        if kind == "w":
            chip.write(address, value)
        elif kind == "m":
            chip.modify(m.CANCTRL if address & 1 else address, mask, value)
        elif kind == "l":
            chip.load_buffer(address % 3, bytes([value]) * (mask % 14))
        elif kind == "r":
            chip.request_to_send(value & 7)
        elif kind == "s":
            partner.send(Frame(address << 4, bytes([value])))
        else:
            chip.read_buffer(address & 1)
        bench.bits(pause + 0.15)
        assert chip.interrupt == bool(chip.read(m.CANINTE) & chip.read(m.CANINTF))
        assert chip.read(m.CANSTAT) >> 5 == chip.mode
        assert not (chip.on_bus and (chip.asleep or chip.mode in (m.CONFIGURATION, m.SLEEP, m.LOOP_BACK)))
        assert (chip.offer is not None) == any(chip.read(at) & TXREQ for at in m.TXBCTRL)
    chip.reset()
    bench.bits(5000)
    for address, value in CNF:
        chip.write(address, value)
    chip.write(m.RXBCTRL[0], 0x60)
    ask(chip, m.NORMAL)
    bench.bits(5000)
    partner.heard()
    another.heard()
    send(chip, A)
    bench.bits(5000)
    assert A in another.heard()
    chip.read_buffer(0)
    another.send(B)
    bench.bits(5000)
    assert frame_of(chip.read_buffer(0)) == B
