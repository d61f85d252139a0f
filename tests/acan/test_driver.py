"""The driver on real hubs, from application to application. Source: INduCAN104 manual."""

from __future__ import annotations

import threading
from typing import Any

import pytest

import canwire
from canwire import (
    BadFrame,
    BadTiming,
    BadValue,
    Closed,
    Frame,
    Hub,
    InUse,
    NotInitialised,
    QueueFull,
    Unplugged,
)
from canwire.acan import service
from canwire.acan.constants import Action, BlockStatus, Condition
from canwire.acan.driver import Driver, open_driver
from canwire.acan.filters import Filter
from canwire.acan.hard_config import HardConfig
from canwire.acan.identifiers import acan_word
from canwire.acan.install import DriverAbsent
from canwire.acan.task_block import TaskBlock
from tests.acan.bench import Arrived, Peer, Virtual
from tests.hubs import Connect

ALL = (Filter.any(),)
LONG = 30  # seconds after which something that should happen never will


@pytest.mark.conforms("AC-07", "AC-09", "AC-10")
def test_a_driver_begins_off_the_bus(driver: Driver) -> None:
    assert driver.version == (1, 0)
    assert driver.controller == 0
    assert not driver.initialised
    assert not driver.on_bus
    assert driver.config() is None
    with pytest.raises(NotInitialised):
        driver.bus_on()
    assert driver.bus_off() is False


@pytest.mark.conforms("AC-14", "AC-15", "AC-16")
def test_configuring_leaves_the_bus_and_bus_control_tells_the_state_before(driver: Driver) -> None:
    config = HardConfig(machine_id=3 << 18, machine_mask=7 << 18, broadcast_mask=7 << 18)
    driver.configure(config)
    assert (driver.initialised, driver.on_bus, driver.config()) == (True, False, config)
    assert driver.bus_on() is False
    assert driver.bus_on() is True
    assert driver.on_bus
    driver.configure(HardConfig(rate_kbps=500))
    assert not driver.on_bus
    assert driver.config() == HardConfig(rate_kbps=500)
    driver.bus_on()
    assert driver.bus_off() is True
    assert driver.bus_off() is False


@pytest.mark.conforms("AC-14", "AC-15")
def test_the_configuration_is_every_programs_and_outlives_the_one_that_made_it(
    hub: canwire.Hub, connect: Connect, second: Driver
) -> None:
    config = HardConfig(rate_kbps=125, interrupts=0xFF)
    with open_driver(hub) as first:
        first.configure(config)
        first.bus_on()
        assert second.config() == config
    assert second.initialised
    assert second.on_bus
    assert second.bus_off() is True


@pytest.mark.conforms("AC-11", "AC-13", "AC-19")
def test_the_chip_is_programmed_as_the_manual_says(virtual: Virtual) -> None:
    machine, broadcast = 5 << 18, 7 << 18
    config = HardConfig(machine, broadcast, 0, broadcast, 16_000, 250, 11, 5, 3, 1, 0x6A, 0)
    virtual.driver.configure(config)
    registers = virtual.registers()
    assert {name: registers[name] for name, _ in config.registers()} == dict(config.registers())
    assert (registers["OCR"], registers["IER"]) == (0x6A, 0b10101101)
    assert registers["BTR0"] & 0x3F == 1
    virtual.driver.configure(HardConfig(output_control=0xFA, interrupts=0xFF))
    virtual.driver.bus_on()
    registers = virtual.registers()
    assert (registers["OCR"], registers["IER"]) == (0xFA, 0xFF)


@pytest.mark.conforms("AC-11")
def test_what_the_controller_cannot_do_never_reaches_it(driver: Driver) -> None:
    with pytest.raises(BadTiming):
        driver.configure(HardConfig(rate_kbps=1))
    assert not driver.initialised


