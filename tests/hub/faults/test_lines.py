"""Faults of single lines and of the copper in virtual time: plugs, clocks, cables, babbling nodes."""

from __future__ import annotations

import pytest

from canwire import ChannelMode, ErrorKind, ErrorState, Frame, Hub, Unplugged, Unsupported
from canwire.bus.can.bus import CanBus
from canwire.hub.owner.engine import Engine
from tests.hub.faults.bench import FRAME, IDEAL, LIN, MCP2515, OTHER, SJA1000, Program, bit_times
from tests.hub.faults.conftest import Programs
from tests.hubs import embedded

CONTROLLERS = pytest.mark.parametrize("line", [IDEAL, SJA1000, MCP2515])


def state(program: Program) -> ErrorState:
    return ErrorState(program.hub.line_status(program.place.board.id, program.place.line).state)


@pytest.mark.conforms("N-07")
@CONTROLLERS
def test_a_pulled_plug_makes_a_line_lonely_until_it_is_put_back(hub: Hub, line: str) -> None:
    lonely, other = Program(hub, line), Program(hub, OTHER)
    faults = hub.bus("can0").faults
    pulled = faults.disconnect(line)
    lonely.send()
    hub.run_for(0.1)
    assert other.frames(0) == []
    assert state(lonely) is ErrorState.ERROR_PASSIVE
    other.errors()
    pulled.cancel()
    hub.run_for(0.1)
    assert [frame.id for frame in other.frames(0)] == [0x123]
    other.send()
    hub.run_for(0.1)
    assert [frame.id for frame in lonely.frames(0)] == [0x123]


def test_a_plug_pulled_twice_is_put_back_by_the_last(hub: Hub) -> None:
    lonely, other = Program(hub, IDEAL), Program(hub, OTHER)
    first, second = hub.bus("can0").faults.disconnect(IDEAL), hub.bus("can0").faults.disconnect(IDEAL)
    first.cancel()
    lonely.send()
    hub.run_for(0.1)
    assert other.frames(0) == []
    second.cancel()
    hub.run_for(0.1)
    assert len(other.frames(0)) == 1


def test_a_board_unplugged_while_its_plug_is_pulled(hub: Hub, engine: Engine) -> None:
    Program(hub, IDEAL)
    other = Program(hub, SJA1000)
    faults = hub.bus("can0").faults
    pulled, seen = faults.disconnect(IDEAL), faults.flip(bit=30, seen_by=IDEAL, times=None)
    noise = faults.noise(1e-9)
    hub.unplug("HW000001")
    assert pulled.info().over == seen.info().over == "board HW000001 was unplugged"
    assert noise.info().over == ""
    other.send()
    hub.run_for(0.001)
    assert engine.world.faults.stubs() == []


def test_a_lin_line_loses_its_bus_too(hub: Hub, engine: Engine) -> None:
    pulled = hub.lin_bus("lin0").faults.disconnect(LIN)
    assert len(engine.world.buses["lin0"].nodes) == 0
    pulled.cancel()
    assert len(engine.world.buses["lin0"].nodes) == 1


@pytest.mark.conforms("N-07")
@CONTROLLERS
def test_a_line_at_a_wrong_rate_hears_errors_only_and_is_well_again(
    hub: Hub, engine: Engine, line: str
) -> None:
    wrong, sender = Program(hub, line), Program(hub, OTHER)
    Program(hub, next(each for each in (SJA1000, MCP2515) if each != line))
    node = engine.world.can_slot(wrong.place.board.id, wrong.place.line).can.line.controller
    right = bit_times(node)
    fault = hub.bus("can0").faults.wrong_rate(line, 250_000)
    assert fault.info().text == f"wrong rate of {line}: 250000 bit/s"
    sender.send()
    hub.run_for(0.01)
    assert wrong.frames(0) == []
    fault.cancel()
    assert bit_times(node) == right
    hub.run_for(0.1)
    sender.send()
    hub.run_for(0.1)
    assert {frame.id for frame in wrong.frames(0)} == {0x123}


@pytest.mark.conforms("N-07")
@CONTROLLERS
def test_a_drift_outlasts_a_new_setup_and_ends_to_the_picosecond(hub: Hub, engine: Engine, line: str) -> None:
    program = Program(hub, line)
    node = engine.world.can_slot(program.place.board.id, program.place.line).can.line.controller
    right = bit_times(node)
    fast, slow = hub.bus("can0").faults.drift(line, 40_000), hub.bus("can0").faults.drift(line, -10_000)
    assert node.bit_ps == round(2_000_000 / (1.04 * 0.99))
    program.channel.close()  # the last user: the line is reset
    program = Program(hub, line)
    assert node.bit_ps == round(2_000_000 / (1.04 * 0.99))
    slow.cancel()
    fast.cancel()
    assert bit_times(node) == right


