"""The dongle's commands, rule by rule. Source: CANBUS manual chapter 2; rulings 26 to 29."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadValue, BusEvent, ErrorState, EventKind, Frame, LineError
from canwire.slcan import CANABLE, DIALECTS, Dongle, FileEeprom, MemoryEeprom, Settings, State
from tests.cases import each
from tests.slcan.bench import Bench

FULL = Frame(0x100, bytes(8))


def state_event(state: ErrorState) -> BusEvent:
    return BusEvent(EventKind.STATE, state=state)


@pytest.mark.conforms("CT-01", "CT-02")
def test_how_a_session_starts(bench: Bench) -> None:
    assert bench.ask(b"\r\r\r") == b"\r\r\r"
    assert bench.ask(b"V\rS4\rO\r") == b"V1013\r\r\r"
    assert bench.dongle.state is State.OPEN


@pytest.mark.conforms("CT-01")
@pytest.mark.parametrize(
    "line", [b"X", b"P", b"A", b"U1", b"W2", b"Q0", b"v", b"o", b"n", b"z1", b"SS", b"S44", b"V1"]
)
def test_other_commands_and_other_cases_are_errors(bench: Bench, line: bytes) -> None:
    assert bench.ask(line + b"\r") == b"\a"
    assert bench.dongle.counters.errors == 1


@pytest.mark.conforms("CT-03")
@pytest.mark.parametrize(
    ("digit", "bit_rate"),
    list(enumerate([10_000, 20_000, 50_000, 100_000, 125_000, 250_000, 500_000, 800_000, 1_000_000])),
)
def test_standard_rates(bench: Bench, digit: int, bit_rate: int) -> None:
    assert bench.ask(b"S%d\r" % digit) == b"\r"
    assert bench.dongle.bit_rate == bit_rate
    bench.ask(b"O\r")
    assert bench.can.opened[0].timing.bit_rate == bit_rate
    assert bench.ask(b"S%d\r" % digit) == b"\a"


@pytest.mark.conforms("CT-03")
@pytest.mark.parametrize("line", [b"S9", b"S", b"Sx", b"S-", b"S\x00"])
def test_no_such_rate(bench: Bench, line: bytes) -> None:
    assert bench.ask(line + b"\r") == b"\a"
    assert bench.dongle.state is State.IDLE


@pytest.mark.conforms("CT-04")
def test_rate_by_registers(bench: Bench) -> None:
    told: list[str] = []
    bench.dongle.on_change = told.append
    assert bench.ask(b"s031C\r") == b"\r"
    assert bench.dongle.bit_rate == 125_000
    assert told == ["set to 125000 bit/s"]
    for line in (b"s031", b"s031C0", b"s03xC", b"s"):
        assert bench.ask(line + b"\r") == b"\a"
    bench.ask(b"O\r")
    assert bench.can.opened[0].timing.to_btr() == (0x03, 0x1C)
    assert bench.ask(b"s0014\r") == b"\a"


@pytest.mark.conforms("CT-05")
def test_opened_only_when_set_up_and_closed_only_when_open(bench: Bench) -> None:
    assert bench.ask(b"O\rL\rC\r") == b"\a\a\a"
    assert bench.ask(b"S4\rC\rO\rO\rL\r") == b"\r\a\r\a\a"
    assert bench.ask(b"C\rC\rO\r") == b"\r\a\r"
    assert len(bench.can.opened) == 2


def test_a_controller_that_cannot_is_an_error(bench: Bench) -> None:
    bench.can.refuses = LineError("somebody else holds it")
    assert bench.ask(b"S4\rO\r") == b"\r\a"
    bench.can.refuses = None
    assert bench.ask(b"O\r") == b"\r"
    bench.can.refuses = LineError("gone")
    assert bench.ask(b"t1000\r") == b"\a"


@pytest.mark.conforms("CT-06", "CT-07", "CT-08", "CT-09")
def test_sending(opened: Bench) -> None:
    assert opened.ask(b"t10021133\rT0000010021133\rr1002\rR000001002\r") == b"z\rZ\rz\rZ\r"
    assert opened.can.sent == [
        Frame(0x100, b"\x11\x33"),
        Frame(0x100, b"\x11\x33", extended=True),
        Frame(0x100, remote=True, dlc=2),
        Frame(0x100, remote=True, dlc=2, extended=True),
    ]
    assert opened.ask(b"t0000010021133\rt8000\rT200000000\rt1009\rd1000\r") == b"\a\a\a\a\a"


@pytest.mark.conforms("CT-06")
def test_nothing_is_sent_while_closed_or_listening(bench: Bench) -> None:
    assert bench.ask(b"t1000\rS4\rt1000\rL\rt1000\rr1000\rF\rC\rt1000\r") == b"\a\r\a\r\a\aF00\r\r\a"
    assert bench.can.sent == []
    assert bench.can.opened[0].listen_only


def test_digits_are_read_in_either_case_and_answered_in_capitals(opened: Bench) -> None:
    assert opened.ask(b"t1ab1cD\rT0000aBcD1Ef\r") == b"z\rZ\r"
    assert opened.can.sent == [Frame(0x1AB, b"\xcd"), Frame(0xABCD, b"\xef", extended=True)]
    assert opened.receive(opened.can.sent[1]) == b"T0000ABCD1EF\r"


def test_identifiers_of_more_than_29_bits(opened: Bench) -> None:
    assert opened.ask(b"T200001000\r") == b"\a"
    canable = Bench(Settings(dialect=CANABLE))
    canable.ask(b"S4\rO\rT200001000\r")
    assert canable.can.sent == [Frame(0x100, extended=True)]


def test_a_remote_frame_without_a_length_asks_for_none(opened: Bench) -> None:
    assert opened.ask(b"r100\rR00000100\r") == b"z\rZ\r"
    assert opened.can.sent == [Frame(0x100, remote=True), Frame(0x100, remote=True, extended=True)]


@pytest.mark.conforms("CT-08")
def test_the_short_reply() -> None:
    bench = Bench(Settings(tx_reply="cr"))
    assert bench.ask(b"S4\rO\rt1000\rT000001000\r") == b"\r\r\r\r"


@pytest.mark.conforms("CT-18", "CT-10")
def test_the_ninth_frame_is_refused(opened: Bench) -> None:
    assert opened.ask(b"t1000\r" * 9) == b"z\r" * 8 + b"\a"
    assert opened.dongle.waiting == 8
    assert opened.ask(b"F\rF\r") == b"F02\rF00\r"
    opened.through()
    assert opened.ask(b"t1000\rt1000\r") == b"z\r\a"
    opened.through(8)
    assert opened.dongle.waiting == 0
    assert opened.dongle.counters.refused == 2
    assert len(opened.can.sent) == 9


@pytest.mark.finding("linux 2")
def test_before_a_frame_is_refused_the_hub_comes_up_to_now(bench: Bench) -> None:
    """A hub looks at its buses some thousand times a second, and whenever it is asked something."""

    went = 0

    def asked() -> int:
        nonlocal went
        bench.can.frames += [Frame(0, self_received=True)] * (len(bench.can.sent) - went)
        went = len(bench.can.sent)
        return bench.now_ns

    bench.dongle = Dongle(bench.can, asked)
    bench.ask(b"S4\rO\r")
    assert bench.ask(b"t1000\r" * 20) == b"z\r" * 20
    assert bench.dongle.counters.refused == 0


@pytest.mark.finding("linux 2")
def test_refused_frames_are_told_to_the_hub_and_said_once(opened: Bench) -> None:
    said: list[str] = []
    opened.dongle.on_change = said.append
    opened.ask(b"t1230\r" * 20)
    opened.ask(b"t1230\r" * 5)
    assert opened.can.refused == opened.dongle.counters.refused == 17
    assert [text for text in said if "refused" in text] == [
        "frames are refused (BELL): 8 wait already, and the host sends more"
    ]
    opened.ask(b"C\r")
    assert said[-1] == "closed; since power-up: sent 0, refused 17, received 0, lost 0, replies lost 0"


def test_what_got_through_meanwhile_makes_room(opened: Bench) -> None:
    opened.ask(b"t1000\r" * 8)
    opened.can.frames.append(Frame(0, self_received=True))
    assert opened.ask(b"t1000\r") == b"z\r"


@pytest.mark.conforms("CT-18", "CT-10")
def test_the_thirty_third_received_frame_is_lost() -> None:
    bench = Bench(Settings(output_size=1024 + 160))
    bench.ask(b"S4\rO\r")
    bench.can.frames += [Frame(k, bytes(8)) for k in range(1 + 32)]
    bench.dongle.pump()
    assert (bench.dongle.queued, bench.dongle.flags, bench.dongle.counters.lost) == (32, 0, 0)
    bench.can.frames.append(FULL)
    bench.dongle.pump()
    assert (bench.dongle.queued, bench.dongle.flags, bench.dongle.counters.lost) == (32, 0b1001, 1)
    text = b""
    while bench.dongle.output:
        text += bench.read()
    assert [int(line[1:4], 16) for line in text.split(b"\r")[:-1]] == list(range(33))
    assert bench.ask(b"F\r") == b"F09\r"


def test_what_the_hub_could_not_keep_is_lost_too(opened: Bench) -> None:
    opened.can.lost_frames = 7
    opened.dongle.pump()
    assert opened.dongle.counters.lost == 7
    assert opened.ask(b"F\r") == b"F09\r"


@pytest.mark.conforms("CT-17")
def test_frames_are_pushed(opened: Bench) -> None:
    assert opened.receive(Frame(0x100, b"\x11\x33")) == b"t10021133\r"
    remote = Frame(0x1FFFFFFF, remote=True, dlc=3, extended=True)
    assert opened.receive(Frame(0x7FF, extended=True), remote) == b"T000007FF0\rR1FFFFFFF3\r"


@pytest.mark.conforms("CT-10")
@pytest.mark.parametrize(
    ("states", "flags"),
    [
        ([ErrorState.ERROR_ACTIVE], 0x00),
        ([ErrorState.ERROR_WARNING], 0x04),
        ([ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE], 0x24),
        ([ErrorState.ERROR_PASSIVE], 0x24),
        ([ErrorState.ERROR_WARNING, ErrorState.ERROR_ACTIVE], 0x04),
        ([ErrorState.ERROR_PASSIVE, ErrorState.BUS_OFF], 0x24),
        ([ErrorState.BUS_OFF], 0x04),
        ([ErrorState.STOPPED, ErrorState.ERROR_ACTIVE], 0x00),
    ],
)
def test_flags_of_error_states(opened: Bench, states: list[ErrorState], flags: int) -> None:
    opened.happen(*map(state_event, states))
    assert opened.ask(b"F\rF\r") == b"F%02X\rF00\r" % flags


@pytest.mark.conforms("CT-10")
def test_a_state_that_lasts_raises_its_flag_once(opened: Bench) -> None:
    opened.happen(state_event(ErrorState.ERROR_WARNING), state_event(ErrorState.ERROR_PASSIVE))
    opened.ask(b"F\r")
    opened.happen(state_event(ErrorState.ERROR_PASSIVE))
    assert opened.ask(b"F\r") == b"F00\r"
    opened.happen(state_event(ErrorState.ERROR_WARNING))
    assert opened.ask(b"F\r") == b"F20\r"


@pytest.mark.conforms("CT-10")
@pytest.mark.parametrize(
    ("kind", "flags"),
    [
        (EventKind.ERROR, 0x80),
        (EventKind.ARBITRATION_LOST, 0x40),
        (EventKind.OVERRUN, 0x08),
        (EventKind.INFO, 0),
    ],
)
def test_flags_of_events(opened: Bench, kind: EventKind, flags: int) -> None:
    opened.happen(BusEvent(kind))
    assert opened.ask(b"F\rF\r") == b"F%02X\rF00\r" % flags


@pytest.mark.conforms("CT-10")
def test_flags_wait_for_the_next_opening(opened: Bench) -> None:
    opened.happen(BusEvent(EventKind.ERROR))
    assert opened.ask(b"C\rF\rO\rF\r") == b"\r\a\rF80\r"


@pytest.mark.conforms("CT-12")
def test_acceptance_registers(bench: Bench) -> None:
    assert bench.ask(b"M00006000\rm00001FF0\r") == b"\a\a"
    assert bench.ask(b"S4\rM00006000\rm00001FF0\rO\rM00000000\rmFFFFFFFF\r") == b"\r\r\r\r\a\a"
    assert bench.can.opened[0].code == bytes.fromhex("00006000")
    assert bench.can.opened[0].mask == bytes.fromhex("00001FF0")
    assert bench.ask(b"C\rM0000600\rM000060000\rM0000600x\rm\rO\r") == b"\r\a\a\a\a\r"
    assert bench.can.opened[1].code == bytes.fromhex("00006000")


@pytest.mark.conforms("CT-12")
def test_everything_is_accepted_after_power_up(opened: Bench) -> None:
    assert (opened.can.opened[0].code, opened.can.opened[0].mask) == (bytes(4), b"\xff" * 4)


@pytest.mark.conforms("CT-14")
def test_who_it_is() -> None:
    bench = Bench(Settings("B0z9", "V2042"))
    assert bench.ask(b"V\rN\rS4\rV\rN\rO\rV\rN\rC\rV\rN\r").count(b"V2042\rNB0z9\r") == 4


@each(
    ("name", "value"),
    [
        ("serial_number", "A12"),
        ("serial_number", "A12\r"),
        ("version", "1013"),
        ("version", "V10\r3"),
        ("tx_reply", "x"),
    ],
)
def test_settings_that_cannot_be(name: str, value: str) -> None:
    with pytest.raises(BadValue):
        Settings(**{name: value})  # type: ignore[arg-type]


@pytest.mark.conforms("CT-15")
def test_time_stamps(bench: Bench) -> None:
    power_up = bench.now_ns
    assert bench.ask(b"Z1\rS4\rZ0\rZ1\rZ2\rZ\rO\rZ0\r") == b"\r\r\r\r\a\a\r\a"
    for ms, text in (
        (0, b"0000"),
        (0x4D67, b"4D67"),
        (59_999, b"EA5F"),
        (60_000, b"0000"),
        (3 * 60_000 + 1, b"0001"),
    ):
        stamped = Frame(0x100, b"\x11\x33", timestamp_ns=power_up + ms * 1_000_000 + 999_999)
        assert bench.receive(stamped) == b"t10021133" + text + b"\r"
    assert bench.ask(b"C\rZ0\rO\r") == b"\r\r\r"
    assert bench.receive(Frame(0x100)) == b"t1000\r"


@pytest.mark.conforms("CT-15")
def test_stamping_is_remembered(tmp_path: Path) -> None:
    for eeprom in (MemoryEeprom(), FileEeprom(tmp_path / "new" / "A123")):
        assert not Bench(eeprom=eeprom).dongle.stamps
        Bench(eeprom=eeprom).ask(b"Z1\r")
        assert Bench(eeprom=eeprom).dongle.stamps
        Bench(eeprom=eeprom).ask(b"Z0\r")
        assert not Bench(eeprom=eeprom).dongle.stamps


def test_a_worn_out_eeprom_forgets(tmp_path: Path) -> None:
    eeprom = FileEeprom(tmp_path)  # a folder: neither read nor written
    bench = Bench(eeprom=eeprom)
    assert bench.ask(b"Z1\r") == b"\r"
    assert bench.dongle.stamps
    assert not Bench(eeprom=eeprom).dongle.stamps


def test_closing_gives_up_what_waits() -> None:
    bench = Bench(Settings(output_size=1024 + 160))
    bench.ask(b"S4\rO\r" + b"t1000\r" * 8)
    bench.can.frames += [FULL] * 20
    bench.dongle.pump()
    bench.dongle.feed(b"C\rO\r")
    assert (bench.dongle.waiting, bench.dongle.queued) == (0, 0)
    assert bench.can.closed == 1
    assert bench.read().endswith(b"\r\r")


def test_a_host_that_never_reads_blocks_nothing(opened: Bench) -> None:
    for k in range(20_000):
        opened.dongle.feed(b"t1000\r\rV\r")
        opened.can.frames += [Frame(0, self_received=True), Frame(k & 0x7FF, bytes(8))]
        opened.dongle.pump()
    counters = opened.dongle.counters
    assert len(opened.can.sent) == 20_000
    assert len(opened.dongle.output) <= 65_536
    assert counters.received + counters.lost + opened.dongle.queued == 20_000
    assert opened.read().count(b"V1013\r") + counters.replies_lost > 20_000
    opened.dongle.unplug_host()
    assert opened.ask(b"V\r") == b"V1013\r"


def test_canable() -> None:
    bench = Bench(Settings(dialect=CANABLE))
    assert bench.ask(b"\rV\rN\rO\rS4\rC\rS5\rY5\rM1\rO\rt1000\r") == b"canwire canable2\r"
    assert [(s.timing.bit_rate, s.listen_only) for s in bench.can.opened] == [
        (125_000, False),
        (250_000, True),
    ]
    assert [s.data_timing.bit_rate for s in bench.can.opened if s.data_timing] == [2_000_000, 5_000_000]
    assert bench.can.sent == []
    assert bench.ask(b"C\rm0\rA0\rO\rb1009" + b"00" * 12 + b"\rd1000\rt1000\rF\rL\rx\r") == b""
    assert bench.can.sent == [
        Frame(0x100, bytes(12), fd=True, bit_rate_switch=True),
        Frame(0x100, fd=True),
        Frame(0x100),
    ]
    assert bench.can.single_shots == 3
    bench.happen(BusEvent(EventKind.ABORTED))
    assert bench.dongle.waiting == 2
    assert bench.ask(b"E\r") == b"CANable Error Register: 0"
    assert bench.receive(Frame(0x100, bytes(12), fd=True)) == b"d1009" + b"00" * 12 + b"\r"
    assert bench.ask(b"C\rY9\rS7\rS9\r") == b""
    assert bench.dongle.bit_rate == 83_333


@pytest.mark.parametrize("name", DIALECTS)
@given(
    st.lists(
        st.one_of(st.binary(max_size=40), st.sampled_from([b"S4\r", b"O\r", b"L\r", b"C\r", b"t1000\r"]))
    )
)
def test_rubbish_harms_nothing(name: str, pieces: list[bytes]) -> None:
    bench = Bench(Settings(dialect=DIALECTS[name]))
    for piece in pieces:
        bench.dongle.feed(piece)
        bench.dongle.pump()
    if name == "canbus":
        bench.read()
        assert bench.ask(b"\rV\r")[-6:] == b"V1013\r"
