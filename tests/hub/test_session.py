"""Everything a client can ask of its hub, over a link without I/O and in virtual time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import replace
from typing import Any

import pytest

from canwire import (
    BadFilter,
    BadFrame,
    BadMessage,
    BadTiming,
    BadValue,
    BitTiming,
    BusEvent,
    CanwireError,
    ChannelStatus,
    Closed,
    ErrorKind,
    ErrorState,
    Event,
    EventKind,
    Frame,
    Hub,
    HubChannel,
    HubError,
    HubLost,
    InUse,
    LineError,
    NoSuchBoard,
    NothingHeard,
    NotInitialised,
    QueueFull,
    Unplugged,
    Unsupported,
    WrongState,
)
from canwire.boards import catalogue
from canwire.boards.can.modes import (
    ChannelMode,
    FilterContent,
    FilterMode,
    FilterSetup,
    LineMode,
    Siblings,
)
from canwire.boards.description import Feature
from canwire.bus.can.faults.faults import Faults
from canwire.hub.owner.held.can import CanSlot
from canwire.hub.protocol import messages as m
from canwire.values.event import InfoCode
from canwire.values.frame import record_to_send
from canwire.values.record import CONFIRM, SELF_RECEPTION
from tests.hub.in_memory import CLASSIC, DATA, FD, NOMINAL, Bench, bench_of

FRAME_NS = 2_000  # a bit of 500 kbit/s
NONE = (0x80000000, 0xFFFFFFFF)  # CAN_ACC_CODE_NONE, CAN_ACC_MASK_NONE
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


def identifiers(channel: HubChannel, seconds: float = 0.1) -> list[int]:
    """Of every frame that is there, or comes within so much virtual time."""
    channel.hub.run_for(seconds)
    return [frame.id for frame in channel.receive_many(1000)]


def read_all(channel: HubChannel) -> list[BusEvent]:
    """Events in its queue; frames are dropped."""
    found = []
    while (record := channel.receive_record()) is not None:
        if record[12]:
            found.append(BusEvent.from_record(record))
    return found


# one control


@pytest.mark.conforms("X3-08", "PL-13")
def test_a_line_has_one_control(bench: Bench, hub: Hub, other: Hub) -> None:
    control = hub.open_control(bench.board, 0)
    for another in (other, hub):
        with pytest.raises(InUse, match=r"HW000001:0: its control is held by one \(100\)"):
            another.open_control(bench.board, 0)
    other.open_control(bench.board, 1)  # another line
    control.close()
    control.close()
    other.open_control(bench.board, 0)


@pytest.mark.conforms("X3-08", "X4-40")
@pytest.mark.parametrize("stays", ["channel", "scheduler"])
def test_what_it_set_up_stays_while_anybody_uses_the_line(
    bench: Bench, hub: Hub, other: Hub, stays: str
) -> None:
    control = bench.control(hub)
    held: Any
    held = bench.channel(other) if stays == "channel" else other.open_scheduler(bench.board, 0)
    control.close()
    status = other.line_status(bench.board, 0)
    assert (status.running, status.initialised, status.control_holder) == (True, True, "")
    bench.control(hub, 1)
    sender = bench.channel(hub, 1)
    sender.send(Frame(5))
    hub.run_for(0.01)
    assert sender.status().delivered == 1  # it is there and acknowledges
    held.close()
    status = hub.line_status(bench.board, 0)
    assert (status.running, status.initialised, status.mode) == (False, False, None)


@pytest.mark.conforms("X4-40")
def test_a_program_that_comes_next_finds_the_settings(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.channel(other)
    bench.control(hub).close()
    taken = other.open_control(bench.board, 0)
    assert taken.status().running
    taken.stop()
    assert taken.status().mode == FD


@pytest.mark.conforms("X3-07")
def test_anybody_may_look_at_a_line(bench: Bench, hub: Hub, other: Hub) -> None:
    control = bench.control(hub)
    statuses = [each.line_status(bench.board, 0) for each in (hub, other, hub)]
    assert statuses[0] == statuses[1] == statuses[2] == control.status()
    assert (statuses[0].control_holder, statuses[0].mode) == ("one (100)", FD)
    assert statuses[0].time_ns == hub.now_ns()


@pytest.mark.conforms("X3-09")
def test_the_states_of_a_line(bench: Bench, hub: Hub) -> None:
    control = hub.open_control(bench.board, 0)
    seen = []
    for action in (control.stop, lambda: control.initialise(CLASSIC), control.start, control.start,
                   control.stop, control.start, control.reset, control.reset):  # fmt: skip
        action()
        status = control.status()
        seen.append((status.initialised, status.running))
    none, ready, running = (False, False), (True, False), (True, True)
    assert seen == [none, ready, running, running, ready, running, none, none]
    with pytest.raises(NotInitialised, match="initialise the line"):
        control.start()


# channels and who may have them


@pytest.mark.conforms("X3-17")
def test_an_exclusive_channel_is_the_only_one(bench: Bench, hub: Hub, other: Hub) -> None:
    channel = hub.open_channel(bench.board, 0, exclusive=True)
    assert hub.line_status(bench.board, 0).exclusive
    for exclusive in (False, True):
        with pytest.raises(InUse, match=r"an exclusive channel already open on it, by one \(100\)"):
            other.open_channel(bench.board, 0, exclusive=exclusive)
    channel.close()
    shared = [each.open_channel(bench.board, 0) for each in (hub, other, hub)]
    assert hub.line_status(bench.board, 0).channels == 3
    with pytest.raises(InUse, match=r"3 channels already open on it, by one \(100\)"):
        other.open_channel(bench.board, 0, exclusive=True)
    for each in shared:
        each.close()
    other.open_channel(bench.board, 0, exclusive=True)
    assert hub.line_status(bench.board, 0).channels == 1


@pytest.mark.conforms("X3-16")
def test_a_new_channel_has_no_queues(bench: Bench, hub: Hub) -> None:
    channel = hub.open_channel(bench.board, 0)
    for call in (
        channel.receive,
        channel.receive_record,
        lambda: channel.send(Frame(1)),
        lambda: channel.reading,
    ):
        with pytest.raises(NotInitialised, match="channel on line 0"):
            call()
    with pytest.raises(NotInitialised, match="HW000001:0: set the channel up before activating it"):
        channel.activate()
    with pytest.raises(NotInitialised, match="has filters once it is set up"):
        channel.filter_mode(extended=False)
    channel.deactivate()
    assert channel.cancel() == 0
    status = channel.status()
    assert (status.active, status.accepted, status.sent) == (False, 0, 0)


@pytest.mark.conforms("X3-16", "X3-19")
def test_frames_move_while_it_is_active_and_the_line_runs(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(other, 1)
    partner = bench.channel(other, 1)
    channel = hub.open_channel(bench.board, 0)
    channel.set_up(QUEUES)
    control = hub.open_control(bench.board, 0)
    control.initialise(FD)
    received = []
    steps = ((False, False), (True, False), (False, True), (True, True), (False, True))
    for number, (activate, start) in enumerate(steps, 1):
        (channel.activate if activate else channel.deactivate)()
        (control.start if start else control.stop)()
        hub.run_for(0.001)
        partner.cancel()
        partner.send(Frame(number))
        hub.run_for(0.01)
        received.append([frame.id for frame in channel.receive_many(10)])
    assert received == [[], [], [], [4], []]


@pytest.mark.finding("socketcan 1")
def test_activating_tells_how_the_line_is_from_which_on_everything_is_an_event(
    bench: Bench, hub: Hub, other: Hub
) -> None:
    control = bench.control(other)
    channel = hub.open_channel(bench.board, 0)
    channel.set_up(ChannelMode(8, 0, frames=False, events=(int(EventKind.INFO),)))
    running = []
    for turn in (control.stop, control.start):
        turn()
        running.append(channel.activate().running)
        channel.deactivate()
    assert running == [False, True]
    assert channel.activate() == hub.line_status(bench.board, 0)
    assert channel.receive_record() is None
    control.stop()
    told = channel.receive_any()
    assert isinstance(told, BusEvent)
    assert told.code == InfoCode.STOPPED


@pytest.mark.conforms("X3-19")
def test_what_waits_to_be_sent_stays_while_it_is_inactive(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    partner, channel = bench.channel(other, 1), hub.open_channel(bench.board, 0)
    channel.set_up(QUEUES)
    channel.send(Frame(1))
    assert identifiers(partner) == []
    assert (channel.status().pending, channel.status().sent) == (1, 1)
    channel.activate()
    assert identifiers(partner) == [1]
    channel.deactivate()
    channel.send(Frame(2))
    assert identifiers(partner) == []
    assert channel.cancel() == 1
    channel.activate()
    assert identifiers(partner) == []
    assert channel.status().aborted == 1


@pytest.mark.conforms("X4-38")
def test_a_channel_without_a_transmit_queue(bench: Bench, hub: Hub) -> None:
    channel = hub.open_channel(bench.board, 0)
    with pytest.raises(BadValue, match="capacity 0"):
        channel.set_up(ChannelMode(0, 10))
    channel.set_up(ChannelMode(10, 0))
    with pytest.raises(NotInitialised, match="no transmit queue"):
        channel.send(Frame(1))
    channel.activate()
    assert channel.status().active


@pytest.mark.parametrize(("exact", "sizes"), [(False, (16, 4)), (True, (10, 3))])
def test_queues_have_the_size_asked_for(bench: Bench, hub: Hub, exact: bool, sizes: tuple[int, int]) -> None:
    channel = hub.open_channel(bench.board, 0)
    channel.set_up(ChannelMode(10, 3, exact=exact))
    assert (channel.reading.ring.capacity, channel.writing.ring.capacity) == sizes
    for k in range(sizes[1]):
        channel.send(Frame(k))
    with pytest.raises(QueueFull, match=f"channel on line 0: transmit queue full, {sizes[1]} frames wait"):
        channel.send(Frame(1))


def test_set_up_anew_it_is_inactive_and_empty(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    channel.send(Frame(1))
    partner.send(Frame(2))
    hub.run_for(0.01)
    old = channel.reading
    channel.set_up(ChannelMode(8, 0))
    assert channel.reading is not old
    assert channel.receive() is None
    assert channel.status() == replace(channel.status(), active=False, accepted=0, sent=0, delivered=0)
    channel.activate()
    partner.send(Frame(3))
    assert identifiers(channel) == [3]


@pytest.mark.parametrize(
    ("mode", "error"),
    [
        (ChannelMode(0, 1), BadValue),
        (ChannelMode(-1, 1), BadValue),
        (ChannelMode(1, -1), BadValue),
        (ChannelMode((1 << 24) + 1, 1), BadValue),
        (ChannelMode(1, 1 << 40), BadValue),
        (ChannelMode(1, 1, filter_size=-1), BadFilter),
        (ChannelMode(1, 1, filter_size=1 << 40), BadFilter),
        (ChannelMode(1, 1, filter_mode=FilterMode.VOID), BadFilter),
    ],
)
def test_a_setup_that_is_refused_changes_nothing(
    bench: Bench, hub: Hub, other: Hub, mode: ChannelMode, error: type[Exception]
) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    with pytest.raises(error):
        channel.set_up(mode)
    assert channel.status().active
    channel.send(Frame(1))
    partner.send(Frame(2))
    assert identifiers(partner) == [1]
    assert identifiers(channel) == [2]


# frames


@pytest.mark.conforms("X3-20")
def test_reading_and_writing(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    frames = [Frame(k, bytes([k])) for k in range(5)] + [Frame(9, bytes(64), fd=True, bit_rate_switch=True)]
    for frame in frames:
        channel.send(frame)
    assert partner.receive_many(3, 1.0) == frames[:1]  # nothing but the first one is there yet
    hub.run_for(0.1)
    assert partner.receive() == frames[1]
    assert partner.receive_many(3) == frames[2:5]
    array = partner.receive_array()
    assert len(array) == 1
    assert array["id"].tolist() == [9]
    array["time_ns"] = 0
    assert channel.send_array(array) == 1
    assert partner.receive(1.0) == frames[5]
    assert partner.receive() is None
    assert partner.receive_many(5) == []
    assert partner.receive_record() is None
    status = channel.status()
    assert (status.sent, status.delivered, status.pending) == (7, 7, 0)


def test_waiting_ends_with_the_frame_and_not_later(bench: Bench, hub: Hub, other: Hub) -> None:
    """Blocking reads on a virtual hub advance it, as far as it takes."""
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    channel.send(Frame(0x555))
    frame = partner.receive(10.0)
    assert frame is not None
    assert frame.timestamp_ns == hub.now_ns()
    before_ns = hub.now_ns()
    assert partner.receive(0.25) is None
    assert hub.now_ns() - before_ns == 250_000_000
    assert partner.receive() is None
    assert hub.now_ns() - before_ns == 250_000_000


def test_waiting_for_room_ends_with_the_room(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel = bench.channel(hub, mode=ChannelMode(8, 2))
    for k in range(3):
        channel.send(Frame(k), timeout=0 if k < 2 else 1.0)
    first_ns = hub.now_ns()
    channel.send(Frame(3), timeout=1.0)
    assert hub.now_ns() - first_ns < 150_000  # a frame or so
    channel.writing.threshold = 2
    assert channel.writing.wait(1.0)
    assert channel.writing.ring.free() == 2


def test_waiting_for_ever_for_nothing_says_so(bench: Bench, hub: Hub) -> None:
    channel = bench.channel(hub)
    with pytest.raises(HubError, match="would never end"):
        channel.receive(None)
    event = Event()
    channel.reading.assign(event)
    with pytest.raises(HubError, match="would never end"):
        event.wait()
    assert hub.now_ns() == 0
    event.close()


def test_waiting_for_ever_for_something(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    channel.send(Frame(1))
    assert partner.receive(None) == Frame(1)
    assert hub.now_ns() < 10_000_000


@pytest.mark.conforms("PL-17")
def test_losses_are_counted_by_stage_and_shown_to_everybody(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1, CLASSIC)
    small = bench.channel(hub, mode=ChannelMode(2, 8))
    large, partner = bench.channel(hub), bench.channel(other, 1)
    for k in range(5):
        partner.send(Frame(k))
    partner.send(Frame(9, fd=True))  # line 1 is classic
    hub.run_for(0.1)
    assert (small.status().accepted, small.status().lost) == (5, 3)
    assert (large.status().accepted, large.status().lost) == (5, 0)
    assert (partner.status().refused, partner.status().sent) == (1, 6)
    line, other_line = (other.line_status(bench.board, number) for number in (0, 1))
    assert (line.lost, line.refused, other_line.lost, other_line.refused) == (3, 0, 0, 1)


def test_of_two_channels_alike_the_one_that_is_closed_goes(bench: Bench, hub: Hub, other: Hub) -> None:
    """Before they are set up they differ in nothing but their handles."""
    bench.control(hub)
    bench.control(other, 1)
    stays, goes = (hub.open_channel(bench.board, 0) for _ in range(2))
    goes.close()
    stays.set_up(ChannelMode(2, 8))
    stays.activate()
    partner = bench.channel(other, 1)
    for k in range(5):
        partner.send(Frame(k))
    hub.run_for(0.1)
    assert stays.status().lost == 3
    assert other.line_status(bench.board, 0).lost == 3


@pytest.mark.conforms("PL-17")
def test_a_client_that_forges_its_counters_harms_no_status(bench: Bench, hub: Hub, other: Hub) -> None:
    for _ in range(2):
        channel = bench.channel(hub)
        bench.link(hub).memory[channel.handle][0].cast("Q")[9] = 2**64 - 1  # the ring's count of losses
        assert channel.reading.ring.lost == 2**64 - 1
    assert other.line_status(bench.board, 0).lost == 0


@pytest.mark.conforms("PL-18")
def test_a_controller_s_health_is_readable(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    channel = bench.channel(hub)
    status = other.line_status(bench.board, 0)
    assert (status.state, status.tec, status.rec, status.last_error) == (ErrorState.ERROR_ACTIVE, 0, 0, 0)
    channel.send(Frame(1))
    hub.run_for(0.1)
    status = other.line_status(bench.board, 0)
    assert (status.state, status.tec, status.rec) == (ErrorState.ERROR_PASSIVE, 128, 0)
    assert status.last_error == ErrorKind.ACK
    assert status.transmitting
    assert status.errors > 16
    assert status.load > 5
    hub.short("can0")
    hub.run_for(0.1)
    status = other.line_status(bench.board, 0)
    assert (status.state, status.tec) == (ErrorState.BUS_OFF, 256)
    hub.short("can0", False)


@pytest.mark.conforms("PL-18")
def test_a_receiver_s_counter_too(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    sender = bench.channel(other, 1)
    Faults(bench.world.buses["can0"], seed=0).flip(bit="crc", times=3, seen_by="receivers")
    for k in range(2):
        sender.send(Frame(k, b"\x12\x34"))
    hub.run_for(0.1)
    status = hub.line_status(bench.board, 0)
    assert (status.errors, status.frames_received, status.tec) == (3, 2, 0)
    assert status.rec == 3 - 2
    assert status.last_error == ErrorKind.CRC
    assert other.line_status(bench.board, 1).frames_sent == 2


# shared by several programs


@pytest.mark.conforms("PL-13", "X4-26", "X4-27")
def test_programs_share_a_line_with_filters_stamps_and_echo_of_their_own(
    bench: Bench, hub: Hub, other: Hub
) -> None:
    bench.control(hub)
    third = bench.hub("third")
    bench.control(third, 1)
    wire = bench.channel(third, 1)
    mine = hub.open_channel(bench.board, 0)
    mine.set_up(replace(QUEUES, siblings=Siblings.OWN, filter_mode=FilterMode.INCLUSIVE))
    mine.set_acceptance(*NONE, extended=False)
    mine.add_ids(0x10 << 1, 0xFFF, extended=False)
    mine.activate()
    yours = other.open_channel(bench.board, 0)
    yours.set_up(replace(QUEUES, ticks=True, siblings=Siblings.AS_BUS))
    yours.activate()
    with pytest.raises(InUse, match=r"held by one \(100\)"):
        other.open_control(bench.board, 0)
    wire.send(Frame(0x10))
    wire.send(Frame(0x11))
    hub.run_for(0.01)
    mine.send(Frame(0x20), SELF_RECEPTION)
    mine.send(Frame(0x21))
    hub.run_for(0.01)
    yours.send(Frame(0x22), SELF_RECEPTION)
    hub.run_for(0.01)
    seen = [(frame.id, frame.self_received) for frame in mine.receive_many(20)]
    assert seen == [(0x10, False), (0x20, True)]
    frames = yours.receive_many(20)
    assert [(frame.id, frame.self_received) for frame in frames] == [
        (0x10, False), (0x11, False), (0x20, False), (0x22, True)
    ]  # fmt: skip
    assert all(frame.timestamp_ns < 100_000 for frame in frames)  # microseconds since the start
    assert [frame.id for frame in wire.receive_many(9)] == [0x20, 0x21, 0x22]


@pytest.mark.conforms("X3-25")
def test_delays_and_stamps_in_ticks_of_the_board(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = hub.open_channel(bench.board, 0), bench.channel(other, 1)
    channel.set_up(replace(QUEUES, ticks=True))
    channel.activate()
    capabilities = hub.boards()[0].lines[0].capabilities
    delay, longest = capabilities.delay, capabilities.delay.maximum
    for ticks in (0, 5, longest, longest + 1):
        assert channel.writing.ring.put_bytes(record_to_send(Frame(0x555), 0, ticks))
    hub.run_for(10)
    first, second, third = (frame.timestamp_ns for frame in partner.receive_many(9))
    frame_ns = 45 * FRAME_NS
    assert second - first == 5 * delay.tick_ns + frame_ns
    assert third - second == longest * delay.tick_ns + frame_ns
    assert channel.status().refused == 1


@pytest.mark.conforms("X4-30", "X4-31")
def test_events_go_to_channels_that_asked_for_them(bench: Bench, hub: Hub, other: Hub) -> None:
    kinds = tuple(EventKind)
    deaf = bench.channel(hub)
    channel = bench.channel(other, mode=ChannelMode(64, 0, events=kinds))
    late = other.open_channel(bench.board, 0)
    late.set_up(ChannelMode(64, 0, events=kinds))
    control = bench.control(hub)
    late.activate()
    control.stop()
    control.reset()
    told = [
        (event.kind, event.code if event.kind is EventKind.INFO else event.state)
        for event in read_all(channel)
    ]
    stopped = [
        (EventKind.INFO, InfoCode.STOPPED),
        (EventKind.STATE, ErrorState.STOPPED),
        (EventKind.CHANGED, ErrorState.STOPPED),
        (EventKind.INFO, InfoCode.RESET),
        (EventKind.CHANGED, ErrorState.STOPPED),
    ]
    assert told == [
        (EventKind.CHANGED, ErrorState.STOPPED),
        (EventKind.INFO, InfoCode.STARTED), (EventKind.STATE, ErrorState.ERROR_ACTIVE), *stopped
    ]  # fmt: skip
    later = read_all(late)
    assert [event.kind for event in later] == [kind for kind, _ in stopped]
    codes = [event.code for event in later if event.kind is not EventKind.STATE]
    assert codes == [InfoCode.STOPPED] * 2 + [InfoCode.RESET] * 2
    assert read_all(deaf) == []


# events to wait for


@pytest.mark.conforms("X4-13", "X3-22")
def test_a_reader_s_event_is_signalled_once_for_what_came_and_again_at_the_next_write(
    bench: Bench, hub: Hub, other: Hub
) -> None:
    """VCI V4 manual 4.1.1: threshold 1, ten queued, one read."""
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    event = Event()
    channel.reading.assign(event)
    for k in range(10):
        partner.send(Frame(k))
    hub.run_for(0.1)
    assert channel.reading.ring.fill() == 10
    assert event.wait(0)
    assert not event.wait(0)
    assert channel.receive() == Frame(0)
    assert not event.wait(0.1)
    partner.send(Frame(10))
    assert event.wait(0.1)
    assert not event.wait(0)
    event.close()


@pytest.mark.conforms("X3-22")
def test_thresholds_of_a_reader_and_a_writer(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1, ChannelMode(8, 4))
    come, room = Event(), Event(manual_reset=True)
    channel.reading.threshold = 3
    channel.reading.assign(come)
    partner.writing.threshold = 2
    partner.writing.assign(room)
    for k in range(4):
        partner.send(Frame(k))
    assert not room.is_set()
    assert come.wait(1)
    assert channel.reading.ring.fill() == 3
    assert room.is_set()
    room.reset()
    assert not room.is_set()
    channel.reading.threshold = 1000  # as much as there is room for
    assert channel.reading.threshold == 64
    channel.reading.assign(None)
    partner.send(Frame(9))
    hub.run_for(0.1)
    assert not come.is_set()
    for event in (come, room):
        event.close()


def test_an_event_that_is_assigned_later_hears_of_nothing_before(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    first, second = Event(), Event()
    channel.reading.assign(first)
    partner.send(Frame(1))
    hub.run_for(0.1)
    channel.reading.assign(second)
    assert not first.is_set()
    assert not second.wait(0.1)
    partner.send(Frame(2))
    assert second.wait(0.1)
    for event in (first, second):
        event.close()


# filters


@pytest.mark.conforms("X4-35", "X3-28")
@pytest.mark.parametrize("of", ["control", "channel"])
@pytest.mark.parametrize("extended", [False, True])
def test_filters_change_only_at_rest(bench: Bench, hub: Hub, of: str, extended: bool) -> None:
    held: Any = hub.open_control(bench.board, 0) if of == "control" else hub.open_channel(bench.board, 0)
    changes: list[Callable[[], object]] = [
        lambda: held.set_filter_mode(FilterMode.INCLUSIVE, extended=extended),
        lambda: held.set_acceptance(*NONE, extended=extended),
        lambda: held.add_ids(2, 0x3FFFFFFF, extended=extended),
        lambda: held.remove_ids(4, 0x3FFFFFFF, extended=extended),
    ]
    for change in [*changes, lambda: held.filter_mode(extended=extended)]:
        with pytest.raises(NotInitialised):
            change()
    begin, end = (held.start, held.stop) if of == "control" else (held.activate, held.deactivate)
    if of == "control":
        held.initialise(
            replace(
                FD, standard_filter=FilterSetup(FilterMode.PASS), extended_filter=FilterSetup(FilterMode.PASS)
            )
        )
    else:
        held.set_up(QUEUES)
    begin()
    for change in changes:
        with pytest.raises(WrongState, match="to change its filter"):
            change()
    assert held.filter_mode(extended=extended) == FilterMode.PASS
    end()
    assert held.set_filter_mode(FilterMode.EXCLUSIVE, extended=extended) == FilterMode.PASS
    assert held.set_filter_mode(FilterMode.LOCK, extended=extended) == FilterMode.EXCLUSIVE
    assert held.filter_mode(extended=not extended) == FilterMode.PASS
    for change in changes:
        change()
    begin()
    assert held.filter_mode(extended=extended) == FilterMode.INCLUSIVE


@pytest.mark.conforms("X4-34", "X4-35", "X3-26")
def test_the_line_s_filter_comes_before_the_channel_s(bench: Bench, hub: Hub, other: Hub) -> None:
    control = hub.open_control(bench.board, 0)
    control.initialise(FD)
    control.set_acceptance(0x100 << 1, 0xFF0 << 1 & 0xFFF, extended=False)  # 0x100..0x107, remote or not
    control.start()
    bench.control(other, 1)
    channel = hub.open_channel(bench.board, 0)
    channel.set_up(replace(QUEUES, filter_mode=FilterMode.EXCLUSIVE))
    channel.add_ids(0x102 << 1, 0xFFF, extended=False)
    channel.activate()
    hub.run_for(0.001)
    partner = bench.channel(other, 1)
    for id in (0xFF, 0x100, 0x102, 0x107, 0x110, 0x1000):
        partner.send(Frame(id, extended=id > 0x7FF))
    assert identifiers(channel) == [0x100, 0x107, 0x1000]


@pytest.mark.conforms("X3-28", "X3-14")
def test_a_reset_or_another_initialisation_opens_the_line_s_filter(
    bench: Bench, hub: Hub, other: Hub
) -> None:
    control = hub.open_control(bench.board, 0)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    for again in (control.reset, lambda: None):
        control.initialise(FD)
        control.set_acceptance(*NONE, extended=False)
        control.start()
        hub.run_for(0.001)
        partner.send(Frame(1))
        assert identifiers(channel) == []
        again()
        control.initialise(FD)
        control.start()
        hub.run_for(0.001)
        partner.send(Frame(2))
        assert identifiers(channel) == [2]


# the cyclic list


@pytest.mark.conforms("X3-29")
def test_a_line_has_one_cyclic_list(bench: Bench, hub: Hub, other: Hub) -> None:
    scheduler = hub.open_scheduler(bench.board, 0)
    assert hub.line_status(bench.board, 0).scheduler_holder == "one (100)"
    for another in (other, hub):
        with pytest.raises(InUse, match=r"its cyclic list is held by one \(100\)"):
            another.open_scheduler(bench.board, 0)
    other.open_scheduler(bench.board, 1)
    scheduler.close()
    assert hub.line_status(bench.board, 0).scheduler_holder == ""
    other.open_scheduler(bench.board, 0)


@pytest.mark.conforms("X3-29", "X4-15")
def test_a_board_without_one_says_so(bench: Bench, hub: Hub, monkeypatch: pytest.MonkeyPatch) -> None:
    usual = catalogue.KINDS["usb-to-can"]
    connector = usual.connectors[0]
    poor = replace(connector.capabilities, features=connector.capabilities.features & ~Feature.SCHEDULER)
    kind = replace(usual, name="poor", connectors=(connector._replace(capabilities=poor),))
    monkeypatch.setitem(catalogue.KINDS, "poor", kind)
    board = hub.plug("poor")
    with pytest.raises(Unsupported, match=rf"{board.hardware_id}:0 has no cyclic transmit list"):
        hub.open_scheduler(board.id, 0)
    assert hub.line_status(board.id, 0).scheduler_holder == ""


@pytest.mark.conforms("X3-29", "X3-33", "X4-41")
def test_its_frames_go_out_by_themselves(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    partner = bench.channel(other, 1)
    tick_ns = hub.boards()[0].lines[0].capabilities.cyclic.tick_ns
    scheduler = hub.open_scheduler(bench.board, 0)
    first = scheduler.add(record_to_send(Frame(1, b"\xff")), 10, increment=2, byte_index=0)
    second = scheduler.add(record_to_send(Frame(2)), 25)
    assert (first, second) == (0, 1)
    scheduler.start(first, 3)
    scheduler.start(second)
    hub.run_for(0.1)
    assert (scheduler.status().running, scheduler.status().states[:3]) == (False, (1, 1, 0))
    assert partner.receive() is None
    scheduler.resume()
    hub.run_for(60.5 * tick_ns / 1e9)
    got = [(frame.id, frame.data) for frame in partner.receive_many(50)]
    assert got == [(1, b"\xff"), (1, b"\x00"), (2, b""), (1, b"\x01"), (2, b"")]
    assert scheduler.status().states[:3] == (2, 1, 0)
    scheduler.stop(second)
    scheduler.remove(first)
    assert scheduler.status().states[:2] == (0, 2)
    scheduler.suspend()
    assert not scheduler.status().running
    scheduler.reset()
    assert (scheduler.status().states, scheduler.status().skipped) == ((0,) * 16, 0)


def test_a_list_that_is_closed_sends_nothing_more(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    partner = bench.channel(other, 1)
    scheduler = hub.open_scheduler(bench.board, 0)
    scheduler.start(scheduler.add(record_to_send(Frame(1)), 10))
    scheduler.resume()
    hub.run_for(0.1)
    assert partner.receive_many(1000)
    scheduler.close()
    hub.run_for(0.001)
    partner.receive_many(10)
    assert identifiers(partner, 1) == []


@pytest.mark.conforms("X4-17")
def test_a_cyclic_frame_obeys_the_line_s_mode(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub, 0, LineMode(NOMINAL, DATA, extended=False))
    bench.control(other, 1)
    partner = bench.channel(other, 1)
    scheduler = hub.open_scheduler(bench.board, 0)
    for frame, why in (
        (Frame(1, bytes(12), fd=True), "without more than 8 bytes"),
        (Frame(1, extended=True), "without 29-bit identifiers"),
    ):
        with pytest.raises(LineError, match=why):
            scheduler.add(record_to_send(frame), 10)
    index = scheduler.add(record_to_send(Frame(1, bytes(8), fd=True, bit_rate_switch=True)), 10)
    scheduler.start(index)
    scheduler.resume()
    hub.run_for(0.01)
    assert partner.receive() == Frame(1, bytes(8), fd=True, bit_rate_switch=True)


def test_a_list_made_before_the_line_was_set_up_is_checked_when_it_sends(
    bench: Bench, hub: Hub, other: Hub
) -> None:
    scheduler = hub.open_scheduler(bench.board, 0)
    scheduler.start(scheduler.add(record_to_send(Frame(1, extended=True)), 10))
    scheduler.resume()
    bench.control(hub, 0, LineMode(NOMINAL, extended=False))
    bench.control(other, 1)
    partner = bench.channel(other, 1)
    before = scheduler.status().skipped
    assert identifiers(partner) == []
    assert scheduler.status().skipped > before + 90


# layers


@pytest.mark.conforms("X3-05")
def test_programs_share_a_layer_and_two_layers_exclude_each_other(bench: Bench, hub: Hub, other: Hub) -> None:
    board = bench.board
    bal, again, third = (
        hub.open_layer(board, "BAL"),
        other.open_layer(board, "BAL"),
        hub.open_layer(board, "BAL"),
    )
    for each in (hub, other):
        with pytest.raises(InUse, match=r"HW000001: layer 'BAL' is open, by one \(100\)"):
            each.open_layer(board, "CAL")
    other.open_layer(hub.boards()[1].id, "CAL")  # another board
    bal.close()
    third.close()
    with pytest.raises(InUse, match=r"by other \(101\)"):
        hub.open_layer(board, "CAL")
    again.close()
    hub.open_layer(board, "CAL")


# finding a bit rate


@pytest.mark.conforms("X3-12", "X4-22", "X4-23")
def test_the_rate_of_a_running_bus(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub, 0, CLASSIC)
    bench.control(hub, 1, CLASSIC)
    talker = bench.channel(hub, mode=ChannelMode(8, 1024))
    for k in range(1000):
        talker.writing.ring.put_bytes(record_to_send(Frame(k), 0, 1_000_000))
    board = other.boards()[1].id
    control = other.open_control(board, 0)
    rates = [1_000_000, 250_000, 500_000, 125_000]
    table = [(BitTiming.for_bit_rate(rate, clock_hz=8_000_000), None) for rate in rates]
    assert control.detect(table, 100) == 2
    assert not control.status().initialised
    with pytest.raises(Unsupported, match="FAST_DATA"):
        control.detect([(NOMINAL, DATA)], 100)
    with pytest.raises(NothingHeard, match="no frame at any"):
        control.detect(table[:2], 100, low_speed=False)
    with pytest.raises(NothingHeard, match="rates: 125000"):  # quicker ones are passed over
        control.detect(table, 100, low_speed=True)
    control.initialise(LineMode(None))
    mode = control.status().mode
    assert mode is not None
    assert mode.timing is not None
    assert mode.timing.bit_rate == 500_000
    control.start()
    assert hub.line_status(bench.board, 0).errors == 0


@pytest.mark.conforms("X3-35")
@pytest.mark.parametrize("what", ["unplug", "reset", "die"])
def test_somebody_who_waits_for_an_answer_gets_one(bench: Bench, hub: Hub, other: Hub, what: str) -> None:
    control = hub.open_control(bench.board, 0)
    link = bench.link(hub)
    does: dict[str, Callable[[], object]] = {
        "unplug": lambda: other.unplug("HW000001"),
        "reset": lambda: link.session.handle(m.Reset(control.handle)),
        "die": link.die,
    }
    link.on_wait = does[what]
    expected: type[Exception] = Unplugged if what == "unplug" else NothingHeard
    with pytest.raises(expected):
        control.detect([(NOMINAL, None)], 1000)
    assert len(bench.world.buses["can0"].nodes) == (2 if what == "unplug" else 4)


@pytest.mark.conforms("X3-13")
def test_a_stop_is_answered_when_the_frame_is_over(bench: Bench, hub: Hub, other: Hub) -> None:
    control = bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    channel.send(Frame(1, bytes(8)))
    channel.send(Frame(2))
    hub.run_for(50e-6)
    control.stop()
    frame = partner.receive()
    assert frame is not None
    assert frame.id == 1
    assert 0 <= hub.now_ns() - frame.timestamp_ns <= 4 * FRAME_NS
    assert (channel.status().delivered, channel.status().pending) == (1, 1)


# FIFOs


@pytest.mark.conforms("X4-08")
def test_a_fifo_fills_whole_pages(hub: Hub, other: Hub) -> None:
    made = hub.create_fifo(32, 16)
    assert (made.capacity, made.element_size, made.role) == (254, 16, "fifo")
    assert other.open_fifo(made.id, "fifo").capacity == 254


@pytest.mark.conforms("X4-08", "X4-09", "X3-21")
def test_two_programs_exchange_elements(hub: Hub, other: Hub) -> None:
    made = hub.create_fifo(4, 5)
    reader, writer = hub.open_fifo(made.id, "reader"), other.open_fifo(made.id, "writer")
    there, back = reader.end_of_ring.ring, writer.end_of_ring.ring
    for each in (b"one  ", b"two  ", b"three"):
        assert back.put_bytes(each)
    assert made.end_of_ring.ring.fill() == 3
    assert [there.take_bytes() for _ in range(4)] == [b"one  ", b"two  ", b"three", None]
    with pytest.raises(BadValue, match="5 bytes"):
        back.put_bytes(b"four")
    for _ in range(made.capacity):
        assert back.put_bytes(b"12345")
    assert not back.put_bytes(b"54321")  # the new element is the one that is dropped
    assert there.lost == 1


@pytest.mark.conforms("X4-09", "X3-21")
@pytest.mark.parametrize("role", ["reader", "writer"])
def test_each_end_is_open_once(hub: Hub, other: Hub, role: str) -> None:
    made = hub.create_fifo(4, 8)
    end = other.open_fifo(made.id, role)
    for each in (hub, other):
        with pytest.raises(InUse, match=f"FIFO {made.id}: its {role} is open already"):
            each.open_fifo(made.id, role)
    end.close()
    end.close()
    hub.open_fifo(made.id, role)


@pytest.mark.conforms("X4-12")
def test_reset_is_refused_while_an_end_is_open(hub: Hub, other: Hub) -> None:
    made = hub.create_fifo(4, 8)
    looking = other.open_fifo(made.id, "fifo")
    writer = hub.open_fifo(made.id, "writer")
    writer.end_of_ring.ring.put_bytes(bytes(8))
    reader = other.open_fifo(made.id, "reader")
    with pytest.raises(WrongState, match="its reader and writer is open"):
        looking.reset()
    reader.close()
    for each in (made, looking, writer):
        with pytest.raises(WrongState, match="its writer is open"):
            each.reset()
    assert made.end_of_ring.ring.fill() == 1
    writer.close()
    looking.reset()
    assert made.end_of_ring.ring.fill() == 0


@pytest.mark.conforms("X4-08")
@pytest.mark.parametrize("last", ["fifo", "reader", "writer"])
def test_a_fifo_goes_with_the_last_reference(hub: Hub, other: Hub, bench: Bench, last: str) -> None:
    made = hub.create_fifo(4, 8)
    number = made.id
    held = other.open_fifo(number, last)
    made.close()
    other.open_fifo(number, "fifo").close()
    held.close()
    with pytest.raises(NoSuchBoard, match=f"no FIFO {number}"):
        hub.open_fifo(number, "fifo")
    assert hub.create_fifo(4, 8).id != number


@pytest.mark.conforms("X4-08")
def test_a_program_that_dies_leaves_its_end_to_others(bench: Bench, hub: Hub, other: Hub) -> None:
    made = hub.create_fifo(4, 8)
    other.open_fifo(made.id, "writer").end_of_ring.ring.put_bytes(b"lasting!")
    bench.link(other).die()
    reader, writer = hub.open_fifo(made.id, "reader"), hub.open_fifo(made.id, "writer")
    assert reader.end_of_ring.ring.take_bytes() == b"lasting!"
    assert writer.end_of_ring.ring.put_bytes(b"and more")


@pytest.mark.conforms("X4-13", "X3-22")
def test_the_ends_of_a_fifo_signal_each_other(hub: Hub, other: Hub) -> None:
    made = hub.create_fifo(1, 4000)
    reader, writer = hub.open_fifo(made.id, "reader"), other.open_fifo(made.id, "writer")
    come, room = Event(), Event()
    reader.end_of_ring.assign(come)
    assert made.capacity == 1
    assert not come.is_set()
    writer.end_of_ring.ring.put_bytes(bytes(4000))
    writer.end_of_ring.assign(room)
    assert come.is_set()
    assert not room.is_set()
    assert come.wait(0)
    reader.end_of_ring.ring.take_bytes()
    reader.end_of_ring.touched()
    assert room.wait(0)
    assert not come.is_set()
    for event in (come, room):
        event.close()


# numbers


def test_every_number_is_given_once(hub: Hub, other: Hub) -> None:
    numbers = [each.create_luid() for each in (hub, other) * 5]
    boards = [board.id for board in hub.boards()]
    assert len({*numbers, *boards, hub.create_fifo(1, 1).id}) == len(numbers) + len(boards) + 1


# handles that mean nothing


HANDLED: list[Callable[[int], m.Message]] = [
    m.Close,
    m.Start,
    m.Stop,
    m.Reset,
    m.GetChannelStatus,
    m.CancelQueued,
    m.ResetScheduler,
    m.GetSchedulerStatus,
    m.ResetFifo,
    lambda handle: m.Initialise(handle, CLASSIC),
    lambda handle: m.Detect(handle, ((NOMINAL, None),), 10, True, False),
    lambda handle: m.GetFilterMode(handle, False),
    lambda handle: m.SetFilterMode(handle, False, 2),
    lambda handle: m.SetAcceptanceFilter(handle, False, 0, 0),
    lambda handle: m.ListIds(handle, False, 0, 0xFFF, True),
    lambda handle: m.ReplaceFilters(handle, FilterContent(), FilterContent(FilterMode.LOCK)),
    lambda handle: m.CountRefused(handle, 1),
    lambda handle: m.SetUpChannel(handle, QUEUES),
    lambda handle: m.Activate(handle, True),
    lambda handle: m.AddCyclic(handle, bytes(80), 1, 0, 0),
    lambda handle: m.RemoveCyclic(handle, 0),
    lambda handle: m.StartCyclic(handle, 0, 0),
    lambda handle: m.StartInTurn(handle, (0,), (0,), 1),
    lambda handle: m.ReplaceCyclic(handle, 0, bytes(80)),
    lambda handle: m.StopCyclic(handle, 0),
    lambda handle: m.RunScheduler(handle, True),
]  # fmt: skip
NEEDS = {  # what a handle must be for each of them; filters belong to both of the first two
    "control": {m.Start, m.Stop, m.Reset, m.Initialise, m.Detect},
    "channel": {m.GetChannelStatus, m.CancelQueued, m.SetUpChannel, m.Activate, m.ReplaceFilters,
                m.CountRefused},
    "scheduler": {m.ResetScheduler, m.GetSchedulerStatus, m.AddCyclic, m.RemoveCyclic, m.StartCyclic, m.StopCyclic,
                  m.RunScheduler, m.ReplaceCyclic, m.StartInTurn},
    "fifo": {m.ResetFifo},
    "layer": set(),
}  # fmt: skip
FILTERS = {m.GetFilterMode, m.SetFilterMode, m.SetAcceptanceFilter, m.ListIds}


WITH_HANDLES = (m.__name__, m.ReplaceFilters.__module__, m.AddCyclic.__module__, m.ResetFifo.__module__)


def named(build: Callable[[int], m.Message]) -> str:
    return type(build(1)).__name__


def facts(bench: Bench) -> object:
    """What a request could have changed."""
    world = bench.world
    lines = [slot.status() for slot in world.slots.values() if isinstance(slot, CanSlot)]
    held = [sorted(session._held) for session in world.sessions]
    return world.infos(), lines, held, sorted(world.pipes._pipes)


def test_every_request_with_a_handle_is_here() -> None:
    """But for those of LIN, in hub/protocol/lin_messages.py."""
    kinds = [kind for kind in m.Request.__args__ if kind.__module__ in WITH_HANDLES]
    with_handle = {kind for kind in kinds if "handle" in kind.__struct_fields__}
    assert {type(build(1)) for build in HANDLED} == with_handle
    assert with_handle == set().union(*NEEDS.values()) | FILTERS | {m.Close}


@pytest.mark.parametrize("build", HANDLED, ids=named)
@pytest.mark.parametrize("which", ["zero", "negative", "unknown", "huge", "somebody else's", "closed"])
def test_a_handle_that_is_none(
    bench: Bench, hub: Hub, other: Hub, build: Callable[[int], m.Message], which: str
) -> None:
    bench.channel(other)
    theirs = [other.open_control(bench.board, 0), other.open_scheduler(bench.board, 0)][-1].handle
    closed = hub.open_control(bench.board, 1)
    closed.close()
    handle = {
        "zero": 0,
        "negative": -1,
        "unknown": 4711,
        "huge": 2**63 - 1,
        "somebody else's": theirs,
        "closed": closed.handle,
    }[which]
    before = facts(bench)
    with pytest.raises(NoSuchBoard, match=rf"handle {handle} is no .* of one \(100\)"):
        hub.call(build(handle))
    assert facts(bench) == before


WRONG = [
    pytest.param(build, kind, id=f"{named(build)} {kind}")
    for build in HANDLED[1:]
    for kind, right in NEEDS.items()
    if type(build(1)) not in (right | FILTERS if kind in ("control", "channel") else right)
]


@pytest.mark.parametrize(("build", "kind"), WRONG)
def test_a_handle_of_another_kind(
    bench: Bench, hub: Hub, build: Callable[[int], m.Message], kind: str
) -> None:
    lease: Any = {
        "control": lambda: hub.open_control(bench.board, 0),
        "channel": lambda: bench.channel(hub),
        "scheduler": lambda: hub.open_scheduler(bench.board, 0),
        "fifo": lambda: hub.create_fifo(1, 1),
        "layer": lambda: hub.open_layer(bench.board, "BAL"),
    }[kind]()
    before = facts(bench)
    with pytest.raises(NoSuchBoard, match=f"handle {lease.handle} is (no|neither) "):
        hub.call(build(lease.handle))
    assert facts(bench) == before


@pytest.mark.conforms("X3-35")
@pytest.mark.parametrize("build", HANDLED[1:], ids=named)
def test_a_handle_whose_board_is_gone(bench: Bench, hub: Hub, build: Callable[[int], m.Message]) -> None:
    held: list[Any] = [
        hub.open_control(bench.board, 0),
        bench.channel(hub),
        hub.open_scheduler(bench.board, 0),
        hub.open_layer(bench.board, "BAL"),
    ]
    hub.unplug("HW000001")
    if type(build(1)) is not m.ResetFifo:
        for lease in held:
            with pytest.raises(Unplugged, match=r"HW000001 \(usb-to-can-fd\) was unplugged"):
                hub.call(build(lease.handle))
    for lease in held:
        hub.call(m.Close(lease.handle))
        with pytest.raises(NoSuchBoard):
            hub.call(m.Close(lease.handle))


# bad input of every request that has no handle, or a good one


@pytest.mark.parametrize(
    ("request_", "error", "text"),
    [
        (m.Plug("toaster", "", ()), NoSuchBoard, "no board kind 'toaster'"),
        (m.Plug("usb-to-can", "HW000001", ()), BadValue, "HW000001 is plugged in already"),
        (m.Plug("usb-to-can", "no serial", ()), BadValue, "hardware id 'no serial'"),
        (m.Plug("usb-to-can", "HW" + "9" * 60_000, ()), BadValue, "hardware id"),
        (m.Plug("usb-to-can", "", ("can0",)), BadValue, "has 2 lines, not 1"),
        (m.Plug("usb-to-can", "", ("can0", "can9")), NoSuchBoard, "no bus 'can9'"),
        (m.Unplug("HW999999"), NoSuchBoard, "no board 'HW999999' to unplug; plugged in: HW000001, HW000002"),
        (m.Unplug(""), NoSuchBoard, "no board ''"),
        (m.OpenLayer(99, "BAL"), NoSuchBoard, "no board with id 99"),
        (m.OpenControl(99, 0), NoSuchBoard, "no board with id 99"),
        (m.OpenControl(-1, 0), NoSuchBoard, "no board with id -1"),
        (m.OpenChannel(99, 0, False), NoSuchBoard, "no board with id 99"),
        (m.OpenScheduler(99, 0), NoSuchBoard, "no board with id 99"),
        (m.GetLineStatus(99, 0), NoSuchBoard, "no board with id 99"),
        (m.CreateFifo(0, 1), BadValue, "FIFO capacity 0: 1 to 65535"),
        (m.CreateFifo(1, 0), BadValue, "FIFO element size 0: 1 to 65535"),
        (m.CreateFifo(65536, 1), BadValue, "FIFO capacity 65536"),
        (m.CreateFifo(1, 1 << 40), BadValue, "FIFO element size"),
        (m.CreateFifo(-5, 1), BadValue, "FIFO capacity -5"),
        (m.OpenFifo(99, "reader"), NoSuchBoard, "no FIFO 99"),
        (m.Disturb("can9", True), NoSuchBoard, "no bus 'can9'; there are can0"),
        (m.Hello(1, 2, "again"), BadMessage, "Hello is no request for a session"),
    ],
)
def test_requests_that_make_no_sense(
    bench: Bench, hub: Hub, request_: m.Message, error: type[CanwireError], text: str
) -> None:
    before = facts(bench)
    with pytest.raises(error, match=text):
        hub.call(request_)
    assert facts(bench) == before


@pytest.mark.parametrize("line", [9, -1, 1 << 40])
def test_a_line_that_a_board_does_not_have(bench: Bench, hub: Hub, line: int) -> None:
    for call in (hub.open_control, hub.open_channel, hub.open_scheduler, hub.line_status):
        with pytest.raises(NoSuchBoard, match=rf"HW000001 has lines 0 to \d, not {line}"):
            call(bench.board, line)


def test_a_role_that_a_fifo_does_not_have(hub: Hub) -> None:
    made = hub.create_fifo(1, 1)
    with pytest.raises(BadValue, match="role 'owner' of a FIFO"):
        hub.open_fifo(made.id, "owner")


@pytest.mark.parametrize(
    "mode",
    [
        LineMode(NOMINAL, standard=False, extended=False),
        LineMode(NOMINAL, low_speed=True),
        LineMode(NOMINAL, timeout_ms=-1),
        LineMode(None, DATA),
        LineMode(BitTiming(65536, 65536, 65536, 1, clock_hz=1)),
        LineMode(NOMINAL, BitTiming(1, 1, 1, 1, clock_hz=10**10)),
        LineMode(NOMINAL, standard_filter=FilterSetup(FilterMode.VOID)),
        LineMode(NOMINAL, extended_filter=FilterSetup(FilterMode.INCLUSIVE, 1 << 30)),
    ],
)
def test_line_modes_that_make_no_sense(bench: Bench, hub: Hub, mode: LineMode) -> None:
    control = bench.control(hub)
    before = facts(bench)
    with pytest.raises(CanwireError):
        control.initialise(mode)
    assert facts(bench) == before


@pytest.mark.parametrize(
    ("candidates", "timeout_ms", "error"),
    [
        ([], 10, BadValue),
        ([(NOMINAL, None)], -1, BadValue),
        ([(NOMINAL, None)], 2**63 - 1, BadValue),
        ([(BitTiming(65536, 65536, 65536, 1, clock_hz=1), None)], 10, BadTiming),
    ],
)
def test_searches_that_make_no_sense(
    bench: Bench, hub: Hub, candidates: list[Any], timeout_ms: int, error: type[CanwireError]
) -> None:
    control = hub.open_control(bench.board, 0)
    with pytest.raises(error):
        control.detect(candidates, timeout_ms)
    with pytest.raises(NothingHeard):
        control.detect([(NOMINAL, None)], 10)


@pytest.mark.parametrize("of", ["control", "channel"])
def test_filters_that_make_no_sense(bench: Bench, hub: Hub, of: str) -> None:
    held: Any
    if of == "control":
        held = hub.open_control(bench.board, 0)
        held.initialise(FD)
    else:
        held = hub.open_channel(bench.board, 0)
        held.set_up(replace(QUEUES, filter_mode=FilterMode.INCLUSIVE))
    for extended in (False, True):
        for mode in (0, 5, -1, 0x80, 1 << 40):
            with pytest.raises(BadFilter, match=f"filter mode {mode}"):
                held.set_filter_mode(mode, extended=extended)
        for code, mask in ((-1, 0), (0, -1), (1 << 32, 0), (0, 1 << 40)):
            for call in (held.set_acceptance, held.add_ids, held.remove_ids):
                with pytest.raises(BadFilter, match="32 bits"):
                    call(code, mask, extended=extended)
        assert held.filter_mode(extended=extended) == FilterMode.INCLUSIVE
    with pytest.raises(BadFilter, match="the list holds 4096"):
        held.add_ids(0, 0, extended=True)


def test_a_channel_without_lists_has_no_list(bench: Bench, hub: Hub) -> None:
    channel = hub.open_channel(bench.board, 0)
    channel.set_up(replace(QUEUES, filter_size=0))
    with pytest.raises(NotInitialised, match="without a list"):
        channel.add_ids(2, 0xFFF, extended=False)


@pytest.mark.parametrize(
    ("record", "cycle", "increment", "byte_index", "error"),
    [
        (b"", 1, 0, 0, BadFrame),
        (bytes(79), 1, 0, 0, BadFrame),
        (bytes(60_000), 1, 0, 0, BadFrame),
        (b"\xff" * 80, 1, 0, 0, BadFrame),
        (bytes(8) + b"\x00\x08" + bytes(70), 1, 0, 0, BadFrame),  # 0x800 in 11 bits
        (bytes(12) + b"\x02" + bytes(67), 1, 0, 0, BadFrame),  # an error message
        (bytes(80), 0, 0, 0, BadValue),
        (bytes(80), -1, 0, 0, BadValue),
        (bytes(80), 1 << 40, 0, 0, BadValue),
        (bytes(80), 1, 4, 0, BadValue),
        (bytes(80), 1, -1, 0, BadValue),
        (bytes(80), 1, 2, 0, BadValue),  # no byte to grow
        (record_to_send(Frame(1, b"ab")), 1, 2, 2, BadValue),
        (record_to_send(Frame(1, b"ab")), 1, 3, 1, BadValue),
        (record_to_send(Frame(1, b"ab")), 1, 2, -1, BadValue),
    ],
)
def test_cyclic_objects_that_make_no_sense(
    bench: Bench,
    hub: Hub,
    record: bytes,
    cycle: int,
    increment: int,
    byte_index: int,
    error: type[CanwireError],
) -> None:
    scheduler = hub.open_scheduler(bench.board, 0)
    with pytest.raises(error):
        scheduler.add(record, cycle, increment=increment, byte_index=byte_index)
    assert scheduler.add(bytes(80), 1) == 0


def test_a_cyclic_object_keeps_only_requests_that_it_may_have(bench: Bench, hub: Hub) -> None:
    scheduler = hub.open_scheduler(bench.board, 0)
    assert scheduler.add(record_to_send(Frame(1), CONFIRM | SELF_RECEPTION), 10) == 0


def test_indices_that_make_no_sense(bench: Bench, hub: Hub) -> None:
    scheduler = hub.open_scheduler(bench.board, 0)
    for index in (0, -1, 16, 1 << 40):
        for call in (scheduler.start, scheduler.stop, scheduler.remove):
            with pytest.raises(BadValue, match=f"nothing at index {index}"):
                call(index)
    scheduler.add(bytes(80), 10)
    for count in (-1, 65536, 1 << 40):
        with pytest.raises(BadValue, match=f"count {count}"):
            scheduler.start(0, count)
    assert scheduler.status().states == (0,) * 16


@pytest.mark.parametrize("span", [0, -1, -(2**63)])
def test_time_goes_one_way(hub: Hub, span: int) -> None:
    hub.run_for(0.5)
    assert hub.call(m.Advance(span)).value == 500_000_000


# leases as the client sees them


@pytest.mark.parametrize("what", ["control", "channel", "scheduler", "layer", "fifo"])
def test_what_is_closed_is_closed(bench: Bench, hub: Hub, what: str) -> None:
    lease, use = leased(bench, hub, what)
    lease.close()
    lease.close()
    for call in (use, lease.check):
        with pytest.raises(Closed):
            call()
    assert lease.over


@pytest.mark.conforms("X3-35")
@pytest.mark.parametrize("what", ["control", "channel", "scheduler", "layer"])
def test_what_was_unplugged_says_so_at_every_use(bench: Bench, hub: Hub, other: Hub, what: str) -> None:
    lease, use = leased(bench, hub, what)
    other.unplug("HW000001")
    for call in (use, lease.check):
        with pytest.raises(Unplugged, match=r"board HW000001 \(usb-to-can-fd\) was unplugged"):
            call()
    assert lease.over
    lease.close()
    with pytest.raises(Closed):
        use()


@pytest.mark.parametrize("what", ["control", "channel", "scheduler", "layer", "fifo"])
def test_what_outlives_the_hub_says_so(bench: Bench, hub: Hub, what: str) -> None:
    lease, use = leased(bench, hub, what)
    bench.link(hub).vanish()
    for call in (use, lease.check):
        with pytest.raises(HubLost):
            call()
    assert lease.over
    lease.close()


def leased(bench: Bench, hub: Hub, what: str) -> tuple[Any, Callable[[], object]]:
    """A lease, and something that it is good for."""
    if what == "control":
        control = hub.open_control(bench.board, 0)
        return control, lambda: control.initialise(CLASSIC)
    if what == "channel":
        channel = bench.channel(hub)
        return channel, channel.receive
    if what == "scheduler":
        scheduler = hub.open_scheduler(bench.board, 0)
        return scheduler, scheduler.status
    if what == "layer":
        layer = hub.open_layer(bench.board, "BAL")
        return layer, layer.check
    fifo = hub.create_fifo(1, 1)
    return fifo, fifo.reset


def test_what_came_before_the_end_can_still_be_read(bench: Bench, hub: Hub, other: Hub) -> None:
    bench.control(hub)
    bench.control(other, 1)
    channel, partner = bench.channel(hub), bench.channel(other, 1)
    partner.send(Frame(1))
    hub.run_for(0.01)
    other.unplug("HW000001")
    assert channel.receive() == Frame(1)
    with pytest.raises(Unplugged):
        channel.receive()
    with pytest.raises(Unplugged):
        channel.receive(1.0)
    with pytest.raises(Unplugged):
        channel.send(Frame(1))


def test_a_closed_hub_raises_and_closes_twice(bench: Bench, hub: Hub) -> None:
    channel = bench.channel(hub)
    hub.close()
    hub.close()
    assert hub.lost
    with pytest.raises(HubLost, match="was closed"):
        hub.boards()
    with pytest.raises(Closed):
        channel.receive()


def test_a_channel_that_is_not_set_up_has_counted_nothing(hub: Hub) -> None:
    with hub.open_channel(hub.boards()[0].id, 0) as channel:
        assert channel.status() == ChannelStatus(False, 0, 0, 0, 0, 0, 0, 0)


def test_an_event_has_the_clock_of_what_it_is_assigned_to(bench: Bench, hub: Hub) -> None:
    channel = bench.channel(hub)
    hub.run_for(1.5)
    with closing(Event()) as event:
        channel.reading.assign(event)
        assert event.clock_s() == hub.clock_s() == 1.5
