"""Disturbances on purpose: at a bit, at a named place, for one node; noise, a short, a plug pulled."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import BadValue, ErrorKind, ErrorState, EventKind, Frame, Lab, LabBus, LabNode, NotIdle

pytestmark = pytest.mark.core

C04 = Frame(0x123, b"\x11\x22")  # 62 bits at 2 us, ACK slot 53
C08 = Frame(0x2AA, b"\xaa" * 8)
BIT_NS = 2_000


def three(bus: LabBus) -> list[LabNode]:
    nodes = [bus.node(name) for name in "abc"]
    for node in nodes:
        node.events()
    return nodes


def errors(node: LabNode) -> list[tuple[ErrorKind, int, bool]]:
    return [(event.error, event.bit, event.transmitting) for event in node.events(EventKind.ERROR)]


# where


@pytest.mark.conforms("G-14")
@pytest.mark.parametrize("bit", range(13, 53))
def test_a_bit_the_sender_reads_wrong_is_a_bit_error_at_that_bit(lab: Lab, can_bus: LabBus, bit: int) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.flip(frame_id=0x123, bit=bit, seen_by="sender")
    a.send(C04)
    lab.run_until_idle()
    ((kind, at, transmitting),) = errors(a)
    expected = ErrorKind.FORM if bit == 52 else ErrorKind.BIT  # the CRC delimiter has a fixed form
    assert (kind, at, transmitting) == (expected, bit, True)
    assert (b.receive_many(9), c.receive_many(9)) == ([C04], [C04])


@pytest.mark.parametrize(
    ("place", "bit", "kind"),
    [("ack", 53, ErrorKind.ACK), ("crc delimiter", 52, ErrorKind.FORM), ("ack delimiter", 54, ErrorKind.FORM),
     ("eof", 55, ErrorKind.FORM), ("dlc", 15, ErrorKind.BIT), ("data", 19, ErrorKind.BIT)],
)  # fmt: skip
@pytest.mark.conforms("G-14")
def test_named_places(lab: Lab, can_bus: LabBus, place: str, bit: int, kind: ErrorKind) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.flip(bit=place, seen_by="sender")
    a.send(C04)
    lab.run_until_idle()
    (error,) = errors(a)
    assert (error[0], error[2]) == (kind, True)
    assert abs(error[1] - bit) <= 2  # stuff bits before it
    assert (a.delivered, b.receive_many(9)) == (1, [C04])


@pytest.mark.parametrize("place", ["ack", "crc delimiter", "ack delimiter", "eof", "dlc", "data"])
@pytest.mark.parametrize("seen_by", ["all", "receivers", "sender"])
@pytest.mark.parametrize(
    "frame",
    [C04, Frame(0x123, remote=True), Frame(0x1), Frame(0x123, bytes(12), fd=True, bit_rate_switch=True)],
    ids=["data", "remote", "empty", "fd"],
)
def test_named_places_in_any_frame(lab: Lab, can_bus: LabBus, frame: Frame, place: str, seen_by: str) -> None:
    """A frame that has no such place passes undisturbed."""
    a, b, c = three(can_bus)
    can_bus.faults.flip(bit=place, seen_by=seen_by)
    a.send_many([frame, C08])
    lab.run_until_idle()
    assert (b.receive_many(9), c.receive_many(9)) == ([frame, C08], [frame, C08])
    assert (a.delivered, a.pending) == (2, 0)
    if place == "data" and not frame.data:
        assert can_bus.error_frames == 1  # the fault waited for the frame after it


@pytest.mark.conforms("G-14")
@pytest.mark.parametrize("kind", ["stuff", "form", "crc", "bit", "ack"])
def test_every_kind_of_error_in_a_remote_frame(lab: Lab, can_bus: LabBus, kind: str) -> None:
    a, b, c = three(can_bus)
    frame = Frame(0x555, remote=True, dlc=5)
    can_bus.faults.inject(kind)
    a.send(frame)
    lab.run_until_idle()
    assert (b.receive_many(9), c.receive_many(9)) == ([frame], [frame])
    assert can_bus.error_frames == 1


def test_beyond_the_end_of_a_frame_nothing_happens(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.flip(bit=62)
    a.send(C04)
    lab.run_until_idle()
    assert (b.receive_many(9), can_bus.error_frames) == ([C04], 0)
    a.send(C08)  # long enough
    lab.run_until_idle()
    assert (b.receive_many(9), can_bus.error_frames) == ([C08], 1)


# for whom


@pytest.mark.conforms("G-14")
def test_seen_by_one_node(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.flip(bit="crc delimiter", seen_by=b)
    a.send(C04)
    lab.run_until_idle()
    assert errors(b)[0] == (ErrorKind.FORM, 52, False)
    assert errors(c)[0][1] > 52
    assert errors(a)[0][1] > 52
    assert (b.rec, c.rec) == (8, 0)
    assert (b.receive_many(9), c.receive_many(9)) == ([C04], [C04])


def test_seen_by_the_receivers(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.flip(bit="crc delimiter", seen_by="receivers")
    a.send(C04)
    lab.run_until_idle()
    assert errors(b) == errors(c) == [(ErrorKind.FORM, 52, False)]
    assert errors(a) == [(ErrorKind.ACK, 53, True)] or errors(a) == []


def test_the_frame_of_another_node_is_left_alone(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.flip(frame_id=0x123, bit=20)
    can_bus.faults.flip(frame_id=0x2AA, extended=True, bit=20)
    b.send(C08)
    lab.run_until_idle()
    assert can_bus.error_frames == 0
    a.send(C04)
    lab.run_until_idle()
    assert can_bus.error_frames == 1
    assert (c.receive_many(9), b.rec >= 0) == ([C08, C04], True)


def test_extended_chooses_between_frames_of_one_number(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.flip(frame_id=0x2AA, extended=True, bit=20, seen_by="sender")
    a.send(C08)
    lab.run_until_idle()
    assert can_bus.error_frames == 0
    a.send(Frame(0x2AA, extended=True))
    lab.run_until_idle()
    assert can_bus.error_frames == 1
    assert b.waiting == 2


# how often


@pytest.mark.conforms("G-14")
@pytest.mark.parametrize("times", [1, 2, 5])
def test_times(lab: Lab, can_bus: LabBus, times: int) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.flip(frame_id=0x123, bit="dlc", times=times, seen_by="sender")
    a.send_many([C04] * 3)
    lab.run_until_idle()
    assert can_bus.error_frames == times
    assert b.receive_many(9) == [C04] * 3
    assert a.tec == 8 * times - 3


def test_for_ever_until_cleared(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.flip(frame_id=0x123, bit="dlc", times=None, seen_by="sender")
    a.send(C04)
    lab.run_for(0.1)
    assert a.state is ErrorState.BUS_OFF
    can_bus.faults.clear()
    a.restart()
    lab.run_until_idle()
    assert (b.receive_many(9), c.receive_many(9)) == ([C04], [C04])


def test_several_faults_wait_for_their_frames(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.flip(frame_id=0x2AA, bit="dlc", seen_by="sender")
    can_bus.faults.flip(frame_id=0x123, bit="dlc", times=2, seen_by="sender")
    a.send_many([C04, C08, C04])
    lab.run_until_idle()
    assert can_bus.error_frames == 3
    assert b.receive_many(9) == [C04, C08, C04]


# noise


def noisy(seed: int, rate: float, *, until_s: float = 0.05, armed: bool = False) -> tuple[object, ...]:
    with Lab(seed=seed) as lab:
        bus = lab.can_bus(data_bit_rate=2_000_000)
        nodes = three(bus)
        bus.faults.noise(rate)
        if armed:
            bus.faults.flip(bit=200, times=None)  # no frame has that bit
        for k in range(60):
            nodes[k % 2].send(Frame(0x100 + k, bytes([k] * 8)))
        lab.run_for(until_s)
        frames = [node.receive_array().tobytes() for node in nodes]
        return frames, [node.events() for node in nodes], [node.counters for node in nodes], bus.error_frames


@pytest.mark.conforms("G-17")
def test_the_same_seed_gives_the_same_noise() -> None:
    assert noisy(5, 2e-3) == noisy(5, 2e-3)
    assert noisy(5, 2e-3) != noisy(6, 2e-3)
    assert noisy(5, 2e-3)[3] != 0


@pytest.mark.finding("wire-2 2")
def test_beside_a_fault_that_never_strikes_noise_is_the_same() -> None:
    assert noisy(5, 2e-3, armed=True) == noisy(5, 2e-3)


def test_noise_destroys_no_frame_for_good(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.noise(3e-4)
    sent = [Frame(k, bytes([k] * 8)) for k in range(150)]
    a.send_many(sent)
    lab.run_for(0.2)
    assert can_bus.error_frames > 3
    for node in (b, c):
        came = node.receive_many(999)
        assert [frame for k, frame in enumerate(came) if k == 0 or came[k - 1] != frame] == sent


def test_noise_in_fd_frames(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.noise(1e-3)
    sent = [Frame(k, bytes([k] * 12), fd=True, bit_rate_switch=True) for k in range(200)]
    a.send_many(sent)
    for _ in range(60):
        lab.run_for(0.01)
        a.restart()  # in case it went bus-off
    came = b.receive_many(999)
    assert [frame for k, frame in enumerate(came) if k == 0 or came[k - 1] != frame] == sent


def test_noise_ends(lab: Lab, can_bus: LabBus) -> None:
    a, _b, _ = three(can_bus)
    can_bus.faults.noise(1e-2)
    a.send_many([C08] * 5)
    lab.run_for(0.02)
    can_bus.faults.noise(0)
    a.restart()
    lab.run_for(0.05)
    before = can_bus.error_frames
    assert before > 0
    a.send_many([C08] * 50)
    lab.run_until_idle()
    assert can_bus.error_frames == before
    assert a.pending == 0


def test_noise_has_about_the_rate_asked_for(lab: Lab, can_bus: LabBus) -> None:
    """1000 frames of 108 bits at 1e-4: about 11 of them are hit."""
    a, _, _ = three(can_bus)
    can_bus.faults.noise(1e-4)
    a.send_many([C08] * 1000)
    lab.run_until_idle()
    assert 2 <= can_bus.error_frames <= 30


# never in the past


@pytest.mark.parametrize("meanwhile", ["wire", "stop", "disconnect", "trace"])
def test_noise_does_not_reach_back_when_something_happens_in_the_middle_of_a_frame(
    meanwhile: str, tmp_path: Path
) -> None:
    """A frame that went well up to now has gone well up to now, whatever makes the bus look closer."""
    for seed in range(15):
        with Lab(seed=seed) as lab:
            bus = lab.can_bus()
            a, b, c = three(bus)
            bus.faults.noise(1e-2)
            a.send_many([C08] * 4)
            for _ in range(20):
                lab.run_for(0.000_05)
                errors(a), errors(b)
                look_closer(bus, c, meanwhile, tmp_path)
                stamps = [event.timestamp_ns for node in (a, b) for event in node.events(EventKind.ERROR)]
                assert all(stamp >= lab.now_ns for stamp in stamps), (seed, lab.now_ns, stamps)


def look_closer(bus: LabBus, node: LabNode, meanwhile: str, folder: Path) -> None:
    """Something for which a frame on the wire can no longer be worked out in one step."""
    if meanwhile == "wire":
        bus.wire.interrupt()
    elif meanwhile == "stop":
        node.stop()
        node.start()
    elif meanwhile == "disconnect":
        bus.faults.disconnect(node)
        bus.faults.reconnect(node)
    else:
        bus.trace_levels(folder / "wire.vcd")
        bus.end_trace()


def test_a_fault_asked_for_after_its_bit_has_passed_waits_for_the_next_frame(
    lab: Lab, can_bus: LabBus
) -> None:
    a, b, c = three(can_bus)
    a.send_many([C08, C08])
    lab.run_until(50 * BIT_NS)
    can_bus.faults.flip(bit=20, seen_by="sender")
    c.stop()
    lab.run_until(108 * BIT_NS)
    assert (a.delivered, a.tec, b.waiting) == (1, 0, 1)
    lab.run_until_idle()
    assert (a.delivered, a.tec, can_bus.error_frames) == (2, 7, 1)


# plugs and shorts


def test_a_plug_pulled_in_the_middle_of_a_frame(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    a.send(C08)
    lab.run_until(50 * BIT_NS)
    can_bus.faults.disconnect(a)
    lab.run_until(120 * BIT_NS)
    for node in (b, c):
        (error, _, transmitting) = errors(node)[0]
        assert (error, transmitting) == (ErrorKind.STUFF, False)  # the bus goes recessive for six bits
    assert (b.waiting, c.waiting, a.delivered) == (0, 0, 0)
    lab.run_for(0.01)
    assert (a.tec, a.state) == (128, ErrorState.ERROR_PASSIVE)  # alone on its stub
    can_bus.faults.reconnect(a)
    lab.run_until_idle()
    assert (b.receive_many(9), c.receive_many(9)) == ([C08], [C08])
    assert (a.delivered, a.pending) == (1, 0)


def test_the_rest_of_the_bus_goes_on(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.disconnect(a)
    b.send(C04)
    lab.run_until_idle()
    assert (c.receive_many(9), a.waiting) == ([C04], 0)
    can_bus.faults.reconnect(a)
    b.send(C08)
    lab.run_for(0.01)
    b.send(C04)
    lab.run_until_idle()
    assert c.receive_many(9) == [C08, C04]
    assert a.receive_many(9)[-1] == C04


def test_a_receiver_s_plug_pulled_in_the_middle_of_a_frame(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    a.send(C08)
    lab.run_until(50 * BIT_NS)
    can_bus.faults.disconnect(b)
    lab.run_until_idle()
    assert (a.delivered, a.tec, c.receive_many(9), b.waiting) == (1, 0, [C08], 0)
    can_bus.faults.reconnect(b)
    lab.run_for(0.001)
    a.send(C04)
    lab.run_until_idle()
    assert b.receive_many(9) == [C04]


def test_nobody_left_to_acknowledge(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.disconnect(b)
    a.send(C04)
    lab.run_for(0.01)
    assert (a.tec, a.delivered) == (128, 0)
    can_bus.faults.reconnect(b)
    lab.run_until_idle()
    assert b.receive_many(9) == [C04]


def test_a_sender_cut_off_is_as_restless_as_a_lone_one(lab: Lab, can_bus: LabBus) -> None:
    """NotIdle, as for every other frame that is repeated without success; here for a bounded time only."""
    a, _ = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.disconnect(a)
    a.send(C04)

    def give_up() -> None:
        raise AssertionError("run_until_idle would go on for ever")

    lab.at(5_000_000_000, give_up, background=True)
    with pytest.raises(NotIdle, match=r"a .ERROR_PASSIVE, TEC 128. repeats its frame"):
        lab.run_until_idle()


def test_cutting_off_twice_is_cutting_off_once(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.disconnect(b)
    can_bus.faults.disconnect(b)
    can_bus.faults.reconnect(b)
    can_bus.faults.reconnect(b)
    lab.run_for(0.001)
    a.send(C04)
    lab.run_until_idle()
    assert b.receive_many(9) == [C04]


def test_two_nodes_cut_off_are_not_together(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.disconnect(a)
    can_bus.faults.disconnect(b)
    a.send(C04)
    lab.run_for(0.01)
    assert (a.delivered, b.waiting) == (0, 0)


def test_a_stopped_node_stays_stopped_when_it_is_plugged_in_again(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    can_bus.faults.disconnect(b)
    b.stop()
    can_bus.faults.reconnect(b)
    a.send(C04)
    lab.run_until_idle()
    assert (b.state, b.waiting, c.waiting) == (ErrorState.STOPPED, 0, 1)


def test_a_short_and_recovery(lab: Lab, can_bus: LabBus) -> None:
    a, b, c = three(can_bus)
    a.send(C08)
    lab.run_until(50 * BIT_NS)
    can_bus.faults.short()
    lab.run_for(0.01)
    assert (a.state, a.delivered, b.waiting) == (ErrorState.BUS_OFF, 0, 0)
    assert b.state is c.state is ErrorState.ERROR_PASSIVE
    can_bus.faults.clear_short()
    lab.run_for(0.01)
    assert a.delivered == 0
    a.restart()
    lab.run_until_idle()
    assert (b.receive_many(9), c.receive_many(9)) == ([C08], [C08])


@pytest.mark.parametrize("after_ns", [0, 1, 2_000, 5_999, 6_000, 6_001])
def test_a_short_in_the_intermission(lab: Lab, can_bus: LabBus, after_ns: int) -> None:
    a, b, _ = three(can_bus)
    a.send(C04)
    lab.run_until(62 * BIT_NS + after_ns)
    assert a.delivered == 1
    can_bus.faults.short()
    lab.run_for(0.000_1)
    assert b.rec > 0
    can_bus.faults.clear_short()
    lab.run_until_idle()
    a.send(C08)
    lab.run_until_idle()
    assert b.receive_many(9) == [C04, C08]


def test_nothing_passes_a_short(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.short()
    a.send(C04)
    lab.run_for(0.000_1)
    assert (b.waiting, a.pending, a.delivered) == (0, 1, 0)
    can_bus.faults.clear()
    lab.run_until_idle()
    assert b.receive_many(9) == [C04]


def test_short_and_clear_as_often_as_you_like(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.faults.clear_short()
    can_bus.faults.short()
    can_bus.faults.short()
    lab.run_for(0.000_01)
    can_bus.faults.clear_short()
    can_bus.faults.clear_short()
    a.send(C04)
    lab.run_until_idle()
    assert b.receive_many(9) == [C04]


# what cannot be asked for


@pytest.mark.parametrize(
    ("options", "named"),
    [
        ({"bit": -1}, "bit -1"),
        ({"bit": "somewhere"}, "bit 'somewhere'"),
        ({"bit": 1.5}, r"bit 1\.5"),
        ({"bit": None}, "bit None"),
        ({"bit": 20, "times": 0}, "times 0"),
        ({"bit": 20, "times": -3}, "times -3"),
        ({"bit": 20, "seen_by": "nobody"}, "seen_by 'nobody'"),
        ({"bit": 20, "seen_by": 5}, "seen_by 5"),
        ({"bit": 20, "frame_id": 1 << 29}, "frame_id"),
        ({"bit": 20, "frame_id": -1}, "frame_id"),
        ({"bit": 20, "frame_id": 0x800, "extended": False}, "frame_id"),
    ],
)
def test_flip_says_which_value_is_wrong(can_bus: LabBus, options: dict[str, object], named: str) -> None:
    with pytest.raises(BadValue, match=named):
        can_bus.faults.flip(**options)  # type: ignore[arg-type]


def test_inject_says_which_value_is_wrong(can_bus: LabBus) -> None:
    with pytest.raises(BadValue, match="error 'gremlin': one of stuff, form, crc, bit, ack"):
        can_bus.faults.inject("gremlin")
    with pytest.raises(BadValue, match="times 0"):
        can_bus.faults.inject("crc", times=0)


@pytest.mark.parametrize("rate", [-0.1, 1.0, 2, float("nan"), float("inf")])
def test_noise_says_which_value_is_wrong(can_bus: LabBus, rate: float) -> None:
    with pytest.raises(BadValue, match=f"bit_error_rate {rate}"):
        can_bus.faults.noise(rate)


def test_a_fault_that_comes_in_mid_frame_waits_for_the_next_one(lab: Lab, can_bus: LabBus) -> None:
    a, b, _ = three(can_bus)
    can_bus.wire.bitwise = True
    can_bus.faults.flip(bit="dlc")
    a.send(C04)
    lab.run_for(0.000_080)  # it is being repeated
    can_bus.faults.flip(bit="dlc")
    lab.run_until_idle()
    assert (b.receive_many(9), can_bus.error_frames) == ([C04], 1)
    a.send(C04)
    lab.run_until_idle()
    assert can_bus.error_frames == 2
