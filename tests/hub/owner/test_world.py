"""What all clients of a hub share: boards that come and go, clients that do, and what a hundred channels cost."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable

import pytest

from canwire import BadValue, ErrorState, Event, Frame, Hub, InUse, NoSuchBoard, Unplugged, Unsupported
from canwire.boards import catalogue
from canwire.boards.board import BoardKind, Connector
from canwire.boards.can.modes import ChannelMode
from canwire.boards.config.configuration import Config
from canwire.boards.config.tables import BoardConfig, BusConfig
from canwire.boards.figures import USB_TO_CAN
from canwire.hub.owner.world import World
from canwire.hub.protocol import messages as m
from canwire.timeline import NEVER
from canwire.values.frame import record_to_send
from canwire.values.record import SELF_RECEPTION
from tests.descriptors import open_descriptors
from tests.hub.in_memory import CLASSIC, Bench, bench_of

QUEUES = ChannelMode(64, 64)


bench = bench_of()


@pytest.fixture
def hub(bench: Bench) -> Hub:
    made: Hub = bench.hub("one")
    return made


@pytest.fixture
def other(bench: Bench, hub: Hub) -> Hub:
    made: Hub = bench.hub("other")
    return made


# lines of the other kind


@pytest.mark.parametrize(
    ("line", "ask"),
    [
        (0, lambda hub, line: hub.lin_status(hub.boards()[0].id, line)),
        (0, lambda hub, line: hub.open_monitor(hub.boards()[0].id, line)),
        (2, lambda hub, line: hub.line_status(hub.boards()[0].id, line)),
        (2, lambda hub, line: hub.open_channel(hub.boards()[0].id, line)),
        (2, lambda hub, line: hub.open_scheduler(hub.boards()[0].id, line)),
        (2, lambda hub, line: hub.open_share(hub.boards()[0].id, line, read=True, write=True)),
    ],
)
def test_a_line_of_the_other_kind_says_which_it_is(
    hub: Hub, line: int, ask: Callable[[Hub, int], object]
) -> None:
    with pytest.raises(Unsupported, match=f"HW000001:{line} is a {'LIN' if line else 'CAN'} line"):
        ask(hub, line)
    for beyond in (3, -1):
        with pytest.raises((NoSuchBoard, BadValue)):
            ask(hub, beyond)
    ask(hub, 2 - line)


# a client that goes


@pytest.mark.conforms("X3-08", "X3-17", "X3-29", "X3-05")
def test_everything_a_client_held_is_free_when_it_is_gone(bench: Bench, hub: Hub, other: Hub) -> None:
    board = bench.board
    bench.control(other)
    other.open_scheduler(board, 0)
    other.open_channel(board, 1, exclusive=True)
    other.open_control(board, 1)
    other.open_layer(board, "CAL")
    fifo = other.create_fifo(1, 1)
    bench.link(other).die()
    status = hub.line_status(board, 0)
    assert (status.control_holder, status.scheduler_holder, status.channels) == ("", "", 0)
    assert (status.initialised, status.running) == (False, False)  # nobody's settings any more
    hub.open_control(board, 0)
    hub.open_control(board, 1)
    hub.open_scheduler(board, 0)
    hub.open_channel(board, 1, exclusive=True)
    hub.open_layer(board, "BAL")
    with pytest.raises(NoSuchBoard):
        hub.open_fifo(fifo.id, "fifo")


@pytest.mark.conforms("PL-13")
def test_others_go_on_when_a_client_is_gone(bench: Bench, hub: Hub, other: Hub) -> None:
    """Even the line that it had set up runs on; only its own frames that wait are given up."""
    bench.control(other, 0)
    partner_hub = bench.hub("partner")
    bench.control(partner_hub, 1)
    partner = bench.channel(partner_hub, 1)
    mine, theirs = bench.channel(hub), bench.channel(other)
    scheduler = other.open_scheduler(bench.board, 0)
    scheduler.start(scheduler.add(record_to_send(Frame(0x700)), 10))
    scheduler.resume()
    for k in range(20):
        mine.send(Frame(k))
        theirs.send(Frame(0x100 + k))
    hub.run_for(0.0005)
    before = {frame.id for frame in partner.receive_many(100)}
    assert any(id >= 0x100 for id in before)
    bench.link(other).die()
    hub.run_for(0.1)
    after = [frame.id for frame in partner.receive_many(100)]
    assert [id for id in after if id < 0x100] == [id for id in range(20) if id not in before]
    assert len([id for id in after if id >= 0x100]) <= 1  # one may have been on the wire
    assert hub.line_status(bench.board, 0).running
    partner.send(Frame(0x55))
    assert mine.receive(1.0) == Frame(0x55)
    assert partner.status().lost == 0


def test_a_client_may_go_in_the_middle_of_its_frame(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(other, 0)
    bench.control(hub, 1)
    partner, theirs, kept = bench.channel(hub, 1), bench.channel(other), bench.channel(hub, 0)
    theirs.send(Frame(1, bytes(8)))
    hub.run_for(50e-6)
    bench.link(other).die()
    assert partner.receive(1.0) == Frame(1, bytes(8))
    assert hub.line_status(bench.board, 1).errors == 0
    assert kept.status().active


def test_closing_a_session_twice_is_fine(bench: Bench, hub: Hub) -> None:
    bench.channel(hub)
    bench.link(hub).die()
    bench.world.close_session(bench.link(hub).session)
    assert bench.world.sessions == []


def test_no_descriptor_and_no_node_is_left_behind(bench: Bench, hub: Hub) -> None:
    bench.control(hub)
    before, nodes = open_descriptors(), len(bench.world.buses["can0"].nodes)
    for way in ("close", "die"):
        guest = bench.hub("guest")
        channels = [bench.channel(guest) for _ in range(3)]
        channels[0].set_up(ChannelMode(4, 4))
        event = Event()
        channels[1].reading.assign(event)
        guest.watch(event)
        made = guest.create_fifo(4, 4)
        guest.open_fifo(made.id, "reader")
        if way == "die":
            bench.link(guest).die()
        guest.close()
        event.close()
    assert open_descriptors() <= before
    assert len(bench.world.buses["can0"].nodes) == nodes


# boards that come and go


@pytest.mark.conforms("X3-01")
def test_the_boards_of_the_default_world(hub: Hub) -> None:
    """Source: rulings.md 30, as far as boards exist."""
    boards = hub.boards()
    assert [(board.kind, board.hardware_id) for board in boards] == [
        ("usb-to-can-fd", "HW000001"),
        ("usb-to-can", "HW000002"),
    ]
    lines = [line.name for board in boards for line in board.lines if line.bus_type == "CAN"]
    assert lines == ["CAN-1", "CAN-2"] * 2
    assert hub.board("HW000002") == hub.board("usb-to-can") == boards[1]
    with pytest.raises(
        NoSuchBoard, match=r"no board 'HW9'; plugged in: HW000001 \(usb-to-can-fd\), HW000002"
    ):
        hub.board("HW9")


@pytest.mark.conforms("X3-02", "X3-03")
def test_every_change_of_the_list_is_told_to_those_who_watch(bench: Bench, hub: Hub, other: Hub) -> None:
    one, another, third = Event(), Event(manual_reset=True), Event()
    hub.watch(one)
    hub.watch(one)
    hub.watch(another)
    board = other.plug("usb-to-can")
    assert bench.link(hub).notices == [m.BoardsChanged()]
    assert bench.link(other).notices == []
    assert one.wait(0)
    assert not one.wait(0)
    assert another.is_set()
    assert board in hub.boards()
    another.reset()
    hub.unwatch(one)
    hub.unwatch(one)
    hub.unwatch(third)
    hub.unplug(board.hardware_id)
    assert board not in other.boards()
    assert len(bench.link(hub).notices) == 2
    assert (one.is_set(), another.is_set()) == (False, True)
    for event in (one, another, third):
        event.close()


@pytest.mark.conforms("X3-02")
def test_waiting_for_a_change_lets_virtual_time_pass(bench: Bench, hub: Hub, other: Hub) -> None:
    event = Event()
    hub.watch(event)
    bench.world.timeline.at(1_000_000, lambda: bench.world.unplug("HW000002"))
    assert event.wait(0) is False
    other.run_for(0.01)
    assert event.wait(0)
    event.close()


@pytest.mark.conforms("X3-35")
def test_an_unplugged_board_ends_every_handle_on_it_and_no_other(bench: Bench, hub: Hub, other: Hub) -> None:
    second = hub.boards()[1].id
    on_it = [bench.control(hub), bench.channel(hub), bench.channel(other, 1), other.open_control(bench.board, 1),
             other.open_scheduler(bench.board, 0), hub.open_layer(bench.board, "BAL")]  # fmt: skip
    elsewhere = [hub.open_control(second, 0), other.open_channel(second, 0), hub.create_fifo(1, 1)]
    hub.unplug("HW000001")
    for lease in on_it:
        with pytest.raises(Unplugged, match=r"board HW000001 \(usb-to-can-fd\) was unplugged"):
            lease.check()
    for lease in elsewhere:
        lease.check()
    gone = [notice for notice in bench.link(hub).notices if isinstance(notice, m.Gone)]
    assert [sorted(notice.handles) for notice in gone] == [sorted(on_it[k].handle for k in (0, 1, 5))]
    with pytest.raises(NoSuchBoard, match="it may have been unplugged"):
        hub.line_status(on_it[0].board, 0)  # type: ignore[union-attr]
    with pytest.raises(NoSuchBoard, match="no board 'HW000001' to unplug; plugged in: HW000002"):
        hub.unplug("HW000001")
    for lease in on_it:
        lease.close()


@pytest.mark.conforms("X3-35")
def test_the_same_board_replugged_can_be_opened_again(bench: Bench, hub: Hub, other: Hub) -> None:
    lease, layer = hub.open_control(bench.board, 0), hub.open_layer(bench.board, "BAL")
    old = hub.board("HW000001")
    hub.unplug("HW000001")
    again = other.plug("usb-to-can-fd", "HW000001")
    assert hub.board("HW000001") == again
    assert again.id != old.id
    assert (again.hardware_id, again.kind) == (old.hardware_id, old.kind)
    with pytest.raises(Unplugged):
        lease.initialise(CLASSIC)
    other.open_layer(again.id, "CAL")
    control = other.open_control(again.id, 0)
    lease.close()  # of the board before: it frees nothing of this one
    layer.close()
    with pytest.raises(InUse):
        hub.open_control(again.id, 0)
    control.initialise(CLASSIC)
    control.start()
    assert control.status().running


@pytest.mark.conforms("X3-35")
def test_unplugged_in_the_middle_of_a_frame(bench: Bench, hub: Hub, other: Hub) -> None:
    """Others on the bus see an error, and go on."""
    second = hub.boards()[1].id
    bench.control(hub)
    for line in (0, 1):
        control = other.open_control(second, line)
        control.initialise(CLASSIC)
        control.start()
    sender, receiver = bench.channel(hub), other.open_channel(second, 0)
    receiver.set_up(QUEUES)
    receiver.activate()
    third = other.open_channel(second, 1)
    third.set_up(QUEUES)
    third.activate()
    hub.run_for(0.001)
    sender.send(Frame(1, bytes(8)))
    hub.run_for(50e-6)
    hub.unplug("HW000001")
    hub.run_for(0.01)
    assert receiver.receive() is None
    assert other.line_status(second, 0).errors == 1
    third.send(Frame(2))
    assert receiver.receive(1.0) == Frame(2)
    assert len(bench.world.buses["can0"].nodes) == 2


def test_a_board_without_a_number_gets_the_lowest_free_one(bench: Bench, hub: Hub) -> None:
    first, second = hub.plug("usb-to-can"), hub.plug("usb-to-can")
    assert (first.hardware_id, second.hardware_id) == ("HW000003", "HW000004")
    hub.unplug("HW000003")
    hub.unplug("HW000001")
    assert hub.plug("usb-to-can").hardware_id == "HW000003"  # that of the configuration stays kept for it
    assert hub.plug("usb-to-can-fd", "HW000001").hardware_id == "HW000001"
    assert hub.plug("usb-to-can", "HWmine").hardware_id == "HWmine"


def test_a_board_that_cannot_be_plugged_in_leaves_nothing(
    hub: Hub, bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    lin = BoardKind("mixed", "2219F6A0-732A-4750-B66F-0AE731FB40E1", "", (
        Connector("CAN", USB_TO_CAN, "can0"), Connector("LIN", USB_TO_CAN, "can0")
    ))  # fmt: skip
    monkeypatch.setitem(catalogue.KINDS, "mixed", lin)
    nodes = len(bench.world.buses["can0"].nodes)
    with pytest.raises(Unsupported, match="LIN-1 needs a LIN bus"):
        hub.plug("mixed")
    with pytest.raises(NoSuchBoard, match="no bus 'can9'"):
        hub.plug("usb-to-can", "HW5", ("can0", "can9"))
    with pytest.raises(BadValue, match="is plugged in already"):
        hub.plug("usb-to-can-fd", "HW000001")
    assert len(hub.boards()) == 2
    assert len(bench.world.buses["can0"].nodes) == nodes


def test_lines_on_buses_of_their_own() -> None:
    config = Config(
        bus=(BusConfig(name="left"), BusConfig(name="right", bit_rate=250_000)),
        board=(BoardConfig(kind="usb-to-can", serial="HW1", buses=("left", "right")),),
    )
    bench = Bench(config)
    hub = bench.hub()
    first = bench.control(hub, 0, CLASSIC)
    bench.control(hub, 1, CLASSIC)
    channel, other = bench.channel(hub, 0), bench.channel(hub, 1)
    channel.send(Frame(1))
    hub.run_for(0.1)
    assert other.receive() is None
    assert first.status().state == ErrorState.ERROR_PASSIVE  # alone on its bus
    with pytest.raises(NoSuchBoard, match="there are left, right"):
        hub.short("can0")
    bench.close()


# for the hub's pace


def test_a_frame_after_a_rest_does_not_make_its_bus_unhealthy(bench: Bench, hub: Hub) -> None:
    """Fast time followed the clock for it: on a system that waits in steps of 15 ms each such frame took one."""
    bench.control(hub)
    bench.control(hub, 1)
    channel = bench.channel(hub)
    for rest_s in (0.005, 0.02, 1.0):
        hub.run_for(rest_s)
        channel.send(Frame(1))
        bench.world.kick_all()
        assert bench.world.healthy(), f"after {rest_s} s"
        hub.run_for(0.001)
        assert bench.world.healthy()


def test_a_bus_that_only_repeats_is_not_healthy(bench: Bench, hub: Hub) -> None:
    assert bench.world.healthy()
    bench.control(hub)
    channel = bench.channel(hub)
    channel.send(Frame(1))
    hub.run_for(0.005)
    assert bench.world.healthy()
    for _ in range(100):
        hub.run_for(0.01)
        assert not bench.world.healthy()
    bench.control(hub, 1)
    hub.run_for(0.01)
    assert bench.world.healthy()


def test_no_queue_overflows_before_the_horizon(bench: Bench, hub: Hub, other: Hub) -> None:
    world = bench.world
    assert world.horizon_ns() == NEVER
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub, mode=ChannelMode(64, 4)), bench.channel(other, 1)
    for k in range(64):
        partner.send(Frame(k))
    while partner.status().pending:
        free = channel.reading.ring.free()
        hub.run_for(world.horizon_ns() / 1e9)
        assert channel.status().lost == 0
        if channel.reading.ring.free() == free == 0:
            channel.receive_many(100)
    channel.receive_many(100)


def test_a_queue_that_is_nearly_full_stalls_and_rings_when_there_is_room(
    bench: Bench, hub: Hub, other: Hub
) -> None:
    world = bench.world
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub, mode=ChannelMode(64, 0)), bench.channel(other, 1)
    bell = bench.link(hub)._bell
    assert not world.stalled()
    for k in range(60):
        partner.send(Frame(k))
    hub.run_for(0.1)
    bell.clear()
    assert world.stalled()
    channel.receive_many(20)
    assert not bell.wait(0)
    channel.receive_many(20)
    assert bell.wait(0)
    assert not world.stalled()


# what it costs


def test_a_hundred_channels_cost_little(bench: Bench, hub: Hub, other: Hub) -> None:
    """At most 16 KB each at the hub and its client together, beyond their rings."""
    bench.control(hub)
    bench.control(other, 1)
    partner = bench.channel(other, 1)
    bench.channel(hub)
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        channels = [bench.channel(hub) for _ in range(100)]
        cost = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()
    assert cost / 100 < 16_384
    partner.send(Frame(1))
    hub.run_for(0.01)
    assert all(channel.receive() == Frame(1) for channel in channels)
    for channel in channels:
        channel.send(Frame(2), SELF_RECEPTION)
    hub.run_for(0.1)
    assert len(partner.receive_many(200)) == 64  # as much as it has room for
    assert partner.status().lost == 36
    assert all(channel.receive_many(200) == [Frame(2)] for channel in channels)  # each its own


def test_a_world_needs_no_configuration_of_boards() -> None:
    world = World(Config(), virtual=True)
    assert world.infos() == ()
    assert next(iter(world.buses)) == "can0"
