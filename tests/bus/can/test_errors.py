"""Errors on the wire: who signals how, what the counters make of it, bus-off and the way back.

Source: ISO 11898-1 fault confinement; reference/can-protocol.md sections 5 and 7.
"""

from __future__ import annotations

import itertools
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from canwire import ErrorKind, ErrorState, EventKind, Frame, Lab, LabBus, LabNode, LineError, NotIdle

pytestmark = pytest.mark.core

BOTH_WAYS = pytest.mark.parametrize("bitwise", [False, True], ids=["whole frames", "bit by bit"])
BIT_NS = 2_000  # at 500 kbit/s
C04 = Frame(0x123, b"\x11\x22")  # 62 bits, ACK slot 53, no six equal bits anywhere before it
C04_BITS, ACK_SLOT = 62, 53
C08 = Frame(0x2AA, b"\xaa" * 8)  # 108 bits, no stuff bit
INTERMISSION, SUSPEND = 3, 8
ACTIVE, WARNING, PASSIVE, BUS_OFF = (
    ErrorState.ERROR_ACTIVE,
    ErrorState.ERROR_WARNING,
    ErrorState.ERROR_PASSIVE,
    ErrorState.BUS_OFF,
)


def three(bus: LabBus) -> list[LabNode]:
    """Three nodes whose events are recorded."""
    nodes = [bus.node(name) for name in "abc"]
    for node in nodes:
        node.events()
    return nodes


def states(node: LabNode) -> list[tuple[ErrorState, int, int]]:
    return [(event.state, event.tec, event.rec) for event in node.events(EventKind.STATE)]


def disturb(bus: LabBus, times: int, seen_by: LabNode | None = None) -> None:
    """So many frames get a bit error at the sender's DLC, or one receiver's form error behind the CRC."""
    if seen_by is None:
        bus.faults.flip(bit="dlc", times=times, seen_by="sender")
    else:
        bus.faults.flip(bit="crc delimiter", times=times, seen_by=seen_by)


def drive_bus_off(lab: Lab, bus: LabBus, node: LabNode) -> None:
    disturb(bus, 32)
    node.send(C04)
    lab.run_for(0.01)
    assert node.state is BUS_OFF


# nobody acknowledges


@pytest.mark.conforms("G-08", "G-09")
@BOTH_WAYS
@pytest.mark.parametrize("frame", [C04, Frame(0x1, fd=True, bit_rate_switch=True)], ids=["classic", "FD"])
def test_a_lone_sender_turns_passive_and_never_bus_off(
    lab: Lab, can_bus: LabBus, frame: Frame, bitwise: bool
) -> None:
    can_bus.wire.bitwise = bitwise
    a = can_bus.node("a")
    a.events()
    a.send(frame)
    lab.run_for(0.05)
    events = a.events()
    errors = [event for event in events if event.kind is EventKind.ERROR]
    assert {(event.error, event.transmitting) for event in errors} == {(ErrorKind.ACK, True)}
    counted = [event.tec for event in errors]
    assert counted[:16] == list(range(8, 129, 8))
    assert len(counted) > 100
    assert set(counted[16:]) == {128}
    changes = [(event.state, event.tec) for event in events if event.kind is EventKind.STATE]
    assert changes == [(WARNING, 96), (PASSIVE, 128)]
    assert (a.state, a.tec, a.rec) == (PASSIVE, 128, 0)
    assert (a.delivered, a.aborted, a.pending, can_bus.frames) == (0, 0, 1, 0)


@pytest.mark.conforms("G-08")
def test_a_lone_sender_never_comes_to_rest(lab: Lab, can_bus: LabBus) -> None:
    a = can_bus.node("engine")
    a.send(C04)
    with pytest.raises(NotIdle, match=r"engine .ERROR_PASSIVE, TEC 128. repeats its frame"):
        lab.run_until_idle()