@pytest.mark.conforms("N-07")
def test_a_small_drift_costs_nothing_and_a_large_one_frames(hub: Hub) -> None:
    sender, receiver = Program(hub, IDEAL), Program(hub, OTHER)
    faults = hub.bus("can0").faults
    small = faults.drift(IDEAL, 2_000)
    sender.send(Frame(0x555, b"\x00" * 8))
    hub.run_for(0.01)
    assert (len(receiver.frames(0)), receiver.errors()) == (1, [])
    small.cancel()
    faults.drift(IDEAL, 60_000)
    sender.send(Frame(0x555, b"\x00" * 8))
    hub.run_for(0.01)
    assert receiver.errors() or not receiver.frames(0)


@pytest.mark.conforms("N-07")
def test_a_cable_too_long_for_its_rate(hub: Hub, engine: Engine) -> None:
    sender, receiver = Program(hub, IDEAL), Program(hub, OTHER)
    bus = engine.world.buses["can0"]
    assert isinstance(bus, CanBus)
    long, longer = hub.bus("can0").faults.cable(50.0), hub.bus("can0").faults.cable(300.0)
    sender.send()
    hub.run_for(0.001)
    assert receiver.hub.line_status(sender.place.board.id, 0).tec > 0
    long.cancel()
    assert bus.delay_ps > 1_500_000  # the latest one counts
    longer.cancel()
    assert bus.delay_ps == 0
    hub.run_for(0.1)
    assert {frame.id for frame in receiver.frames(0)} == {
        0x123
    }  # whole, but acknowledged too late for the sender
    sender.send()
    hub.run_for(0.1)
    assert len(receiver.frames(0)) == 1


@pytest.mark.conforms("N-07")
def test_a_babbling_node_takes_the_bus_and_gives_it_back(hub: Hub) -> None:
    sender, receiver = Program(hub, IDEAL), Program(hub, OTHER)
    babble = hub.bus("can0").faults.babble(0, b"\xff")
    hub.run_for(0.001)
    sender.send()
    hub.run_for(0.01)
    heard = [frame.id for frame in receiver.frames(0)]
    assert 0x123 not in heard
    assert heard.count(0) == babble.struck > 80
    babble.cancel()
    hub.run_for(0.001)
    assert [frame.id for frame in receiver.frames(0)][-1] == 0x123
    assert (receiver.lost(), sender.lost()) == (0, 0)


def test_a_babbling_node_has_the_bit_rate_of_the_line_that_runs(hub: Hub) -> None:
    slow = Program(hub, IDEAL, 125_000)
    babble = hub.bus("can0").faults.babble(0x7, times=3)
    assert babble.wait(1.0)
    assert [frame.id for frame in slow.frames(0)] == [0x7] * 3


def test_what_a_babbling_node_makes_others_lose_is_counted(hub: Hub) -> None:
    slow = Program(hub, IDEAL)
    small = hub.open_channel(slow.place.board.id, slow.place.line)
    small.set_up(ChannelMode(16, 0, exact=True))
    small.activate()
    babble = hub.bus("can0").faults.babble(0, times=100)
    assert babble.wait(1.0)
    counts = small.status()
    assert (counts.accepted, counts.lost, len(small.receive_many(200))) == (100, 84, 16)
    assert (len(slow.frames(0)), slow.lost()) == (100, 0)