@pytest.mark.conforms("AC-17", "AC-20", "AC-21")
def test_frames_go_both_ways_and_reach_every_block_that_wants_them(
    running: Driver, peer: Peer, arrived: Arrived
) -> None:
    blocks = [TaskBlock(ALL), TaskBlock([Filter.one(0x101)]), TaskBlock([Filter.one(0x102)])]
    for block in blocks:
        running.register(block)
    frames = [Frame(0x100, b"a"), Frame(0x101), Frame(0x1234567, b"12345678", extended=True)]
    frames.append(Frame(0x102, remote=True, dlc=5))
    peer.send(*frames)
    assert arrived(blocks[0], 4) == frames
    assert arrived(blocks[1], 1) == [frames[1]]
    assert arrived(blocks[2], 1) == [frames[3]]
    for frame in frames:
        running.send(frame)
    assert peer.received(4) == frames


@pytest.mark.conforms("AC-21")
def test_a_frame_reaches_several_programs(
    running: Driver, second: Driver, peer: Peer, arrived: Arrived
) -> None:
    blocks = [running.register(TaskBlock(ALL)), second.register(TaskBlock(ALL))]
    peer.send(Frame(5))
    assert [arrived(block, 1) for block in blocks] == [[Frame(5)], [Frame(5)]]


@pytest.mark.conforms("AC-19")
def test_the_hardware_filter_lets_machine_and_broadcast_through(
    driver: Driver, peer: Peer, arrived: Arrived
) -> None:
    driver.configure(
        HardConfig(machine_id=acan_word(3), machine_mask=acan_word(7), broadcast_mask=acan_word(7))
    )
    driver.bus_on()
    block = driver.register(TaskBlock(ALL))
    peer.send(*(Frame(0x48 | machine, bytes([machine])) for machine in (1, 3, 5, 0, 7, 3)))
    assert [frame.id & 7 for frame in arrived(block, 3)] == [3, 0, 3]


@pytest.mark.conforms("AC-23")
def test_a_channel_is_written_without_its_application(running: Driver, peer: Peer, arrived: Arrived) -> None:
    variable, done = bytearray(4), TaskBlock(ALL)
    running.register(TaskBlock([Filter.one(0x20, actions=Action.CHANRCV, variable=variable)]))
    running.register(done)
    peer.send(Frame(0x20, b"abcdefgh"), Frame(0x20, b"X"))
    arrived(done, 2)
    assert variable == b"Xbcd"


def fill(driver: Driver) -> None:
    while True:
        driver.send(Frame(1))


def request(id: int, length: int = 8, extended: bool = False) -> bytes:
    return acan_word(id, extended).to_bytes(4, "little") + bytes([0x80 * extended, length])


@pytest.mark.conforms("AC-24")
def test_a_channel_answers_where_the_request_says(running: Driver, peer: Peer) -> None:
    variable = bytearray(b"value")
    running.register(TaskBlock([Filter.one(0x20, actions=Action.CHANSND, variable=variable)]))
    peer.send(Frame(0x20, request(0x300)))
    assert peer.receive() == Frame(0x300, b"value")
    variable[:] = b"other"
    peer.send(Frame(0x20, request(0x1FEDCBA, 3, extended=True)))
    assert peer.receive() == Frame(0x1FEDCBA, b"oth", extended=True)


@pytest.mark.conforms("AC-24")
def test_an_answer_may_address_a_channel_on_this_machine(running: Driver, second: Driver, peer: Peer) -> None:
    source, here, there = bytearray(b"12345678"), bytearray(8), bytearray(8)
    running.register(TaskBlock([Filter.one(0x20, actions=Action.CHANSND, variable=source)]))
    notified = Action.CHANRCV | Action.NOTIFY
    mine = running.register(TaskBlock([Filter.one(0x21, actions=notified, variable=here)]))
    other = second.register(TaskBlock([Filter.one(0x21, actions=notified, variable=there)]))
    peer.send(Frame(0x20, request(0x21)))
    assert peer.receive() == Frame(0x21, bytes(source))
    assert mine.wait(LONG)
    assert other.wait(LONG)
    assert (here, there) == (source, source)


