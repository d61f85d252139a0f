"""Whatever faults come and go, whenever: once they are gone the bus is as it was, and every frame accounted for."""

from __future__ import annotations

from collections.abc import Callable

from hypothesis import given
from hypothesis import strategies as st

from canwire import ErrorState, Frame, Hub, HubFault
from canwire.bus.can.bus import CanBus
from canwire.hub.handles.bus.can import CanBusFaults
from tests.effort import examples
from tests.hub.faults.bench import CONFIG, IDEAL, MCP2515, OTHER, SJA1000, Program, bit_times
from tests.hubs import connected, embedded

LINES = (IDEAL, OTHER, SJA1000, MCP2515)
SET: list[Callable[[CanBusFaults], HubFault]] = [
    lambda faults: faults.flip(bit=30, times=None, frame_id=0x100),
    lambda faults: faults.flip(bit="ack", times=5, seen_by=SJA1000),
    lambda faults: faults.inject("stuff", times=3),
    lambda faults: faults.noise(0.01),
    lambda faults: faults.hold("dominant", at=faults.place("intermission", 1), times=2),
    lambda faults: faults.hold("recessive", bits=None, seen_by=MCP2515),
    lambda faults: faults.hold("dominant", bits=40),
    lambda faults: faults.play("01-01", seen_by=[IDEAL, OTHER]),
    lambda faults: faults.glitch("dominant", width_ns=500.0, lasting=0.0001),
    lambda faults: faults.short(lasting=0.0003),
    lambda faults: faults.disconnect(SJA1000),
    lambda faults: faults.disconnect(IDEAL, lasting=0.0002),
    lambda faults: faults.drift(OTHER, 8_000),
    lambda faults: faults.wrong_rate(MCP2515, 125_000),
    lambda faults: faults.drift(SJA1000, -30_000),
    lambda faults: faults.cable(90.0),
    lambda faults: faults.babble(0x0FF, b"\x01\x02", times=3),
]


def recovered(hub: Hub, program: Program) -> None:
    """On the bus again, whatever it went through."""
    status = hub.line_status(program.place.board.id, program.place.line)
    if ErrorState(status.state) is ErrorState.BUS_OFF:
        hub.recover(program.place.board.id, program.place.line)


@examples(60)
@given(
    steps=st.lists(
        st.tuples(st.integers(0, len(SET) - 1), st.integers(0, 400), st.booleans()), min_size=1, max_size=8
    )
)
def test_once_all_faults_are_gone_the_bus_is_as_it_was(steps: list[tuple[int, int, bool]]) -> None:
    with embedded(CONFIG, time="virtual") as engine, connected(engine, "test") as hub:
        programs = [Program(hub, line) for line in LINES]
        wire = engine.world.buses["can0"]
        assert isinstance(wire, CanBus)
        before = [bit_times(node) for node in wire.nodes]
        nodes = list(wire.nodes)
        faults, there = hub.bus("can0").faults, []
        for number, (kind, wait_us, cancels) in enumerate(steps):
            programs[number % len(programs)].send(Frame(0x100 + number, bytes([number])))
            there.append(SET[kind](faults))
            hub.run_for(wait_us * 1e-6)
            if cancels:
                there.pop(0).cancel()
        faults.clear()
        for program in programs:
            recovered(hub, program)
        hub.run_for(0.5)
        for program in programs:
            recovered(hub, program)
        hub.run_for(0.5)
        assert (faults.list(), sorted(map(id, wire.nodes)), engine.failures) == (
            (),
            sorted(map(id, nodes)),
            0,
        )
        assert [bit_times(node) for node in nodes] == before
        for program in programs:
            program.frames(0)
        for number, program in enumerate(programs):
            program.send(Frame(0x7F0 + number))
            hub.run_for(0.05)
        for number, program in enumerate(programs):
            wanted = [0x7F0 + other for other in range(len(programs)) if other != number]
            assert [frame.id for frame in program.frames(0)] == wanted
            counts = program.channel.status()
            assert (counts.lost, counts.sent) == (0, counts.delivered + counts.aborted + counts.refused)
