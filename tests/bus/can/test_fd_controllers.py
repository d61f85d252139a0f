"""What FD controllers can be told: protocol exception, restricted operation, edge filter, bus monitoring, ESI."""

from __future__ import annotations

from typing import Any

import pytest

from canwire import (
    BadValue,
    ControllerOptions,
    ErrorKind,
    ErrorState,
    EventKind,
    Frame,
    Lab,
    LabBus,
    LabNode,
    LineError,
    Unsupported,
)
from tests.cases import each

pytestmark = pytest.mark.core

FD = Frame(0x123, bytes(range(32)), fd=True, bit_rate_switch=True)
CLASSIC = Frame(0x124, b"\x55\xaa")
NEWER = ControllerOptions(protocol_exception=False)
TOLERANT = ControllerOptions(fd_tolerant=True)
RESTRICTED = ControllerOptions(restricted=True)


def fd_bus(lab: Lab) -> LabBus:
    return lab.can_bus(bit_rate=500_000, data_bit_rate=2_000_000)


def frames(node: LabNode) -> list[tuple[int, bytes]]:
    return [(frame.id, frame.data) for frame in node.receive_many(100)]


def kinds(node: LabNode) -> list[ErrorKind]:
    return [event.error for event in node.events(EventKind.ERROR)]


# FD-tolerant classic controllers


def test_a_tolerant_classic_controller_leaves_fd_frames_alone() -> None:
    for extended in (False, True):
        with Lab() as lab:
            bus = fd_bus(lab)
            sender, _, classic = bus.node("a"), bus.node("b"), bus.node("c", fd=False, options=TOLERANT)
            classic.events()
            sender.send(Frame(0x123, FD.data, extended=extended, fd=True, bit_rate_switch=True))
            sender.send(CLASSIC)
            lab.run_until_idle()
            assert (bus.frames, bus.error_frames, kinds(classic)) == (2, 0, [])
            assert frames(classic) == [(CLASSIC.id, CLASSIC.data)]
            assert classic.counters.errors == 0


@pytest.mark.parametrize("arguments", [{"fd": False}, {"controller": "sja1000"}])
def test_other_classic_controllers_destroy_them(arguments: dict[str, Any]) -> None:
    with Lab() as lab:
        bus = fd_bus(lab)
        sender, _, _ = bus.node("a"), bus.node("b"), bus.node("c", **arguments)
        lab.run_for(0.001)
        sender.send(FD, single_shot=True)
        lab.run_for(0.01)
        assert (bus.frames, bus.error_frames) == (0, 1)


def test_a_tolerant_controller_sends_again_behind_the_frame() -> None:
    with Lab() as lab:
        bus = fd_bus(lab)
        sender, receiver = bus.node("a"), bus.node("b")
        classic = bus.node("c", fd=False, options=TOLERANT)
        sender.send(FD)
        lab.run_for(100e-6)
        classic.send(CLASSIC)
        lab.run_until_idle()
        assert [frame.id for frame in receiver.receive_many(9)] == [FD.id, CLASSIC.id]
        assert (bus.error_frames, classic.tec) == (0, 0)


# protocol exception


@pytest.mark.parametrize("options", [ControllerOptions(), NEWER])
def test_a_recessive_res_bit(options: ControllerOptions) -> None:
    """A frame of a format to come, as the receiver sees it: left alone, or a form error and an error frame."""
    with Lab() as lab:
        bus = fd_bus(lab)
        sender, receiver = bus.node("a"), bus.node("b", options=options)
        receiver.events()
        bus.node("c")
        bus.faults.flip(bit=15, seen_by=receiver)
        sender.send(FD)
        lab.run_until_idle()
        if options is NEWER:
            assert (kinds(receiver), bus.error_frames, len(frames(receiver))) == ([ErrorKind.FORM], 1, 1)
        else:
            assert (kinds(receiver), bus.error_frames, len(frames(receiver))) == ([], 0, 0)


# restricted operation


def test_restricted_operation_receives_and_acknowledges() -> None:
    with Lab() as lab:
        bus = fd_bus(lab)
        sender, restricted = bus.node("a"), bus.node("b", options=RESTRICTED)
        for frame in (FD, CLASSIC):
            sender.send(frame)
        lab.run_until_idle()
        assert (bus.frames, bus.error_frames, len(frames(restricted))) == (2, 0, 2)


def test_restricted_operation_sends_nothing() -> None:
    with Lab() as lab:
        restricted = fd_bus(lab).node("b", options=RESTRICTED)
        with pytest.raises(LineError, match="restricted operation, sends nothing"):
            restricted.send(CLASSIC)


@each("bit", [30, 60, "crc delimiter", "ack"])
def test_restricted_operation_sends_no_flag_and_counts_nothing(bit: int | str) -> None:
    with Lab() as lab:
        bus = fd_bus(lab)
        sender, other, restricted = bus.node("a"), bus.node("b"), bus.node("c", options=RESTRICTED)
        restricted.events()
        bus.faults.flip(bit=bit, seen_by=restricted)
        sender.send(FD)
        sender.send(CLASSIC)
        lab.run_until_idle()
        assert (bus.frames, bus.error_frames, len(frames(other))) == (2, 0, 2)
        assert len(kinds(restricted)) == 1
        assert (restricted.tec, restricted.rec, restricted.state) == (0, 0, ErrorState.ERROR_ACTIVE)
        assert frames(restricted) == [(CLASSIC.id, CLASSIC.data)]