@pytest.mark.conforms("AC-32")
def test_priority_0_is_heard_at_home_too(
    running: Driver, second: Driver, peer: Peer, arrived: Arrived
) -> None:
    blocks = [running.register(TaskBlock(ALL)), second.register(TaskBlock(ALL))]
    running.send(Frame(0x10, b"quiet"), 1)
    running.send(Frame(0x11, b"loud"), 0)
    assert sorted(frame.id for frame in peer.received(2)) == [0x10, 0x11]
    for block in blocks:
        assert arrived(block, 1) == [Frame(0x11, b"loud")]
        assert block.occupation == 0


@pytest.mark.conforms("AC-31")
@pytest.mark.parametrize("priority", [-1, 256, 1.5])
def test_other_priorities_are_refused(driver: Driver, priority: Any) -> None:
    with pytest.raises(BadValue, match="bPrio"):
        driver.send(Frame(1), priority)
    with pytest.raises(BadFrame, match="classic"):
        driver.send(Frame(1, bytes(12), fd=True))


@pytest.mark.conforms("AC-31")
def test_what_is_queued_goes_by_priority_first_come_first_served(virtual: Virtual) -> None:
    peer = virtual.peer()
    virtual.driver.send(Frame(0x7FF))
    virtual.hub.run_for(0.00001)
    for number, priority in enumerate((200, 5, 255, 5, 0, 1, 200, 0)):
        virtual.driver.send(Frame(0x700 - number, bytes([priority])), priority)
    sent = [(frame.data[0], 0x700 - frame.id) for frame in peer.received(9)[1:]]
    assert sent == [(0, 4), (0, 7), (1, 5), (5, 1), (5, 3), (200, 0), (200, 6), (255, 2)]


@pytest.mark.conforms("AC-31")
def test_only_a_full_queue_refuses(driver: Driver) -> None:
    driver.configure(HardConfig())
    with pytest.raises(QueueFull):
        fill(driver)


def test_what_keeps_an_adapter_off_its_bus_stands_in_the_error(
    driver: Driver, monkeypatch: pytest.MonkeyPatch
) -> None:
    driver.configure(HardConfig())
    monkeypatch.setattr(Hub, "obstacle", lambda *where: "can0: no such adapter")
    with pytest.raises(QueueFull, match="256 frames wait; can0: no such adapter"):
        fill(driver)


@pytest.mark.conforms("AC-16")
def test_going_on_the_bus_gives_up_what_was_queued_before(driver: Driver, peer: Peer) -> None:
    driver.configure(HardConfig())
    driver.send(Frame(1))
    driver.bus_on()
    driver.send(Frame(2))
    assert peer.receive() == Frame(2)


@pytest.mark.conforms("AC-33")
def test_a_lone_node_gives_up_at_the_first_bus_error(virtual: Virtual) -> None:
    block = virtual.driver.register(TaskBlock(conditions=0xFF))
    for count in range(1, 4):
        virtual.driver.send(Frame(count))
        assert block.wait(0.1)
        assert block.acknowledge() == Condition.BUSERR << 8 | BlockStatus.SC
        virtual.hub.run_for(0.1)
        virtual.driver.pump()
        assert (block.acknowledge(), block.tec) == (0, 8 * count)
    assert virtual.driver.on_bus