@pytest.mark.conforms("G-08")
@BOTH_WAYS
def test_as_soon_as_somebody_comes_the_frame_gets_through(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    a = can_bus.node("a")
    a.send(C04)
    lab.run_for(0.01)
    b = can_bus.node("b")
    lab.run_until_idle()
    assert b.receive_many(9) == [C04]
    assert (a.delivered, a.pending, a.tec, a.state) == (1, 0, 127, WARNING)


# flags and what follows them, on the wire


def runs_of(path: Path, end_ns: int) -> list[tuple[int, int, int]]:
    """(level, first bit, bits) of each run of equal levels on the wire since time 0."""
    changes: list[tuple[int, int]] = []
    time_ns = 0
    for line in path.read_text("ascii").splitlines():
        if line.startswith("#"):
            time_ns = int(line[1:])
        elif line in ("0!", "1!"):
            changes.append((time_ns, int(line[0])))
    assert all(time_ns % BIT_NS == 0 for time_ns, _ in changes)
    edges = [*changes, (end_ns, -1)]
    found = [
        (level, start // BIT_NS, (end - start) // BIT_NS)
        for (start, level), (end, _) in itertools.pairwise(edges)
        if end > start
    ]
    assert all(one[0] != other[0] for one, other in itertools.pairwise(found))
    return found


def test_a_trace_of_one_frame_is_its_bits(lab: Lab, can_bus: LabBus, tmp_path: Path) -> None:
    """C04 as in can-protocol.md section 11."""
    stream = "00010010001100000110000100010010001000001100101101111011111111"
    three(can_bus)[0].send(C04)
    can_bus.trace_levels(tmp_path / "wire.vcd")
    lab.run_until(C04_BITS * BIT_NS)
    can_bus.end_trace()
    runs = runs_of(tmp_path / "wire.vcd", C04_BITS * BIT_NS)
    assert "".join(str(level) * bits for level, _, bits in runs) == stream


@pytest.mark.conforms("G-10")
def test_a_lone_sender_s_flags_active_then_passive(lab: Lab, can_bus: LabBus, tmp_path: Path) -> None:
    """Nobody else adds to them: exactly six dominant bits, then none at all and eight bits more to wait."""
    a = can_bus.node("a")
    a.events()
    a.send(C04)
    can_bus.trace_levels(tmp_path / "wire.vcd")
    lab.run_for(0.003)
    can_bus.end_trace()
    runs = runs_of(tmp_path / "wire.vcd", lab.now_ns)
    after_slot = ACK_SLOT + 1
    active_bits = after_slot + 6 + 8 + INTERMISSION
    passive_bits = active_bits + SUSPEND
    for attempt in range(16):
        flag = attempt * active_bits + after_slot
        rest = 1 if attempt < 15 else 0
        assert (0, flag, 6) in runs
        if rest:
            assert (1, flag + 6, 8 + INTERMISSION) in runs
    # the 16th flag was active still, but whoever sent it is passive now and waits
    assert (1, 15 * active_bits + after_slot + 6, 8 + INTERMISSION + SUSPEND) in runs
    passive_from = 15 * active_bits + passive_bits
    later = [run for run in runs if run[1] >= passive_from]
    assert all(bits < 6 for level, _, bits in later if level == 0)
    starts = [passive_from + k * passive_bits for k in range(5)]
    assert {start for _, start, _ in later} >= set(starts)
    assert [run[1] + run[2] for run in later if run[0] == 1 and run[2] > 20][:4] == starts[1:]


@pytest.mark.conforms("G-10")
@pytest.mark.parametrize("bit", range(15, ACK_SLOT + 1))
def test_length_of_an_active_error_frame(lab: Lab, can_bus: LabBus, bit: int) -> None:
    """6 to 12 dominant bits of all flags together, 8 recessive ones, 3 of intermission: 17 to 23."""
    a, b, _ = three(can_bus)
    can_bus.faults.flip(bit=bit, seen_by="sender")
    a.send(C04)
    lab.run_until_idle()
    frame = b.receive()
    assert frame is not None
    next_start = frame.timestamp_ns // BIT_NS - C04_BITS
    error_bits = next_start - (bit + 1)
    assert 14 + INTERMISSION <= error_bits <= 20 + INTERMISSION
    assert (a.delivered, a.tec, can_bus.error_frames) == (1, 7, 1)


@pytest.mark.conforms("G-10")
@pytest.mark.parametrize("bit", range(15, ACK_SLOT - 1, 3))
def test_dominant_bits_of_an_error_frame_on_the_wire(
    lab: Lab, can_bus: LabBus, tmp_path: Path, bit: int
) -> None:
    a, _, _ = three(can_bus)
    can_bus.faults.flip(bit=bit, seen_by="sender")
    a.send(C04)
    can_bus.trace_levels(tmp_path / "wire.vcd")
    lab.run_for(0.000_2)
    can_bus.end_trace()
    runs = runs_of(tmp_path / "wire.vcd", lab.now_ns)
    (flag,) = [run for run in runs if run[0] == 0 and run[2] >= 6]
    assert flag[1] <= bit + 1
    assert 6 <= flag[1] + flag[2] - (bit + 1) <= 12
    following = runs[runs.index(flag) + 1]
    assert (following[0], following[2]) == (1, 8 + INTERMISSION)


@pytest.mark.conforms("G-10")
@BOTH_WAYS
def test_a_passive_sender_waits_eight_bits_more_between_its_frames(
    lab: Lab, can_bus: LabBus, bitwise: bool
) -> None:
    can_bus.wire.bitwise = bitwise
    a, b, _ = three(can_bus)
    disturb(can_bus, 17)  # TEC 136: passive for nine frames, with the ninth it is 127
    a.send_many([C08] * 12)
    lab.run_until_idle()
    times = [frame.timestamp_ns for frame in b.receive_many(99)]
    gaps = [(later - earlier) // BIT_NS for earlier, later in itertools.pairwise(times)]
    assert gaps == [108 + INTERMISSION + SUSPEND] * 8 + [108 + INTERMISSION] * 3
    assert (a.tec, a.state) == (124, WARNING)


@pytest.mark.conforms("G-10")
@BOTH_WAYS
def test_others_use_the_time_that_a_passive_sender_waits(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    a, b, c = three(can_bus)
    disturb(can_bus, 17)
    a.send(Frame(0x001))
    lab.run_for(0.01)
    assert a.state is PASSIVE
    a.send_many([Frame(0x002), Frame(0x003)])
    b.send(Frame(0x7FF))
    lab.run_until_idle()
    # 002 wins; then its sender suspends transmission, and even 7FF goes before 003
    assert [frame.id for frame in c.receive_many(9)] == [0x001, 0x002, 0x7FF, 0x003]


@pytest.mark.conforms("G-10")
def test_a_passive_receiver_s_flag_disturbs_nobody(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    disturb(can_bus, 17)
    b.send(Frame(0x7FE))
    lab.run_until_idle()
    assert b.state is PASSIVE
    a.receive_many(9), c.receive_many(9)
    for node in (a, b, c):
        node.events()
    can_bus.faults.flip(frame_id=0x123, bit="data", seen_by=b)
    a.send(C04)
    lab.run_until_idle()
    assert c.receive_many(9) == [C04]
    assert b.receive_many(9) == []
    assert (a.delivered, a.events(), c.events()) == (1, [], [])
    assert [event.transmitting for event in b.events(EventKind.ERROR)] == [False]
    a.send(C08)
    lab.run_until_idle()
    assert b.receive_many(9) == [C08]


@pytest.mark.conforms("G-10")
def test_an_active_receiver_s_flag_destroys_the_frame_for_all(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.flip(frame_id=0x123, bit="data", seen_by=b)
    a.send(C04)
    lab.run_until_idle()
    for node in (a, b, c):
        assert len(node.events(EventKind.ERROR)) >= 1
    assert (b.receive_many(9), c.receive_many(9)) == ([C04], [C04])
    assert (a.delivered, can_bus.error_frames) == (1, 1)


# counters


@pytest.mark.conforms("G-09")
def test_sender_s_counter_up_by_8_and_down_by_1_with_one_event_a_crossing(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    disturb(can_bus, 17)
    a.send_many(Frame(k) for k in range(60))
    lab.run_until_idle()
    events = a.events()
    errors = [event.tec for event in events if event.kind is EventKind.ERROR]
    assert errors == list(range(8, 137, 8))
    changes = [(event.state, event.tec) for event in events if event.kind is EventKind.STATE]
    assert changes == [(WARNING, 96), (PASSIVE, 128), (WARNING, 127), (ACTIVE, 95)]
    assert a.tec == 136 - 60
    assert b.waiting == 60


@pytest.mark.conforms("G-09")
def test_receiver_s_counter(lab: Lab, can_bus: LabBus) -> None:
    """The one that sees the error counts 1 and, being first with its flag, 8 more; the others count 1."""
    a, b, c = three(can_bus)
    disturb(can_bus, 1, seen_by=b)
    a.send(C04)
    lab.run_for(0.000_14)  # the frame and the error frame
    assert (a.tec, b.rec, c.rec) == (8, 9, 1)
    lab.run_until_idle()
    assert (a.tec, b.rec, c.rec) == (7, 8, 0)
    assert (a.rec, b.tec, c.tec) == (0, 0, 0)
    a.send_many([C04] * 20)
    lab.run_until_idle()
    assert (a.tec, b.rec, c.rec) == (0, 0, 0)


@pytest.mark.conforms("G-09")
def test_receiver_turns_passive_and_comes_back(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    disturb(can_bus, 16, seen_by=b)
    a.send(C04)
    lab.run_until_idle()
    # 15 times 9, and when it is passive its 16th error does not stop the frame
    assert (b.rec, b.state, b.waiting, c.waiting) == (136, PASSIVE, 0, 1)
    a.send(C04)
    lab.run_until_idle()
    assert (119 <= b.rec <= 127, b.state, b.waiting) == (True, WARNING, 1)
    a.send_many([C04] * 40)
    lab.run_until_idle()
    changes = states(b)
    assert [state for state, _, _ in changes] == [WARNING, PASSIVE, WARNING, ACTIVE]
    assert [rec for _, _, rec in changes][:2] == [99, 135]
    assert changes[3][2] == 95
    assert b.tec == 0


@pytest.mark.smoke
@pytest.mark.conforms("G-09", "G-11")
def test_32_disturbed_attempts_lead_to_bus_off(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    disturb(can_bus, 40)
    a.send(C04)
    lab.run_for(0.02)
    events = a.events()
    assert [event.tec for event in events if event.kind is EventKind.ERROR] == list(range(8, 257, 8))
    changes = [(event.state, event.tec) for event in events if event.kind is EventKind.STATE]
    assert changes == [(WARNING, 96), (PASSIVE, 128), (BUS_OFF, 256)]
    assert (a.tec, a.state, a.pending) == (256, BUS_OFF, 1)
    assert b.state is ACTIVE


@pytest.mark.conforms("G-09")
def test_counters_can_be_read_in_the_middle_of_a_frame(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.flip(bit=20, seen_by="sender")
    a.send(C04)
    seen = []
    for bits in (10, 20, 21, 40, 60, 120):
        lab.run_until(bits * BIT_NS)
        seen.append((a.tec, a.counters.tec, b.counters.rec))
    assert [tec for tec, _, _ in seen] == [0, 0, 8, 8, 8, 7]
    assert all(one == other for one, other, _ in seen)
    assert a.counters.errors == 1


@pytest.mark.conforms("G-09")
def test_a_bus_held_dominant_counts_8_for_every_8_bits(lab: Lab, can_bus: LabBus) -> None:
    """Rules 1, 2 and 6: stuff error with the 6th bit; flag of 6; its next bit dominant; then each 8th."""
    nodes = three(can_bus)
    start_ns = 1_000_000
    lab.run_until(start_ns)
    can_bus.faults.short()
    for bits, rec in [(5, 0), (6, 1), (12, 1), (13, 9), (19, 9), (20, 17), (27, 17), (28, 25), (36, 33)]:
        lab.run_until(start_ns + bits * BIT_NS)
        assert [node.rec for node in nodes] == [rec] * 3, bits
    can_bus.faults.clear_short()
    lab.run_until_idle()
    assert [(node.rec, node.tec, node.state) for node in nodes] == [(33, 0, ACTIVE)] * 3


@pytest.mark.conforms("G-09")
def test_starting_again_clears_the_counters(lab: Lab, can_bus: LabBus) -> None:
    a, _, _ = three(can_bus)
    disturb(can_bus, 13)
    a.send(C04)
    lab.run_until_idle()
    assert a.state is WARNING
    a.stop()
    assert (a.state, a.tec) == (ErrorState.STOPPED, 103)
    a.start()
    assert (a.state, a.tec, a.rec) == (ACTIVE, 0, 0)


# bus-off


@pytest.mark.conforms("G-11")
def test_a_node_that_is_bus_off_sends_receives_and_acknowledges_nothing(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    drive_bus_off(lab, can_bus, a)
    frames, lost, received = can_bus.frames, b.waiting, a.waiting
    a.send_many([C08] * 3)
    b.send(Frame(0x7FF))
    lab.run_for(0.01)
    assert (b.delivered, b.waiting, a.waiting) == (0, lost, received)
    assert b.state is PASSIVE  # nobody acknowledges
    assert (a.delivered, a.pending, can_bus.frames) == (0, 4, frames)


@pytest.mark.conforms("G-11")
def test_bus_off_lasts_until_restart(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    drive_bus_off(lab, can_bus, a)
    lab.run_for(10.0)
    assert (a.state, a.tec) == (BUS_OFF, 256)
    a.restart()
    assert a.state is BUS_OFF
    lab.run_until_idle()
    assert (a.state, a.tec, a.rec) == (ACTIVE, 0, 0)
    assert (a.delivered, b.receive_many(9)) == (1, [C04])


@pytest.mark.conforms("G-11")
@BOTH_WAYS
def test_the_way_back_takes_128_times_11_bits_of_an_idle_bus(
    lab: Lab, can_bus: LabBus, bitwise: bool
) -> None:
    a, b, _ = three(can_bus)
    drive_bus_off(lab, can_bus, a)
    a.cancel()
    can_bus.wire.bitwise = bitwise
    lab.run_until(50_000_000)
    a.events()
    a.restart()
    due_ns = 50_000_000 + 128 * 11 * BIT_NS
    lab.run_until(due_ns - BIT_NS)
    assert (a.state, a.events()) == (BUS_OFF, [])
    lab.run_until(due_ns + BIT_NS)
    (event,) = a.events()
    assert (event.kind, event.state, event.tec, event.rec) == (EventKind.STATE, ACTIVE, 0, 0)
    assert event.timestamp_ns == due_ns
    b.send(C04)
    lab.run_until_idle()
    assert a.receive_many(9) == [C04]


@pytest.mark.conforms("G-11")
@BOTH_WAYS
def test_back_to_back_traffic_gives_one_sequence_a_frame(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    """ACK delimiter, EOF and intermission: 1 + 7 + 3 recessive bits."""
    a, b, _ = three(can_bus)
    drive_bus_off(lab, can_bus, a)
    a.cancel()
    a.events()
    can_bus.wire.bitwise = bitwise
    b.send_many([C08] * 200)
    start_ns = lab.now_ns
    lab.run_for(0.000_05)
    a.restart()
    lab.run_until_idle()
    (event,) = a.events()
    assert event.timestamp_ns - start_ns == 128 * (108 + INTERMISSION) * BIT_NS
    assert a.waiting == 200 - 128


@pytest.mark.conforms("G-11")
@BOTH_WAYS
@pytest.mark.parametrize(("gap_bits", "frames"), [(10, 128), (11, 64), (21, 64), (22, 43)])
def test_only_whole_sequences_between_frames_count(
    lab: Lab, can_bus: LabBus, gap_bits: int, frames: int, bitwise: bool
) -> None:
    """A gap of so many bits after the intermission makes runs of 11 + gap recessive bits."""
    a, b, _ = three(can_bus)
    drive_bus_off(lab, can_bus, a)
    a.cancel()
    can_bus.wire.bitwise = bitwise
    a.events()
    period_ns = (108 + INTERMISSION + gap_bits) * BIT_NS
    start_ns = lab.now_ns + 100_000
    for k in range(140):
        lab.at(start_ns + k * period_ns, lambda: b.send(C08))
    lab.run_until(start_ns + 100_000)
    a.restart()
    lab.run_until_idle()
    (event,) = a.events()
    assert event.state is ACTIVE
    assert frames - 1 <= (event.timestamp_ns - start_ns) / period_ns <= frames


@pytest.mark.conforms("G-11")
def test_restart_of_a_node_that_is_not_bus_off_changes_nothing(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    disturb(can_bus, 3)
    a.send(C04)
    lab.run_until_idle()
    a.restart()
    assert (a.tec, a.state) == (23, ACTIVE)
    b.send(C08)
    lab.run_until_idle()
    assert a.receive_many(9) == [C08]


# errors on purpose

FRAMES = {
    "standard": C04,
    "zeros": Frame(0x000, bytes(8)),
    "ones": Frame(0x7FF, b"\xff" * 8),
    "empty": Frame(0x2AA),
    "extended": Frame(0x12345678, b"\x11\x22\x33", extended=True),
    "remote": Frame(0x123, remote=True, dlc=4),
    "fd": Frame(0x123, bytes(range(12)), fd=True),
    "fd fast": Frame(0x123, bytes(range(64)), fd=True, bit_rate_switch=True),
    "fd extended": Frame(0x18FF0102, b"\x55" * 20, extended=True, fd=True, bit_rate_switch=True),
}
every_frame = pytest.mark.parametrize("frame", FRAMES.values(), ids=FRAMES.keys())


@pytest.mark.conforms("G-14")
@every_frame
@pytest.mark.parametrize(
    ("kind", "seen"),
    [
        ("stuff", ErrorKind.STUFF),
        ("form", ErrorKind.FORM),
        ("crc", ErrorKind.CRC),
        ("bit", ErrorKind.BIT),
        ("ack", ErrorKind.ACK),
    ],
)
def test_an_injected_error_is_seen_by_all_and_the_frame_is_repeated(
    lab: Lab, can_bus: LabBus, kind: str, seen: ErrorKind, frame: Frame
) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.inject(kind, frame_id=frame.id, extended=frame.extended)
    a.send(frame)
    lab.run_until_idle()
    first = {node.name: node.events(EventKind.ERROR)[0] for node in (a, b, c)}
    # a stuff error within the identifier may take its arbitration from the sender, or be no fault of it
    if kind != "stuff":
        assert [event.transmitting for event in first.values()] == [True, False, False]
        assert a.tec == 7
    if kind in ("bit", "ack"):
        fast_bit = kind == "bit" and frame.bit_rate_switch
        assert first["a"].error in ({ErrorKind.BIT, ErrorKind.FAST_DATA_BIT} if fast_bit else {seen})
        assert first["a"].timestamp_ns <= min(first["b"].timestamp_ns, first["c"].timestamp_ns)
    else:
        assert (first["b"].error, first["c"].error) == (seen, seen)
    assert can_bus.error_frames == 1
    assert (b.receive_many(9), c.receive_many(9), a.receive_many(9)) == ([frame], [frame], [])
    assert (a.delivered, can_bus.frames) == (1, 1)


@pytest.mark.conforms("G-14")
@pytest.mark.parametrize("bit", range(C04_BITS))
@pytest.mark.parametrize("seen_by", ["all", "receivers", "sender"])
def test_an_error_at_any_bit_ends_in_every_frame_delivered(
    lab: Lab, can_bus: LabBus, bit: int, seen_by: str
) -> None:
    """Only at the last EOF bit may a duplicate be made: receivers take the frame, the sender repeats it.

    What the sender alone reads in the bit before it makes a flag that begins there.
    """
    a, b, c = three(can_bus)
    can_bus.faults.flip(frame_id=0x123, bit=bit, seen_by=seen_by)
    a.send_many([C04, C08])
    lab.run_until_idle()
    last = C04_BITS - 1
    twice = (bit, seen_by) in [(last, "all"), (last, "sender"), (last - 1, "sender")]
    expected = [C04, C04, C08] if twice else [C04, C08]
    assert (b.receive_many(9), c.receive_many(9)) == (expected, expected)
    assert (a.delivered, a.pending) == (2, 0)


@pytest.mark.conforms("G-14")
@settings(deadline=None)
@given(bit=st.integers(0, 240), seen_by=st.sampled_from(["all", "receivers", "sender", "one"]))
def test_an_error_at_any_bit_of_an_fd_frame(bit: int, seen_by: str) -> None:
    frame = Frame(0x321, bytes(range(20)), fd=True, bit_rate_switch=True)  # D08: 239 bits
    with Lab() as lab:
        bus = lab.can_bus(data_bit_rate=2_000_000)
        a, b, c = three(bus)
        bus.faults.flip(frame_id=0x321, bit=bit, seen_by=b if seen_by == "one" else seen_by)
        a.send_many([frame, C08])
        lab.run_until_idle()
        # with its res bit recessive, FDF announces a protocol that b does not know: it looks away
        blind = [b] if (bit, seen_by) == (15, "one") else []
        for node in (b, c):
            came = node.receive_many(9)
            if node in blind:
                assert came == [C08]
                continue
            assert came in ([frame, C08], [frame, frame, C08])
            assert len(came) == 2 or bit in (237, 238)
        assert (a.delivered, a.pending) == (2, 0)


@pytest.mark.conforms("G-14")
def test_an_fd_acknowledge_of_two_bits_is_tolerated(lab: Lab, can_bus: LabBus) -> None:
    """ISO 11898-1: a sender accepts a second dominant bit after the ACK slot of an FD frame."""
    a, b, c = three(can_bus)
    frame = Frame(0x123, bytes(range(12)), fd=True, bit_rate_switch=True)
    can_bus.faults.flip(frame_id=0x123, bit="ack delimiter")
    a.send_many([frame, C08])
    lab.run_until_idle()
    came = b.receive_many(9)
    assert (came, c.receive_many(9)) == ([frame, C08], [frame, C08])
    assert (a.delivered, can_bus.error_frames) == (2, 0)
    # no overload frame between the two either, which a dominant bit too many would bring about
    assert came[1].timestamp_ns - came[0].timestamp_ns == (INTERMISSION + 108) * BIT_NS


# listening only


@pytest.mark.conforms("G-15")
@BOTH_WAYS
def test_a_listener_receives_everything_and_changes_nothing(lab: Lab, can_bus: LabBus, bitwise: bool) -> None:
    can_bus.wire.bitwise = bitwise
    a, b = can_bus.node("a"), can_bus.node("b")
    listener = can_bus.node("listener", listen_only=True)
    a.send_many([C04, C08])
    b.send(Frame(0x12345678, b"\x01", extended=True))
    a.send(Frame(0x2, bytes(64), fd=True, bit_rate_switch=True))
    lab.run_until_idle()
    assert listener.waiting == 4
    assert (listener.tec, listener.rec, listener.state, can_bus.error_frames) == (0, 0, ACTIVE, 0)


@pytest.mark.conforms("G-15")
def test_with_only_listeners_the_sender_gets_acknowledge_errors(lab: Lab, can_bus: LabBus) -> None:
    a = can_bus.node("a")
    listeners = [can_bus.node(f"listener {k}", listen_only=True) for k in range(2)]
    a.events()
    a.send(C04)
    lab.run_for(0.0015)
    assert {event.error for event in a.events(EventKind.ERROR)} == {ErrorKind.ACK}
    assert (a.delivered, a.tec >= 80, a.pending) == (0, True, 1)
    lab.run_for(0.01)
    assert (a.state, a.tec, a.delivered) == (PASSIVE, 128, 0)
    assert [(node.tec, node.state) for node in listeners] == [(0, ACTIVE)] * 2


@pytest.mark.conforms("G-15")
def test_a_listener_sends_no_error_flag(lab: Lab, can_bus: LabBus, tmp_path: Path) -> None:
    """What only the listener reads wrong, only the listener misses; the wire shows the frame untouched."""
    stream = "00010010001100000110000100010010001000001100101101111011111111"
    a, b = can_bus.node("a"), can_bus.node("b")
    listener = can_bus.node("listener", listen_only=True)
    can_bus.faults.flip(frame_id=0x123, bit="data", seen_by=listener)
    can_bus.trace_levels(tmp_path / "wire.vcd")
    a.send(C04)
    lab.run_until(C04_BITS * BIT_NS)
    can_bus.end_trace()
    runs = runs_of(tmp_path / "wire.vcd", C04_BITS * BIT_NS)
    assert "".join(str(level) * bits for level, _, bits in runs) == stream
    lab.run_until_idle()
    assert (b.waiting, listener.waiting, can_bus.frames) == (1, 0, 1)
    assert (listener.tec, listener.rec) == (0, 0)
    a.send(C08)
    lab.run_until_idle()
    assert listener.receive_many(9) == [C08]


@pytest.mark.conforms("G-15")
def test_a_listener_cannot_send(lab: Lab, can_bus: LabBus) -> None:
    can_bus.node("a")
    listener = can_bus.node("listener", listen_only=True)
    with pytest.raises(LineError, match="listen"):
        listener.send(C04)
    assert (listener.sent, listener.pending) == (0, 0)