def test_restricted_operation_sends_no_overload_flag_and_keeps_the_frame() -> None:
    """The last bit of EOF dominant for it: the frame is valid, and it looks for an idle bus."""
    with Lab() as lab:
        bus = fd_bus(lab)
        sender, restricted = bus.node("a"), bus.node("b", options=RESTRICTED)
        bus.node("c")
        bus.faults.hold("dominant", at=bus.faults.place("eof", 7, frame_id=FD.id), seen_by=restricted)
        sender.send(FD)
        lab.run_until_idle()
        assert (bus.frames, bus.error_frames, len(frames(restricted))) == (1, 0, 1)
        sender.send(CLASSIC)
        lab.run_until_idle()
        assert (bus.wire.tally.error_frames, len(frames(restricted))) == (0, 1)


def test_error_frames_are_counted_behind_a_quiet_error() -> None:
    with Lab() as lab:
        bus = fd_bus(lab)
        sender, restricted = bus.node("a"), bus.node("b", options=RESTRICTED)
        bus.node("c")
        bus.faults.flip(bit=20, seen_by=restricted)
        bus.faults.flip(bit=30, frame_id=CLASSIC.id)
        sender.send(FD)
        sender.send(CLASSIC)
        lab.run_until_idle()
        assert (bus.frames, bus.error_frames) == (2, 1)


def test_it_either_listens_only_or_is_restricted() -> None:
    with Lab() as lab, pytest.raises(BadValue, match="choose one"):
        fd_bus(lab).node("b", listen_only=True, options=RESTRICTED)


# bus monitoring


@each("bit", [20, 60, "crc delimiter"])
def test_bus_monitoring_disturbs_nobody(bit: int | str) -> None:
    with Lab() as lab:
        bus = fd_bus(lab)
        sender, other, monitor = bus.node("a"), bus.node("b"), bus.node("c", listen_only=True)
        bus.faults.flip(bit=bit, seen_by=monitor)
        sender.send(FD)
        lab.run_until_idle()
        sender.send(CLASSIC)
        lab.run_until_idle()
        assert (bus.frames, sender.tec, other.rec, len(frames(other))) == (2, 0, 0, 2)
        assert (monitor.tec, monitor.rec, frames(monitor)) == (0, 0, [(CLASSIC.id, CLASSIC.data)])


# edge filter


@each(("width_ns", "ignored"), [(5, True), (25, True), (26, False), (400, False)])
def test_the_edge_filter_ignores_less_than_two_quanta(width_ns: int, ignored: bool) -> None:
    """Quanta of 12.5 ns. Ten recessive bits have passed when the spike comes, between two samples."""
    sent_ns = {}
    for edge_filter in (False, True):
        with Lab() as lab:
            bus = lab.can_bus(bit_rate=500_000)
            other = bus.node("a")
            late = bus.node("late", options=ControllerOptions(edge_filter=edge_filter))
            assert late.settings.timing.quantum_ps == 12_500
            late.stop()
            bus.faults.hold("recessive", at=lab.now_ns, bits=40, seen_by=other)  # goes on bit by bit
            lab.run_for(10e-6)
            late.start()
            late.send(CLASSIC)
            bus.faults.glitch("dominant", at=lab.now_ns + 20_300, width_ns=width_ns, seen_by=late)
            lab.run_for(0.001)
            assert bus.frames == 1
            sent_ns[edge_filter] = bus.wire.tally.last_success_ns
    assert sent_ns[False] - sent_ns[True] == (20_300 if ignored else 0)


# ESI


def test_a_gateway_passes_on_that_a_sender_is_passive() -> None:
    """An error active node may send ESI recessive, frame by frame; a passive one never sends it dominant."""
    with Lab() as lab:
        bus = fd_bus(lab)
        gateway, receiver = bus.node("a"), bus.node("b")
        passed_on = Frame(1, fd=True, error_state_indicator=True)
        for frame in (passed_on, Frame(2, fd=True), passed_on):
            gateway.send(frame)
        lab.run_until_idle()
        assert [frame.error_state_indicator for frame in receiver.receive_many(9)] == [True, False, True]
        controller = gateway.line.controller
        controller.confinement.tec = 140
        controller.count(0, lab.now_ns)
        controller.passive = True
        gateway.send(Frame(2, fd=True))
        lab.run_until_idle()
        assert [frame.error_state_indicator for frame in receiver.receive_many(9)] == [True]


# who has them


@each(
    ("options", "name"),
    [(RESTRICTED, "restricted"), (TOLERANT, "fd_tolerant"), (ControllerOptions(100), "loop_delay_ns")],
)
def test_an_sja1000_has_none_of_it(options: ControllerOptions, name: str) -> None:
    with Lab() as lab, pytest.raises(Unsupported) as refused:
        fd_bus(lab).node("a", controller="sja1000", options=options)
    assert str(refused.value) == f"an SJA1000 has no {name}: only ideal controllers do"
