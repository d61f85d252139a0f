"""What one node sends is what every other node receives, bit for bit."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BusEvent, Frame, Lab, LabBus, LineError, dlc_to_length
from tests.cases import each
from tests.effort import examples
from tests.tables.frame_vectors import VECTORS, Vector

pytestmark = pytest.mark.core

FD_LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)


@st.composite
def classic_frames(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    if draw(st.booleans()):
        return Frame(id, extended=extended, remote=True, dlc=draw(st.integers(0, 15)))
    return Frame(id, draw(st.binary(max_size=8)), extended=extended)


@st.composite
def fd_frames(draw: st.DrawFn) -> Frame:
    extended = draw(st.booleans())
    length = draw(st.sampled_from(FD_LENGTHS))
    return Frame(
        draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF)),
        draw(st.binary(min_size=length, max_size=length)),
        extended=extended,
        fd=True,
        bit_rate_switch=draw(st.booleans()),
    )


def exact(frame: Frame) -> tuple[Any, ...]:
    """Everything about a frame but its time: `==` is under test here too."""
    flags = (frame.extended, frame.remote, frame.fd, frame.bit_rate_switch, frame.error_state_indicator)
    return frame.id, frame.data, frame.dlc, *flags


def through_a_bus(frames: list[Frame], *, bitwise: bool = False) -> list[list[Frame]]:
    """The frames as each of three receivers gets them, sent in order by one node."""
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=1_000_000, data_bit_rate=5_000_000)
        bus.wire.bitwise = bitwise
        sender = bus.node("sender")
        receivers = [bus.node("b"), bus.node("c"), bus.node("listener", listen_only=True)]
        sender.send_many(frames)
        lab.run_until_idle()
        assert (sender.delivered, sender.waiting, sender.tec, bus.error_frames) == (len(frames), 0, 0, 0)
        return [node.receive_many(len(frames) + 1) for node in receivers]


@pytest.mark.conforms("G-01")
@each("bitwise", [False, True], ids=["whole frames", "bit by bit"])
@each("id", [0x000, 0x001, 0x123, 0x555, 0x7EF, 0x7FF])
def test_11_bit_data_frames_of_every_length(id: int, bitwise: bool) -> None:
    frames = [Frame(id, bytes([length] * length)) for length in range(9)]
    for received in through_a_bus(frames, bitwise=bitwise):
        assert [exact(frame) for frame in received] == [exact(frame) for frame in frames]


@pytest.mark.conforms("G-01", "G-02", "G-03")
@pytest.mark.parametrize("bitwise", [False, True], ids=["whole frames", "bit by bit"])
@examples(50)
@given(frames=st.lists(classic_frames(), max_size=5))
def test_any_classic_frames(bitwise: bool, frames: list[Frame]) -> None:
    for received in through_a_bus(frames, bitwise=bitwise):
        assert [exact(frame) for frame in received] == [exact(frame) for frame in frames]


@pytest.mark.parametrize("bitwise", [False, True], ids=["whole frames", "bit by bit"])
@examples(50)
@given(frames=st.lists(fd_frames(), max_size=3))
def test_any_fd_frames(bitwise: bool, frames: list[Frame]) -> None:
    for received in through_a_bus(frames, bitwise=bitwise):
        assert [exact(frame) for frame in received] == [exact(frame) for frame in frames]


@each("bitwise", [False, True], ids=["whole frames", "bit by bit"])
@each("switch", [False, True])
def test_fd_frames_of_every_length(switch: bool, bitwise: bool) -> None:
    frames = [
        Frame(0x100 + length, bytes(range(length)), fd=True, bit_rate_switch=switch) for length in FD_LENGTHS
    ]
    for received in through_a_bus(frames, bitwise=bitwise):
        assert [exact(frame) for frame in received] == [exact(frame) for frame in frames]


@pytest.mark.conforms("G-01", "G-02", "G-03")
@each("vector", VECTORS, ids=lambda vector: vector.name)
def test_every_vector_arrives(vector: Vector) -> None:
    frame = Frame(vector.id, vector.data, **vector.keywords)
    for received in through_a_bus([frame]) + through_a_bus([frame], bitwise=True):
        assert [exact(frame) for frame in received] == [exact(frame)]


@pytest.mark.conforms("G-02")
@pytest.mark.parametrize("number", [0x000, 0x123, 0x7FF])
def test_the_same_number_in_11_and_29_bits_is_not_the_same_identifier(
    lab: Lab, can_bus: LabBus, number: int
) -> None:
    sender, both = can_bus.node("sender"), can_bus.node("both")
    short = can_bus.node("short", filters=[(number, 0x7FF)])
    long = can_bus.node("long", filters=[(number, 0x1FFFFFFF, True)])
    standard, extended = Frame(number, b"\x11"), Frame(number, b"\x29", extended=True)
    assert standard != extended
    sender.send_many([standard, extended])
    lab.run_until_idle()
    assert both.receive_many(9) == [standard, extended]
    assert short.receive_many(9) == [standard]
    assert long.receive_many(9) == [extended]


@pytest.mark.conforms("G-03")
@pytest.mark.parametrize("extended", [False, True])
@pytest.mark.parametrize("dlc", range(16))
def test_a_remote_frame_has_a_length_code_and_no_data(
    lab: Lab, can_bus: LabBus, extended: bool, dlc: int
) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(Frame(0x321, remote=True, dlc=dlc, extended=extended))
    frame = b.receive(timeout=0.01)
    assert frame is not None
    assert (frame.id, frame.remote, frame.dlc, frame.data) == (0x321, True, dlc, b"")
    assert (frame.extended, frame.fd) == (extended, False)


@pytest.mark.parametrize("dlc", range(9, 16))
def test_classic_length_codes_above_8_mean_8_bytes_and_arrive_as_sent(
    lab: Lab, can_bus: LabBus, dlc: int
) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    a.send(Frame(0x123, b"12345678", dlc=dlc))
    frame = b.receive(timeout=0.01)
    assert frame is not None
    assert (frame.dlc, frame.data) == (dlc, b"12345678")
    assert dlc_to_length(dlc, fd=False) == 8


def test_a_sender_gets_its_own_frames_only_when_it_asked(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b", self_reception=True)
    a.send(Frame(0x1))
    b.send(Frame(0x2))
    lab.run_until_idle()
    assert [(frame.id, frame.self_received) for frame in a.receive_many(9)] == [(2, False)]
    assert [(frame.id, frame.self_received) for frame in b.receive_many(9)] == [(1, False), (2, True)]


def test_a_node_that_keeps_nothing_still_acknowledges(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b", receives=False)
    a.send(Frame(0x1))
    lab.run_until_idle()
    assert (a.delivered, b.waiting, b.accepted, b.lost) == (1, 0, 0, 0)


def test_filters_do_not_change_who_acknowledges(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b", filters=[])
    a.send(Frame(0x1))
    lab.run_until_idle()
    assert (a.delivered, a.tec, b.waiting) == (1, 0, 0)


def test_a_classic_line_sends_no_fd_frame(lab: Lab) -> None:
    a = lab.can_bus(bit_rate=500_000).node("a")
    with pytest.raises(LineError, match="classic"):
        a.send(Frame(0x1, fd=True))
    assert (a.sent, a.pending) == (0, 0)


def test_a_passive_sender_says_so_in_fd_frames(lab: Lab, can_bus: LabBus) -> None:
    a, b = can_bus.node("a"), can_bus.node("b")
    can_bus.faults.flip(bit="dlc", times=17, seen_by="sender")
    a.send_many([Frame(0x1, bytes(12), fd=True)] * 10)
    lab.run_until_idle()
    indicators = [frame.error_state_indicator for frame in b.receive_many(20)]
    assert indicators == [True] * 9 + [False]  # TEC 136, and 1 less after each frame; 128 is still passive
    assert a.tec == 126


def test_no_events_on_a_healthy_bus(lab: Lab, can_bus: LabBus) -> None:
    nodes = [can_bus.node(name) for name in "abc"]
    for node in nodes:
        node.events()
    nodes[0].send_many([Frame(k, bytes(8)) for k in range(50)])
    lab.run_until_idle()
    nothing: list[BusEvent] = []
    assert [node.events() for node in nodes] == [nothing] * 3
    assert [node.receive_many(99) for node in nodes[1:]] == [[Frame(k, bytes(8)) for k in range(50)]] * 2