@pytest.mark.conforms("AC-16", "AC-34")
def test_bus_off_is_told_and_bus_on_begins_anew(virtual: Virtual, arrived: Arrived) -> None:
    peer, driver = virtual.peer(), virtual.driver
    block = driver.register(TaskBlock(ALL, conditions=0xFF))
    virtual.faults.inject("bit", frame_id=1, times=None)
    told = []
    for _ in range(32):
        driver.send(Frame(1))
        virtual.hub.run_for(0.01)
        driver.pump()
        told.append(block.acknowledge().conditions)
    # an SJA1000 that goes off the bus forgets its bus error interrupt: data sheet table 2, reset values
    limits = {11: Condition.BUSERR | Condition.ERRLIM, 15: Condition.BUSERR | Condition.ERRPAS}
    assert told == [limits.get(count, Condition.BUSERR) for count in range(31)] + [Condition.BUSOFF]
    assert not driver.on_bus
    virtual.faults.clear()
    driver.send(Frame(2))
    peer.send(Frame(7))
    assert peer.receive(0.1) is None
    assert driver.bus_on() is False
    virtual.hub.run_for(0.01)
    registers = virtual.registers()
    assert (registers["TXERR"], registers["RXERR"]) == (0, 0)
    assert driver.on_bus
    driver.send(Frame(3))
    peer.send(Frame(8))
    assert peer.receive() == Frame(3)
    assert [frame.id for frame in arrived(block, 2)] == [7, 8]


@pytest.mark.conforms("AC-27", "AC-28")
def test_a_lost_arbitration_is_told_with_its_bit(virtual: Virtual) -> None:
    peer, driver = virtual.peer(), virtual.driver
    driver.configure(HardConfig(interrupts=0xFF))
    driver.bus_on()
    block = driver.register(TaskBlock(conditions=Condition.ARBLOST))
    virtual.hub.run_for(0.01)
    peer.send(Frame(0x0F0))
    driver.send(Frame(0x0F1))
    assert peer.receive() == Frame(0x0F1)
    driver.pump()
    assert block.acknowledge().conditions == Condition.ARBLOST
    assert block.alc == 10


@pytest.mark.conforms("AC-13", "AC-27")
def test_what_the_interrupt_enable_register_leaves_out_is_not_told(virtual: Virtual) -> None:
    peer, driver = virtual.peer(), virtual.driver
    block = driver.register(TaskBlock(conditions=0xFF))
    peer.send(Frame(0x0F0))
    driver.send(Frame(0x0F1))  # loses arbitration, and ALIE is not among the default's
    assert peer.receive() == Frame(0x0F1)
    driver.pump()
    assert block.acknowledge() == 0
    driver.configure(HardConfig(interrupts=0x01))
    driver.bus_on()
    peer.stop()
    driver.send(Frame(1))
    virtual.hub.run_for(0.1)
    driver.pump()
    assert block.acknowledge() == 0
    assert (
        virtual.registers()["TXERR"] == 128
    )  # without BEIE the driver hears of no error, and gives up nothing


@pytest.mark.conforms("AC-25", "AC-26")
def test_a_callback_runs_once_until_it_is_acknowledged(running: Driver, peer: Peer, arrived: Arrived) -> None:
    threads: list[int] = []
    called = threading.Semaphore(0)

    def notify(block: TaskBlock) -> None:
        threads.append(threading.get_ident())
        called.release()

    block = running.register(TaskBlock(ALL, notify=notify))
    done = running.register(TaskBlock([Filter.one(9)]))
    peer.send(Frame(1), Frame(2), Frame(9))
    arrived(done, 1)
    assert called.acquire(timeout=LONG)
    assert len(threads) == 1
    assert threads[0] != threading.get_ident()
    assert block.acknowledge() == BlockStatus.MB
    peer.send(Frame(3))
    assert called.acquire(timeout=LONG)
    assert block.acknowledge() == BlockStatus.MB
    assert block.acknowledge() == 0


