"""Nodes of the lab with an SJA1000: `bus.node("x", controller="sja1000")`."""

from __future__ import annotations

import pytest

from canwire import BadTiming, BadValue, ErrorState, EventKind, Frame, Lab, LineError, NotIdle
from tests.cases import each

BIT_NS = 2_000


def test_frames_go_both_ways() -> None:
    with Lab() as lab:
        bus = lab.can_bus()
        chip, ideal = bus.node("chip", controller="sja1000"), bus.node("ideal")
        for frame in (
            Frame(0x123, b"\1\2"),
            Frame(0x1ABCDEF, bytes(8), extended=True),
            Frame(5, remote=True, dlc=3),
        ):
            chip.send(frame)
            assert ideal.receive(1.0) == frame
            ideal.send(frame)
            assert chip.receive(1.0) == frame
        assert (chip.tec, chip.rec, chip.state) == (0, 0, ErrorState.ERROR_ACTIVE)


@pytest.mark.finding("faults-2 7")
@each("ppm", [float("inf"), float("-inf"), float("nan"), -2e6, -1e6, 100_001])
@each("controller", ["fd", "sja1000"])
def test_an_oscillator_that_no_chip_has_is_refused(controller: str, ppm: float) -> None:
    with Lab() as lab:
        bus = lab.can_bus()
        with pytest.raises(BadTiming, match="oscillator_ppm"):
            bus.node("chip", controller=controller, oscillator_ppm=ppm)
        assert list(bus.nodes) == []


def test_it_joins_after_eleven_recessive_bits() -> None:
    """An ideal node counts as having been there all along; a chip cannot be told that."""
    stamps = {}
    for controller in ("fd", "sja1000"):
        with Lab() as lab:
            bus = lab.can_bus()
            sender, other = bus.node("sender", controller=controller), bus.node("other")
            sender.send(Frame(0x555))
            frame = other.receive(1.0)
            assert frame is not None
            stamps[controller] = frame.timestamp_ns
    assert stamps["sja1000"] - stamps["fd"] == 11 * BIT_NS


def test_chips_among_themselves() -> None:
    with Lab() as lab:
        bus = lab.can_bus(bit_rate=1_000_000)
        nodes = [bus.node(f"n{k}", controller="sja1000", self_reception=True) for k in range(4)]
        for k, node in enumerate(nodes):
            node.send_many(Frame(0x100 * k + n, bytes([n])) for n in range(10))
        lab.run_until_idle()
        received = [node.receive_many(99) for node in nodes]
        assert all(frames == received[0] for frames in received)
        assert [frame.id for frame in received[0]] == [0x100 * k + n for k in range(4) for n in range(10)]
        assert bus.error_frames == 0


def test_filters_and_listening() -> None:
    with Lab() as lab:
        bus = lab.can_bus()
        sender, _ = bus.node("sender"), bus.node("acknowledges")
        some = bus.node("some", controller="sja1000", filters=[(0x100, 0x700)])
        quiet = bus.node("quiet", controller="sja1000", listen_only=True)
        lab.run_for(0.001)
        sender.send_many(Frame(id) for id in (0x0FF, 0x100, 0x1FF, 0x200))
        lab.run_until_idle()
        assert [frame.id for frame in some.receive_many(9)] == [0x100, 0x1FF]
        assert len(quiet.receive_many(9)) == 4
        with pytest.raises(LineError, match="listen-only"):
            quiet.send(Frame(1))


def test_alone_it_never_comes_to_rest() -> None:
    with Lab() as lab:
        chip = lab.can_bus().node("chip", controller="sja1000")
        chip.events()
        chip.send(Frame(1))
        with pytest.raises(NotIdle):
            lab.run_until_idle()
        assert (chip.state, chip.tec) == (ErrorState.ERROR_PASSIVE, 128)
        assert [event.state for event in chip.events(EventKind.STATE)] == [
            ErrorState.ERROR_WARNING, ErrorState.ERROR_PASSIVE,
        ]  # fmt: skip


def test_a_plug_that_is_pulled_and_put_back() -> None:
    with Lab() as lab:
        bus = lab.can_bus()
        chip, ideal = bus.node("chip", controller="sja1000"), bus.node("ideal")
        lab.run_for(0.001)
        chip.send(Frame(1, bytes(8)))
        lab.run_for(50e-6)
        bus.faults.disconnect(chip)
        lab.run_for(0.01)
        assert ideal.receive() is None
        assert chip.tec > 0
        before = chip.tec
        bus.faults.reconnect(chip)
        lab.run_until_idle()
        assert ideal.receive() == Frame(1, bytes(8))
        assert chip.tec == before - 1  # counters stayed as they were


def test_a_clock_that_is_off() -> None:
    """3000 ppm are too much for a sample point that far back; 1000 are not."""
    with Lab() as lab:
        bus = lab.can_bus()
        chip, ideal = bus.node("chip", controller="sja1000", oscillator_ppm=1000), bus.node("ideal")
        lab.run_for(0.001)
        chip.send(Frame(0x555, b"\x55" * 8))
        lab.run_until_idle()
        assert ideal.receive() == Frame(0x555, b"\x55" * 8)
    with Lab() as lab:
        bus = lab.can_bus()
        chip, ideal = bus.node("chip", controller="sja1000", oscillator_ppm=50_000), bus.node("ideal")
        lab.run_for(0.001)
        chip.send(Frame(0x001, bytes(8)))
        lab.run_for(0.01)
        assert bus.error_frames > 0
        assert ideal.receive() is None


def test_on_an_fd_bus_it_destroys_fd_frames() -> None:
    with Lab() as lab:
        bus = lab.can_bus(data_bit_rate=2_000_000)
        fd, _ = bus.node("fd"), bus.node("third")
        chip = bus.node("chip", controller="sja1000")
        lab.run_for(0.001)
        fd.send(Frame(1, bytes(12), fd=True), single_shot=True)
        lab.run_until_idle()
        assert (fd.aborted, bus.error_frames > 0, chip.rec > 0) == (1, True, True)
        with pytest.raises(LineError):
            chip.send(Frame(1, fd=True))
        fd.send(Frame(2))
        assert chip.receive(1.0) == Frame(2)


def test_bus_off_and_restart() -> None:
    with Lab() as lab:
        bus = lab.can_bus()
        chip, ideal = bus.node("chip", controller="sja1000"), bus.node("ideal")
        bus.faults.flip(frame_id=1, bit="crc delimiter", times=None, seen_by="sender")
        chip.send(Frame(1))
        lab.run_for(0.2)
        assert (chip.state, chip.tec) == (ErrorState.BUS_OFF, 256)
        bus.faults.clear()
        ideal.receive_many(99)
        chip.restart()
        lab.run_until_idle()
        assert chip.state is ErrorState.ERROR_ACTIVE
        assert ideal.receive() == Frame(1)


@each("controller", ["", "SJA1000", "mcp2515"])
def test_controllers_that_there_are_not(controller: str) -> None:
    with Lab() as lab, pytest.raises(BadValue, match="'fd' or 'sja1000'"):
        lab.can_bus().node("x", controller=controller)


def test_a_script_gives_the_same_twice() -> None:
    def run() -> list[tuple[int, int]]:
        with Lab(seed=3) as lab:
            bus = lab.can_bus()
            a, b = bus.node("a", controller="sja1000"), bus.node("b", controller="sja1000")
            bus.faults.noise(1e-3)
            a.send_many(Frame(n, bytes(8)) for n in range(50))
            lab.run_for(0.1)
            return [(frame.id, frame.timestamp_ns) for frame in b.receive_many(99)]

    assert run() == run() != []
