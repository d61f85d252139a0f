"""The SJA1000 among other nodes: vectors R24 to R44, transmission, errors, arbitration, bus-off."""

from __future__ import annotations

import pytest

from canwire.bus.can.node import Mailbox, Node
from canwire.chips.sja1000 import register_map as m
from canwire.chips.sja1000.controller import Sja1000
from canwire.values.frame import Frame, frame_of_record
from tests.bus.can.test_sender_errors import some_frame_with_stuff_bit
from tests.chips.sja1000.bench import Bench, get, put, send
from tests.tables import sja1000_vectors

pytestmark = pytest.mark.core

C04 = Frame(0x123, b"\x11\x22")
C04_STREAM = "00010010001100000110000100010010001000001100101101111011111111"
FRAME_BITS = 140  # room for any frame
BOTH_WAYS = pytest.mark.parametrize("bitwise", [False, True], ids=["whole frames", "bit by bit"])
ALL_DATA = bytes(range(1, 9))


def levels_of(bench: Bench, chip: Sja1000) -> str:
    """The bits on the wire while the chip sends what its transmit buffer holds."""
    changes: list[tuple[int, int]] = []
    bench.bus.bitwise = True
    bench.bus.bits.capture = lambda at_ps, level: changes.append((at_ps, level))
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(FRAME_BITS)
    first = changes[0][0]
    text = ""
    for (at, level), (then, _) in zip(changes, [*changes[1:], (first + 62 * 2_000_000, 1)], strict=True):
        text += str(level) * ((then - at) // 2_000_000)
    return text


def test_r24_the_wire_shows_the_frame_of_the_buffer(bench: Bench) -> None:
    chip, _ = bench.chip(), bench.chip()
    put(chip, m.TX_BUFFER, "02 24 60 11 22")
    assert levels_of(bench, chip) == C04_STREAM


@pytest.mark.parametrize(
    ("number", "buffer", "id", "extended", "remote", "data", "window"), sja1000_vectors.FRAMES
)
def test_r24_r25_buffers(
    bench: Bench, number: str, buffer: str, id: int, extended: bool, remote: bool, data: str, window: str
) -> None:
    sender, receiver = bench.chip(), bench.chip()
    told: list[Frame] = []
    observe(bench, told)
    put(sender, m.TX_BUFFER, buffer)
    sender.write(m.CMR, m.CMR_TR)
    assert sender.read(m.SR) & 0x0C == 0
    bench.bits(FRAME_BITS)
    dlc = int(buffer[:2], 16) & 15
    assert told == [Frame(id, bytes.fromhex(data), extended=extended, remote=remote, dlc=dlc)]
    assert sender.read(m.SR) & 0x0C == 0x0C
    assert sender.read(m.IR) == m.IR_TI
    count = len(bytes.fromhex(buffer))
    assert get(sender, m.TX_RAM, count) == buffer
    assert get(receiver, m.RX_WINDOW, count) == window


def observe(bench: Bench, told: list[Frame]) -> None:
    """An ideal listener."""

    class Listener(Node):
        def received(self, box: Mailbox, at_ns: int) -> None:
            told.append(frame_of_record(box.record()))

        def error(self, kind: int, bit: int, transmitting: bool, rule: int, at_ns: int) -> None:
            pass

    listener = Listener()
    listener.listen_only = listener.on_bus = True
    bench.bus.attach(listener)


@pytest.mark.parametrize(("buffer", "id", "remote", "data"), sja1000_vectors.BASIC_FRAMES)
def test_r26_basic_buffers(bench: Bench, buffer: str, id: int, remote: bool, data: str) -> None:
    sender, receiver = bench.basic_chip(), bench.basic_chip()
    told: list[Frame] = []
    observe(bench, told)
    put(sender, m.BASIC_TX_BUFFER, buffer)
    sender.write(m.BASIC_CMR, m.CMR_TR)
    bench.bits(FRAME_BITS)
    assert told == [Frame(id, bytes.fromhex(data), remote=remote, dlc=2)]
    assert get(receiver, m.BASIC_RX_WINDOW, len(bytes.fromhex(buffer))) == buffer
    assert receiver.read(m.BASIC_IR) == 0xE0 | m.IR_RI
    assert sender.read(m.BASIC_IR) == 0xE0 | m.IR_TI


@BOTH_WAYS
def test_r27_a_single_shot_that_nobody_acknowledges(bench: Bench, bitwise: bool) -> None:
    bench.bus.bitwise = bitwise
    chip = bench.chip()
    chip.write(m.CMR, m.CMR_TR | m.CMR_AT)
    bench.bits(FRAME_BITS)
    assert (chip.read(m.IR), chip.read(m.ECC), chip.read(m.TXERR)) == (m.IR_BEI | m.IR_TI, 0xD9, 8)
    assert chip.read(m.SR) == m.SR_TBS
    bench.bits(FRAME_BITS)
    assert chip.read(m.TXERR) == 8


@BOTH_WAYS
def test_r28_alone_it_turns_passive_and_stays(bench: Bench, bitwise: bool) -> None:
    bench.bus.bitwise = bitwise
    chip = bench.chip()
    seen: list[tuple[int, int]] = []

    def note() -> None:
        seen.append((chip.read(m.TXERR), chip.read(m.IR)))
        chip.read(m.ECC)

    chip.on_interrupt = note
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(4000)
    assert [tec for tec, _ in seen][:17] == [*range(8, 129, 8), 128]
    assert {tec for tec, _ in seen[16:]} == {128}
    expected = [m.IR_BEI] * 40
    expected[11] |= m.IR_EI
    expected[15] |= m.IR_EPI
    assert [bits for _, bits in seen][:40] == expected
    assert chip.read(m.SR) & (m.SR_BS | m.SR_ES) == m.SR_ES


@BOTH_WAYS
@pytest.mark.parametrize("wait", range(0, 90, 7))
def test_r29_an_abort_ends_the_repetition(bench: Bench, bitwise: bool, wait: int) -> None:
    bench.bus.bitwise = bitwise
    chip = bench.chip()
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(2000 + wait)
    chip.write(m.CMR, m.CMR_AT)
    bench.bits(FRAME_BITS)
    assert chip.read(m.SR) & 0x0C == 0x04
    assert chip.read(m.IR) & m.IR_TI
    chip.read(m.ECC)
    bench.bits(1000)
    assert chip.read(m.IR) == 0


@BOTH_WAYS
def test_r30_self_test_needs_no_acknowledge(bench: Bench, bitwise: bool) -> None:
    bench.bus.bitwise = bitwise
    chip = bench.chip(m.MOD_STM)
    put(chip, m.TX_BUFFER, "02 24 60 11 22")
    chip.write(m.CMR, m.CMR_SRR)
    bench.bits(4 * FRAME_BITS)
    assert (chip.read(m.TXERR), chip.read(m.RMC), chip.read(m.IR)) == (0, 1, 0x03)
    assert get(chip, m.RX_WINDOW, 5) == "02 24 60 11 22"
    assert bench.bus.tally.frames == 1


def test_r31_tr_beside_srr_is_no_self_reception(bench: Bench) -> None:
    chip = bench.chip(m.MOD_STM)
    chip.write(m.CMR, m.CMR_TR | m.CMR_SRR)
    bench.bits(FRAME_BITS)
    assert (chip.read(m.RMC), chip.read(m.IR)) == (0, m.IR_TI)


def test_self_reception_beside_others_needs_their_acknowledge(bench: Bench) -> None:
    chip, other = bench.chip(), bench.chip()
    send(chip, C04, m.CMR_SRR)
    bench.bits(FRAME_BITS)
    assert (chip.read(m.RMC), other.read(m.RMC)) == (1, 1)
    assert chip.read(m.IR) == m.IR_RI | m.IR_TI


def test_self_reception_obeys_the_filter(bench: Bench) -> None:
    chip = bench.chip(m.MOD_STM | m.MOD_AFM, acr="FFFFFFFF", amr="00000000")
    send(chip, C04, m.CMR_SRR)
    bench.bits(FRAME_BITS)
    assert (chip.read(m.RMC), chip.read(m.IR)) == (0, m.IR_TI)


def test_a_single_shot_self_reception(bench: Bench) -> None:
    chip = bench.chip(m.MOD_AFM)
    send(chip, C04, m.CMR_SRR | m.CMR_AT)
    bench.bits(4 * FRAME_BITS)
    assert (chip.read(m.TXERR), chip.read(m.RMC), chip.read(m.SR) & 0x0C) == (8, 0, 0x04)


def test_tr_srr_at_is_a_single_shot_without_self_reception(bench: Bench) -> None:
    chip = bench.chip(m.MOD_STM)
    send(chip, C04, m.CMR_TR | m.CMR_SRR | m.CMR_AT)
    bench.bits(FRAME_BITS)
    assert (chip.read(m.RMC), chip.read(m.SR) & 0x0C) == (0, 0x0C)


@BOTH_WAYS
def test_r39_lost_arbitration_is_captured_once(bench: Bench, bitwise: bool) -> None:
    bench.bus.bitwise = bitwise
    winner, loser = bench.chip(), bench.chip()
    for k in range(2):
        for chip, id in ((winner, 0x100 >> k), (loser, 0x104)):
            send(chip, Frame(id))
        bench.bits(FRAME_BITS)
        assert loser.read(m.IR) & m.IR_ALI == (m.IR_ALI if k == 0 else 0)
        assert loser.peek(m.ALC) == 8
        assert winner.read(m.ALC) == 0
    assert loser.read(m.ALC) == 8
    send(winner, Frame(0x100))
    send(loser, Frame(0x300))
    bench.bits(FRAME_BITS)
    assert loser.read(m.IR) & m.IR_ALI
    assert loser.read(m.ALC) == 1
    assert loser.read(m.ALC) == 1  # kept [INT]


@BOTH_WAYS
@pytest.mark.parametrize(
    ("what", "loser", "winner", "alc"), sja1000_vectors.LOSSES, ids=[row[0] for row in sja1000_vectors.LOSSES]
)
def test_r40_the_bit_that_was_lost(
    bench: Bench, what: str, loser: tuple[str, str], winner: tuple[str, str], alc: int, bitwise: bool
) -> None:
    bench.bus.bitwise = bitwise
    one, other = bench.chip(), bench.chip()
    for chip, (head, id) in ((one, winner), (other, loser)):
        put(chip, m.TX_BUFFER, head + id)
        chip.write(m.CMR, m.CMR_TR)
    bench.bits(FRAME_BITS)
    assert other.read(m.ALC) == alc
    assert (one.read(m.RMC), other.read(m.RMC)) == (0 if one.read(m.SR) & m.SR_RBS == 0 else 1, 1)
    bench.bits(FRAME_BITS)
    assert other.read(m.SR) & m.SR_TCS


def test_r41_six_dominant_bits_from_idle(bench: Bench) -> None:
    chip = bench.chip()
    bench.bus.short(True)
    bench.bits(6)
    bench.bus.short(False)
    bench.bits(40)
    assert (chip.read(m.ECC), chip.read(m.RXERR)) == (0xA2, 1)
    assert chip.read(m.IR) == m.IR_BEI


def test_r42_one_data_bit_inverted_for_the_sender(bench: Bench) -> None:
    sender, receiver = bench.chip(), bench.chip()
    bench.faults.flip(bit="data", seen_by="sender")
    send(sender, Frame(0x123, ALL_DATA), m.CMR_TR | m.CMR_AT)
    bench.bits(FRAME_BITS)
    assert (sender.read(m.ECC), sender.read(m.TXERR)) == (0x0A, 8)
    assert (receiver.read(m.ECC), receiver.read(m.RXERR)) == (0xAA, 1)


def test_r43_a_crc_error_at_one_of_three(bench: Bench) -> None:
    sender, wrong, third = bench.chip(), bench.chip(), bench.chip()
    bench.faults.flip(bit="crc", seen_by=wrong)
    send(sender, C04, m.CMR_TR | m.CMR_AT)
    bench.bits(FRAME_BITS)
    assert (wrong.read(m.ECC), wrong.read(m.RXERR)) == (0xFB, 9)
    assert (sender.read(m.ECC), sender.read(m.TXERR)) == (0x1A, 8)
    assert (third.read(m.ECC), third.read(m.RXERR)) == (0x7A, 1)
    assert [chip.read(m.RMC) for chip in (sender, wrong, third)] == [0, 0, 0]


def test_two_nodes_crc_error(bench: Bench) -> None:
    """The sender's own acknowledge error comes first and hits the receiver in the ACK delimiter."""
    sender, wrong = bench.chip(), bench.chip()
    bench.faults.flip(bit="crc", seen_by=wrong)
    send(sender, C04, m.CMR_TR | m.CMR_AT)
    bench.bits(FRAME_BITS)
    assert sender.read(m.ECC) == 0xD9
    assert wrong.read(m.ECC) == 0x7B


def test_r44_thirty_two_disturbed_attempts_lead_to_bus_off(bench: Bench) -> None:
    sender, _ = bench.chip(enabled=m.IER_EIE | m.IER_BEIE), bench.chip()
    bench.faults.flip(bit="data", times=None, seen_by="sender")
    send(sender, C04)
    bench.bits(32 * 200)
    assert sender.errors == 32
    assert (sender.read(m.MOD) & 1, sender.read(m.TXERR), sender.read(m.RXERR)) == (1, 127, 0)
    assert sender.read(m.SR) == 0xF4
    assert sender.read(m.IR) & m.IR_EI
    assert bench.bus.tally.error_frames == 32


@BOTH_WAYS
def test_recovery_from_bus_off_counts_on_in_traffic(bench: Bench, bitwise: bool) -> None:
    bench.bus.bitwise = bitwise
    off, *others = bench.chip(), bench.chip(), bench.chip()
    off.write(m.MOD, 1)
    off.write(m.TXERR, 255)
    off.write(m.MOD, 0)
    off.read(m.IR)
    off.write(m.MOD, 0)
    seen = []
    for k in range(60):
        send(others[k % 2], Frame(0x10, ALL_DATA))
        bench.bits(300)
        seen.append(off.read(m.TXERR))
    assert seen == sorted(seen, reverse=True)
    assert seen[0] in range(108, 127)
    assert len(set(seen)) > 5
    assert (off.read(m.SR) & (m.SR_BS | m.SR_TS), off.read(m.IR) & m.IR_EI) == (0, m.IR_EI)
    assert (off.read(m.TXERR), off.read(m.RXERR)) == (0, 0)
    send(off, C04)
    bench.bits(FRAME_BITS)
    assert off.read(m.SR) & m.SR_TCS


def test_status_shows_who_sends_and_who_receives(bench: Bench) -> None:
    sender, receiver = bench.chip(), bench.chip()
    send(sender, Frame(0x123, ALL_DATA))
    bench.bits(30)
    assert (sender.read(m.SR) & 0x30, receiver.read(m.SR) & 0x30) == (m.SR_TS, m.SR_RS)
    bench.bits(FRAME_BITS)
    assert (sender.read(m.SR) & 0x30, receiver.read(m.SR) & 0x30) == (0, 0)


@pytest.mark.parametrize("wait", [5, 60, 100])
def test_reset_in_the_middle_of_a_frame_stops_it_at_that_bit(bench: Bench, wait: int) -> None:
    sender, receiver = bench.chip(), bench.chip()
    send(sender, Frame(0x123, ALL_DATA))
    bench.bits(wait)
    sender.write(m.MOD, m.MOD_RM)
    assert sender.read(m.SR) == 0x34
    bench.bits(2 * FRAME_BITS)
    assert receiver.read(m.RMC) == 0
    assert receiver.read(m.RXERR) == 1
    sender.write(m.MOD, 0)
    bench.bits(2 * FRAME_BITS)
    assert receiver.read(m.RMC) == 0
    assert sender.read(m.SR) & m.SR_TCS == 0


@pytest.mark.parametrize("wait", [5, 60, 100])
def test_a_receiver_s_reset_in_the_middle_of_a_frame(bench: Bench, wait: int) -> None:
    sender, receiver, other = bench.chip(), bench.chip(), bench.chip()
    send(sender, Frame(0x123, ALL_DATA))
    bench.bits(wait)
    receiver.write(m.MOD, m.MOD_RM)
    receiver.write(m.MOD, 0)
    bench.bits(FRAME_BITS)
    assert (receiver.read(m.RMC), other.read(m.RMC)) == (0, 1)
    assert receiver.read(m.SR) & 0x30 == 0


def test_the_transmit_buffer_is_locked_while_a_request_is_pending(bench: Bench) -> None:
    sender, receiver = bench.chip(), bench.chip()
    send(sender, C04)
    put(sender, m.TX_BUFFER, "00 FF FF")
    bench.bits(FRAME_BITS)
    assert get(receiver, m.RX_WINDOW, 5) == "02 24 60 11 22"
    put(sender, m.TX_BUFFER, "00 FF E0")
    assert get(sender, m.TX_RAM, 3) == "00 FF E0"


def test_a_frame_may_be_loaded_anew_inside_the_interrupt(bench: Bench) -> None:
    sender, receiver = bench.chip(enabled=m.IER_TIE), bench.chip()
    left = [4]

    def again() -> None:
        assert sender.read(m.IR) == m.IR_TI
        if left[0]:
            left[0] -= 1
            sender.write(m.TX_BUFFER + 1, left[0])
            sender.write(m.CMR, m.CMR_TR)

    sender.on_interrupt = again
    sender.write(m.CMR, m.CMR_TR)
    bench.bits(5 * 60)
    ids = []
    while receiver.read(m.SR) & m.SR_RBS:
        ids.append(receiver.read(m.RX_WINDOW + 1))
        receiver.write(m.CMR, m.CMR_RRB)
    assert ids == [0, 3, 2, 1, 0]


@BOTH_WAYS
def test_listening_only(bench: Bench, bitwise: bool) -> None:
    bench.bus.bitwise = bitwise
    listener, sender, other = bench.chip(m.MOD_LOM), bench.chip(), bench.chip()
    send(sender, C04)
    bench.bits(FRAME_BITS)
    assert listener.read(m.RMC) == 1
    other.write(m.MOD, 1)
    send(sender, C04)
    send(listener, C04)
    bench.bits(2000)
    assert sender.read(m.TXERR) == 128  # it does not acknowledge
    assert (listener.read(m.RXERR), listener.read(m.TXERR), listener.read(m.SR) & 0x0C) == (0, 0, 0)
    assert listener.read(m.IR) & m.IR_BEI


def test_the_error_warning_limit_can_be_set(bench: Bench) -> None:
    chip = bench.chip()
    chip.write(m.MOD, 1)
    chip.write(m.EWLR, 16)
    chip.write(m.MOD, 0)
    bench.bits(20)
    chip.read(m.IR)
    chip.write(m.CMR, m.CMR_TR)
    bench.bits(60)
    assert (chip.read(m.TXERR), chip.read(m.SR) & m.SR_ES) == (8, 0)
    bench.bits(60)
    assert (chip.read(m.TXERR), chip.read(m.SR) & m.SR_ES) == (16, m.SR_ES)
    assert chip.read(m.IR) & m.IR_EI


def test_a_pending_frame_can_be_given_up_while_another_is_on_the_wire(bench: Bench) -> None:
    sender, other = bench.chip(), bench.chip()
    send(other, Frame(0x001, ALL_DATA))
    bench.bits(20)
    send(sender, C04)
    sender.write(m.CMR, m.CMR_AT)
    assert sender.read(m.SR) & 0x0C == 0x04
    assert sender.read(m.IR) == m.IR_TI
    bench.bits(2 * FRAME_BITS)
    assert other.read(m.RMC) == 0


@BOTH_WAYS
@pytest.mark.parametrize("wait", [1, 6, 40])
def test_an_abort_in_the_frame_lets_it_end(bench: Bench, bitwise: bool, wait: int) -> None:
    bench.bus.bitwise = bitwise
    sender, receiver = bench.chip(), bench.chip()
    send(sender, C04)
    bench.bits(wait)
    sender.write(m.CMR, m.CMR_AT)
    assert sender.read(m.SR) & 0x0C == 0
    bench.bits(FRAME_BITS)
    assert sender.read(m.SR) & 0x0C == 0x0C
    assert receiver.read(m.RMC) == 1


@BOTH_WAYS
@pytest.mark.parametrize("wait", [2, 30])
def test_an_abort_of_a_frame_that_loses_or_has_lost(bench: Bench, bitwise: bool, wait: int) -> None:
    bench.bus.bitwise = bitwise
    loser, winner = bench.chip(), bench.chip()
    send(loser, Frame(0x123))
    send(winner, Frame(0x121))
    bench.bits(wait)
    loser.write(m.CMR, m.CMR_AT)
    assert bool(loser.read(m.SR) & m.SR_TBS) == (wait == 30)
    bench.bits(2 * FRAME_BITS)
    assert loser.read(m.SR) & 0x0C == 0x04
    assert loser.read(m.IR) & (m.IR_TI | m.IR_ALI) == m.IR_TI | m.IR_ALI
    assert (loser.read(m.RMC), winner.read(m.RMC)) == (1, 0)


def test_basic_can_goes_bus_off_and_comes_back(bench: Bench) -> None:
    chip, _ = bench.basic_chip(), bench.basic_chip()
    bench.faults.flip(bit="dlc", times=32, seen_by="sender")
    put(chip, m.BASIC_TX_BUFFER, "24 60")
    chip.write(m.BASIC_CMR, m.CMR_TR)
    bench.bits(32 * 200)
    assert chip.read(m.BASIC_CR) & 1
    assert chip.read(m.BASIC_SR) == m.SR_BS | m.SR_ES | m.SR_TBS
    assert chip.read(m.BASIC_IR) == 0xE0 | m.IR_EI
    chip.write(m.BASIC_CR, 0x1E)
    bench.bits(128 * 11 - 1)
    assert chip.read(m.BASIC_SR) & m.SR_BS
    bench.bits(1)
    assert chip.read(m.BASIC_SR) == m.SR_TBS
    assert chip.read(m.BASIC_IR) == 0xE0 | m.IR_EI


# out of the copper and back


@pytest.mark.finding("wire-2 3")
@pytest.mark.parametrize("bitwise", [False, True])
def test_a_chip_unplugged_in_mid_frame_and_reset_sends_nothing_old(bench: Bench, bitwise: bool) -> None:
    bench.bus.bitwise = bitwise
    a, b, c = bench.chip(), bench.chip(), bench.chip()
    send(a, C04)
    bench.bits(30)
    bench.bus.detach(a)
    a.write(m.MOD, m.MOD_RM)
    bench.bits(100)
    bench.bus.attach(a)
    a.write(m.MOD, m.MOD_AFM)
    bench.bits(100)
    send(b, Frame(0x321, b"\x01"))
    bench.bits(300)
    assert (c.read(m.RMC), bench.bus.tally.frames) == (1, 1)


@pytest.mark.finding("wire-2 4")
def test_a_chip_attached_in_mid_frame_does_not_have_the_whole_of_it(bench: Bench) -> None:
    a, b, c = bench.chip(), bench.chip(), bench.chip()
    bench.bus.detach(c)
    send(a, C04)
    bench.bits(30)
    bench.bus.attach(c)
    bench.bits(35)
    assert c.read(m.RMC) == 0
    bench.bits(300)
    assert (a.read(m.SR) & m.SR_TCS, b.read(m.RMC)) == (m.SR_TCS, 1)


@pytest.mark.finding("wire-2 7")
def test_a_receiver_s_ecc_at_the_stuff_bit_behind_the_crc(bench: Bench) -> None:
    frame, at = some_frame_with_stuff_bit("CRC DEL", 1)
    a, b = bench.chip(), bench.chip()
    bench.faults.flip(bit=at, seen_by=b)
    send(a, frame)
    bench.bits(200)
    assert b.read(m.ECC) == 0b10_1_11000  # a stuff error, in reception, at the CRC delimiter