@pytest.mark.conforms("AC-25")
@pytest.mark.conforms("AC-29")
@pytest.mark.finding("acan A13")
@pytest.mark.parametrize(("size", "most"), [(64, 10), (1, 200)])
def test_a_burst_is_told_of_together_and_nothing_is_lost(virtual: Virtual, size: int, most: int) -> None:
    """The manual's loop: acknowledge, then retrieve until there is no more."""
    peer, frames, calls = virtual.peer(), [], []

    def told(block: TaskBlock) -> None:
        calls.append(block.acknowledge())
        frames.extend(block.retrieve())

    block = virtual.driver.register(TaskBlock([Filter.any()], size=size, notify=told))
    sent = [Frame(number) for number in range(200)]
    peer.send(*sent)
    virtual.hub.run_for(1.0)
    virtual.driver.pump()
    assert [frame.id for frame in frames] == [frame.id for frame in sent]
    assert block.lost == 0
    assert len(calls) <= most


def test_an_event_is_set(running: Driver, peer: Peer) -> None:
    event = canwire.Event()
    running.register(TaskBlock(ALL, notify=event))
    peer.send(Frame(1))
    assert event.wait(LONG)
    event.close()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_callback_that_fails_is_reported_and_the_service_goes_on(
    running: Driver, peer: Peer, monkeypatch: pytest.MonkeyPatch, arrived: Arrived
) -> None:
    reported: list[Any] = []
    monkeypatch.setattr(threading, "excepthook", reported.append)

    def notify(block: TaskBlock) -> None:
        raise RuntimeError("the application's own")

    running.register(TaskBlock(ALL, notify=notify))
    block = running.register(TaskBlock(ALL))
    peer.send(Frame(1))
    assert arrived(block, 1) == [Frame(1)]
    peer.send(Frame(2))
    assert arrived(block, 1) == [Frame(2)]
    assert [what.exc_type for what in reported] == [RuntimeError]


def test_iterating_ends_when_the_block_is_deregistered(running: Driver, peer: Peer) -> None:
    block = running.register(TaskBlock(ALL))
    peer.send(Frame(1), Frame(2))
    found = []
    for frame in block:
        found.append(frame)
        if len(found) == 2:
            threading.Thread(target=running.deregister, args=(block,)).start()
    assert found == [Frame(1), Frame(2)]


@pytest.mark.conforms("AC-35")
def test_a_deregistered_block_gets_nothing_more(running: Driver, peer: Peer, arrived: Arrived) -> None:
    with running.register(TaskBlock(ALL)) as block, running.register(TaskBlock(ALL)) as other:
        assert running.blocks == (block, other)
        running.deregister(block)
        running.deregister(block)
        assert running.blocks == (other,)
        peer.send(Frame(1))
        arrived(other, 1)
        assert block.occupation == 0
    assert running.blocks == ()
    assert not other.registered


def test_a_driver_may_be_closed_by_a_callback(hub: canwire.Hub, peer: Peer) -> None:
    driver = open_driver(hub)
    driver.configure(HardConfig())
    driver.bus_on()
    closed = threading.Event()

    def notify(block: TaskBlock) -> None:
        driver.close()
        closed.set()

    driver.register(TaskBlock(ALL, notify=notify))
    peer.send(Frame(1))
    assert closed.wait(LONG)
    with pytest.raises(Closed):
        driver.send(Frame(1))
    driver.close()


def test_two_drivers_of_one_connection_are_two_programs(
    running: Driver, hub: canwire.Hub, peer: Peer, arrived: Arrived
) -> None:
    with open_driver(hub) as other, other.register(TaskBlock(ALL)) as block:
        peer.send(Frame(1))
        assert arrived(block, 1) == [Frame(1)]
    assert running.on_bus