def test_a_babbling_node_counts_and_leaves(hub: Hub, engine: Engine) -> None:
    receiver = Program(hub, OTHER)
    nodes = len(engine.world.buses["can0"].nodes)
    babble = hub.bus("can0").faults.babble(
        frame=Frame(0x18FF0001, b"\x01\x02", extended=True), gap=0.1, times=3
    )
    assert babble.wait(1.0)
    assert [frame.timestamp_ns // 10**8 for frame in receiver.frames(0)] == [0, 1, 2]
    assert (babble.struck, len(engine.world.buses["can0"].nodes)) == (3, nodes)


@pytest.mark.conforms("N-07")
def test_a_deaf_line_hears_nothing_and_a_stuck_bus_everybody_s_errors(hub: Hub) -> None:
    sender, receiver = Program(hub, IDEAL), Program(hub, OTHER)
    Program(hub, SJA1000)
    deaf = hub.bus("can0").faults.hold("recessive", bits=None, seen_by=OTHER)
    sender.send()
    hub.run_for(0.01)
    assert receiver.frames(0) == []
    deaf.cancel()
    stuck = hub.bus("can0").faults.hold("dominant", bits=None)
    sender.send()
    hub.run_for(0.01)
    assert receiver.frames(0) == []
    stuck.cancel()
    hub.run_for(0.1)
    assert len(receiver.frames(0)) == 1


def test_a_level_held_for_long_ends_with_its_time(hub: Hub, engine: Engine) -> None:
    sender, receiver = Program(hub, IDEAL), Program(hub, OTHER)
    held = hub.bus("can0").faults.hold("dominant", bits=1_000_000, lasting=0.001)
    hub.run_for(0.0005)
    assert (held.struck, held.info().over) == (1, "used up")
    hub.run_for(0.001)
    sender.send()
    hub.run_for(0.01)
    assert len(receiver.frames(0)) == 1
    held.cancel()


def test_fast_time_keeps_to_the_clock_while_a_line_is_lonely_or_a_node_babbles(
    hub: Hub, engine: Engine
) -> None:
    lonely = Program(hub, IDEAL)
    faults = hub.bus("can0").faults
    assert engine.world.healthy()
    pulled = faults.disconnect(IDEAL)
    lonely.send()
    hub.run_for(0.1)
    assert not engine.world.healthy()
    lonely.channel.close()
    pulled.cancel()
    hub.run_for(0.1)
    assert engine.world.healthy()
    Program(hub, OTHER)
    babble = faults.babble(0, gap=0.01)
    assert not engine.world.healthy()
    babble.cancel()
    assert engine.world.healthy()


@pytest.mark.conforms("N-07")
def test_a_short_is_there_as_long_as_anybody_shorts_it(hub: Hub, engine: Engine) -> None:
    bus = engine.world.buses["can0"]
    assert isinstance(bus, CanBus)
    first, second = hub.bus("can0").faults.short(), hub.bus("can0").faults.short()
    hub.short("can0")
    first.cancel()
    hub.short("can0", False)
    assert bus.bits.shorted
    second.cancel()
    assert not bus.bits.shorted


def test_a_fault_dies_with_its_program_in_the_middle_of_a_frame(program: Programs) -> None:
    staying, leaving = program("staying"), program("leaving")
    sender, receiver = Program(staying, IDEAL), Program(staying, OTHER)
    leaving.bus("can0").faults.flip(bit=40, times=None)
    sender.send()
    staying.run_for(30 * 2e-6)
    leaving.close()
    staying.run_for(0.01)
    assert len(receiver.frames(0)) == 1
    assert receiver.errors() == []


def test_one_program_s_flips_leave_another_s_alone(program: Programs) -> None:
    first, second = program("first"), program("second")
    sender, receiver = Program(first, IDEAL), Program(first, OTHER)
    mine = first.bus("can0").faults.flip(bit=30, times=None, frame_id=0x555)
    other = second.bus("can0").faults.flip(bit=31, times=2)
    sender.send()
    first.run_for(0.01)
    assert (mine.struck, other.struck) == (0, 2)
    assert len(receiver.frames(0)) == 1


def test_the_hub_keeps_so_many_faults_and_forgets_old_ones_first(hub: Hub) -> None:
    faults = hub.bus("can0").faults
    done = faults.short(lasting=0.001)
    hub.run_for(0.01)
    for _ in range(255):
        faults.noise(0.0)
    assert done.info().over == "its time was over"
    assert len(faults.list()) == 256
    faults.noise(1e-9)
    assert len(faults.list()) == 256
    assert faults.clear() >= 1


def test_states_of_a_sender_whose_every_frame_is_disturbed(hub: Hub) -> None:
    sender, receiver = Program(hub, IDEAL), Program(hub, OTHER)
    Program(hub, SJA1000)
    fault = hub.bus("can0").faults.flip(bit=30, times=None, seen_by="sender")
    sender.send()
    hub.run_for(0.1)
    assert state(sender) is ErrorState.BUS_OFF
    assert fault.struck == 32
    assert ErrorKind.BIT in sender.errors()
    fault.cancel()
    hub.recover(sender.place.board.id, sender.place.line)
    hub.run_for(0.1)
    assert state(sender) is ErrorState.ERROR_ACTIVE
    sender.send()
    hub.run_for(0.01)
    assert FRAME.id in [frame.id for frame in receiver.frames(0)]


def test_real_wire_cannot_be_disturbed(tmp_path: object) -> None:
    config = '[[bus]]\nname = "can0"\n[[board]]\nkind = "slcan"\nserial = "HW000007"\nport = "socket://127.0.0.1:9"\n'
    from tests.hubs import connected

    with embedded(config, time="fast") as engine, connected(engine) as hub:
        for name in ("HW000007:0", "socket://127.0.0.1:9"):
            with pytest.raises(Unsupported, match="HW000007 is a real adapter on a real bus"):
                hub.bus(name)


def test_after_unplugging_everything_faults_can_still_be_set(hub: Hub) -> None:
    sender = Program(hub, IDEAL)
    hub.unplug("HW000001")
    with pytest.raises(Unplugged):
        sender.send()
    assert hub.bus("can0").faults.short(lasting=0.1).wait(1.0)