@pytest.mark.conforms("AC-14", "AC-16")
def test_programs_that_configure_at_the_same_time_wait_for_each_other(driver: Driver, second: Driver) -> None:
    def work(mine: Driver, rate_kbps: int) -> None:
        for _ in range(20):
            mine.configure(HardConfig(rate_kbps=rate_kbps))
            mine.bus_on()

    threads = [
        threading.Thread(target=work, args=(mine, rate)) for mine, rate in ((driver, 250), (second, 500))
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(LONG)
    config = driver.config()
    assert config is not None
    assert config.rate_kbps in (250, 500)


@pytest.mark.conforms("AC-14")
def test_who_holds_the_filters_keeps_others_from_changing_them(
    running: Driver, second: Driver, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(service, "_PAUSES_S", (0.001, 0.002))  # nobody gives the control back meanwhile
    with running.hold_filters():
        running.configure(HardConfig())
        running.bus_on()
        assert second.bus_on() is True
        with pytest.raises(InUse):
            second.configure(HardConfig())
        with pytest.raises(InUse):
            second.bus_off()
    second.configure(HardConfig(rate_kbps=500))
    assert running.config() == HardConfig(rate_kbps=500)


def test_a_line_set_up_by_another_dialect_is_shown_from_its_registers(
    driver: Driver, hub: canwire.Hub
) -> None:
    timing = canwire.BitTiming.from_btr(0x00, 0x1C)
    with hub.open_control(hub.board("HW000104").id, 0) as control:
        control.initialise(canwire.LineMode(timing, note=b"somebody else's"))
        config = driver.config()
    assert config is not None
    assert (config.rate_kbps, config.ts1, config.ts2) == (500, 14, 2)


def test_a_pulled_board_ends_every_wait(hub: canwire.Hub, connect: Connect) -> None:
    helper, board = connect("somebody with a hand"), ("inducan104", "HW000104", ("can0",))
    helper.unplug("HW000104")
    with pytest.raises(DriverAbsent):
        open_driver(hub)
    helper.plug(*board)
    with open_driver(hub) as driver:
        block = driver.register(TaskBlock(ALL))
        failures: list[BaseException] = []

        def wait() -> None:
            try:
                block.wait(LONG)
            except canwire.CanwireError as error:
                failures.append(error)

        waiting = threading.Thread(target=wait)
        waiting.start()
        helper.unplug("HW000104")
        waiting.join(LONG)
        assert [type(failure) for failure in failures] == [Unplugged]
        with pytest.raises(Unplugged):
            driver.send(Frame(1))
        assert driver.lost
    helper.plug(*board)


@pytest.mark.conforms("AC-27")
def test_answers_that_find_no_room_are_told_as_missing_buffers(virtual: Virtual) -> None:
    peer, driver = virtual.peer(), virtual.driver
    driver.register(TaskBlock([Filter.one(0x20, actions=Action.CHANSND, variable=bytearray(8))]))
    block = driver.register(TaskBlock(conditions=Condition.NOBUFF))
    peer.send(Frame(0x20, request(0x30)))
    virtual.hub.run_for(0.01)
    with pytest.raises(QueueFull):
        fill(driver)
    driver.pump()
    assert block.acknowledge().conditions == Condition.NOBUFF


@pytest.mark.conforms("AC-27")
def test_frames_that_nobody_fetched_in_time_are_told_as_missing_buffers(virtual: Virtual) -> None:
    peer, driver = virtual.peer(), virtual.driver
    block = driver.register(TaskBlock(ALL, conditions=Condition.NOBUFF, size=1))
    for _ in range(6):
        peer.send(*(Frame(number) for number in range(400)))
        virtual.hub.run_for(1)
    driver.pump()
    assert block.acknowledge().conditions == Condition(0)
    peer.send(Frame(1))
    virtual.hub.run_for(0.1)
    driver.pump()
    assert block.acknowledge().conditions == Condition.NOBUFF


def test_virtual_time_passes_while_somebody_waits(virtual: Virtual) -> None:
    peer, block = virtual.peer(), virtual.driver.register(TaskBlock(ALL))
    before_ns = virtual.hub.now_ns()
    assert not block.wait(0.5)
    assert virtual.hub.now_ns() - before_ns == 500_000_000
    peer.send(Frame(1))
    assert block.wait(1)
    assert [frame.id for frame in block.retrieve()] == [1]
