"""The bench's promises for LIN: names, queues, schedules, and what it says when asked for the impossible."""

from __future__ import annotations

import asyncio
import inspect
from pathlib import Path

import pytest

from canwire import (
    BadFrame,
    BadValue,
    Busy,
    Closed,
    Lab,
    LabLinBus,
    LabLinNode,
    LinErrorKind,
    LinEventKind,
    LinFrame,
    LinSchedule,
    LinSlot,
    LinState,
    NotReceived,
    QueueFull,
    WrongState,
)
from tests.cases import each

N8 = bytes(range(8))


@pytest.fixture
def lin_bus(lab: Lab) -> LabLinBus:
    return lab.lin_bus("lin0", bit_rate=20_000)


PINNED = {
    Lab.lin_bus: "name * bit_rate sleep_after",
    LabLinBus.master: "name * schedule responses enhanced checksums rival self_reception oscillator_ppm break_bits"
    " delimiter_bits header_space_bits response_space_bits byte_space_bits receive_queue",
    LabLinBus.slave: "name * responses subscribes events response_error enhanced checksums attributes self_reception"
    " bit_rate oscillator_ppm synchronises response_space_bits byte_space_bits start_up receive_queue",
    LabLinNode.send: "frame",
    LabLinNode.ask: "id length",
    LabLinNode.respond: "id data * enhanced once",
    LabLinNode.receive: "timeout",
    LabLinNode.receive_many: "limit",
    LabLinNode.expect: "id * within data",
    LabLinNode.expect_nothing: "* within",
}


@each("function", list(PINNED))
def test_names_of_arguments_are_pinned(function: object) -> None:
    parameters = inspect.signature(function).parameters.values()  # type: ignore[arg-type]
    positional = [p.name for p in parameters if p.kind is p.POSITIONAL_OR_KEYWORD and p.name != "self"]
    keywords = [p.name for p in parameters if p.kind is p.KEYWORD_ONLY]
    first, _, second = PINNED[function].partition("*")  # type: ignore[index]
    assert positional[: len(first.split())] == first.split()
    assert set(second.split()) <= set(keywords)


def test_the_example_of_the_documentation() -> None:
    with Lab() as lab:
        bus = lab.lin_bus("lin0", bit_rate=19200)
        master = bus.master(schedule=[0x10, 0x11])
        slave = bus.slave("door", responses={0x10: b"\1\2"})
        bus.slave("window", responses={0x11: b"\3"})
        lab.run_until_idle()
        assert master.receive_many(9) == [LinFrame(0x10, b"\1\2"), LinFrame(0x11, b"\3")]
        assert slave.receive() == LinFrame(0x11, b"\3")
        slave.respond(0x10, b"\4\5")
        assert master.expect(0x10, within=0.05).data == b"\4\5"
        bus.faults.checksum(0x11)
        master.events()
        lab.run_for(0.02)
        assert [event.error for event in master.events(LinEventKind.ERROR)] == [LinErrorKind.CHKSUM]
        assert 0 < bus.load < 100


def test_shorthand_for_schedules(lab: Lab, lin_bus: LabLinBus) -> None:
    lin_bus.slave(responses={1: b"\1", 2: b"\2"})
    master = lin_bus.master(
        schedule={"fast": [(1, 0.005)], "slow": [LinSlot.frame(2, delay_ns=20_000_000), 1]}
    )
    assert master.schedule.running == "fast"
    lab.run_for(0.012)
    assert [frame.id for frame in master.receive_many(9)] == [1, 1]
    master.schedule.start("slow")
    lab.run_for(0.05)
    assert [frame.id for frame in master.receive_many(9)] == [1, 2, 1, 2]
    master.schedule.stop()
    lab.run_for(1)
    assert master.receive_many(9) == []


def test_a_schedule_object(lab: Lab, lin_bus: LabLinBus) -> None:
    lin_bus.slave(responses={1: b"\1"})
    master = lin_bus.master(schedule=LinSchedule("only", (LinSlot.frame(1),)))
    assert master.schedule.running == "only"
    lab.run_until_idle()
    assert master.receive() == LinFrame(1, b"\1")


def test_a_diagnostic_exchange(lab: Lab, lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave()
    master = lin_bus.master(schedule=[LinSlot.request(), LinSlot.response()])
    request = bytes.fromhex("0106b200ff7fffff")
    master.schedule.request(request)
    assert slave.expect(0x3C, within=0.1).data == request
    slave.respond(0x3D, bytes.fromhex("0106f2ff7f012345"), once=True)
    frame = master.expect(0x3D, within=0.1)
    assert (frame.checksum, frame.enhanced) == (0x1D, False)
    lab.run_for(1)
    assert master.receive() is None


def test_event_triggered_slaves(lab: Lab, lin_bus: LabLinBus) -> None:
    slaves = [
        lin_bus.slave(name, responses={id: b"\0\0"}, events={0x20: id})
        for name, id in (("l", 0x11), ("r", 0x12))
    ]
    master = lin_bus.master(schedule=[LinSlot.event(0x20, [0x11, 0x12])])
    lab.run_for(0.1)  # both had news at first
    assert [frame.id for frame in master.receive_many(9)] == [0x11, 0x12]
    slaves[1].respond(0x12, b"\0\7")
    frame = master.expect(0x20, within=0.1)
    assert frame.data == b"\x92\7"
    lab.run_for(0.1)
    assert master.receive() is None
    assert master.schedule.collisions == 1


# sending


def test_a_master_s_frames_wait_for_each_other(lab: Lab, lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave(responses={9: b"\7"})
    master = lin_bus.master()
    for number in range(20):
        master.send(LinFrame(number, N8)) if number != 9 else master.ask(9)
    assert master.pending == 20
    lab.run_until_idle()
    assert master.pending == 0
    assert [frame.id for frame in slave.receive_many(99)] == [k for k in range(20) if k != 9]
    assert master.receive() == LinFrame(9, b"\7")


def test_the_transmit_queue_is_not_endless(lin_bus: LabLinBus) -> None:
    master = lin_bus.master()
    with pytest.raises(QueueFull, match="16384 frames wait"):
        all(master.ask(1) is None for _ in range(20_000))


def test_a_slave_sends_nothing_by_itself(lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave()
    for send in (lambda: slave.send(LinFrame(1, b"\1")), lambda: slave.ask(1), slave.sleep):
        with pytest.raises(WrongState, match="a slave sends nothing by itself; use respond, or wake"):
            send()
    with pytest.raises(WrongState, match="only a master has a schedule"):  # noqa: PT012
        slave.schedule.add(LinSchedule.of([1]))
        slave.schedule.start()


def test_a_pulse_that_is_not_over(lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave()
    slave.wake()
    with pytest.raises(Busy):
        slave.wake()


def test_responses(lab: Lab, lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave(
        responses={1: b"\1", 2: LinFrame(2, b"\2", enhanced=True), 0x3D: N8}, enhanced=False
    )
    master = lin_bus.master(responses={3: b"\3"}, self_reception=True)
    slave.respond(4, b"\4", enhanced=True)
    for id in (1, 2, 0x3D, 3, 4):
        master.ask(id)
    lab.run_until_idle()
    found = master.receive_many(9)
    assert [(frame.id, frame.enhanced, frame.sent) for frame in found] == [
        (1, False, False),
        (2, True, False),
        (0x3D, False, False),
        (3, True, True),
        (4, True, False),
    ]
    slave.withdraw(1)
    master.ask(1)
    lab.run_until_idle()
    assert master.receive() is None


# receiving


def test_receive_with_and_without_waiting(lab: Lab, lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave(responses={1: b"\1"})
    master = lin_bus.master(schedule=[(1, 0.1)])
    assert master.receive() is None
    lab.run_for(0.05)
    assert master.receive(timeout=1.0) == LinFrame(1, b"\1")
    assert lab.now_ns == 50_000_000
    assert master.receive(timeout=1.0) is not None
    assert lab.now_ns == 102_700_000
    assert slave.receive(timeout=0.5) is None
    assert lab.now_ns == 602_700_000


def test_expect_says_what_came_instead(lin_bus: LabLinBus) -> None:
    lin_bus.slave(responses={1: b"\1"})
    master = lin_bus.master(schedule=[(1, 0.1)])
    with pytest.raises(NotReceived, match=r"no frame 0x02 within 0.35 s; 4 others, last: LinFrame\(0x01"):
        master.expect(2, within=0.35)
    with pytest.raises(NotReceived, match="arrived where silence was expected"):
        master.expect_nothing(within=0.2)
    master.schedule.stop()
    master.bus.time.run_until_idle()
    master.receive_many(9)
    master.expect_nothing(within=0.2)
    with pytest.raises(NotReceived, match="0 others, last: nothing"):
        master.expect(1, within=0.1, data=b"\1")


def test_a_full_queue_counts(lab: Lab, lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave(receive_queue=4)
    master = lin_bus.master()
    for number in range(7):
        master.send(LinFrame(number, b""))
    lab.run_until_idle()
    assert (slave.accepted, slave.waiting, slave.lost) == (7, 4, 3)
    assert [frame.overrun for frame in slave.receive_many(9)] == [False, False, False, True]


def test_callbacks_on_arrival(lab: Lab, lin_bus: LabLinBus) -> None:
    """A gateway: what one bus brings goes out on the other."""
    other = lab.lin_bus("lin1")
    slave = lin_bus.slave()
    master, far = other.master(), other.slave()

    def forward() -> None:
        frame = slave.receive()
        assert frame is not None
        master.send(frame)

    slave.on_frames(forward)
    lin_bus.master().send(LinFrame(7, b"\7"))
    lab.run_until_idle()
    assert far.receive() == LinFrame(7, b"\7")
    slave.on_frames(None)


def test_with_asyncio(lab: Lab, lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave(responses={1: b"\1"})
    master = lin_bus.master(schedule=[(1, 0.1)])

    async def collect() -> list[int]:
        found = []
        async for frame in master:
            found.append(frame.timestamp_ns)
            if len(found) == 3:
                return found
        raise AssertionError

    async def both() -> tuple[list[int], LinFrame | None]:
        return await collect(), await slave.receive_async(timeout=0.01)

    assert asyncio.run(both()) == ([2_700_000, 102_700_000, 202_700_000], None)


# state


def test_state_and_counters(lab: Lab, lin_bus: LabLinBus) -> None:
    slave, master = lin_bus.slave(start_up=0.01), lin_bus.master()
    assert slave.state is LinState.INITIALISING
    lab.run_for(0.01)
    assert (slave.state, slave.bit_rate) == (LinState.OPERATIONAL, 20_000)
    slave.stop()
    assert slave.state is LinState.STOPPED
    slave.start()
    lab.run_for(0.02)
    master.send(LinFrame(1, b"\1"))
    lab.run_until_idle()
    counters = slave.counters
    assert (counters.headers, counters.frames_received, counters.frames_sent) == (1, 1, 0)
    assert repr(slave) == "<slave lin0/slave: OPERATIONAL, 1 headers heard>"
    assert repr(master).startswith("<master lin0/master: OPERATIONAL")


def test_closing(lab: Lab, lin_bus: LabLinBus) -> None:
    slave = lin_bus.slave()
    slave.close()
    slave.close()
    for use in (
        lambda: slave.send(LinFrame(1)),
        lambda: slave.respond(1, b""),
        slave.wake,
        slave.start,
        slave.receive,
    ):
        with pytest.raises(Closed, match="node slave is closed"):
            use()
    lab.close()
    with pytest.raises(Closed):
        lab.lin_bus("more")


def test_names_are_unique(lab: Lab, lin_bus: LabLinBus) -> None:
    lab.can_bus("can0")
    for make in (lab.lin_bus, lab.can_bus):
        for name in ("lin0", "can0"):
            with pytest.raises(BadValue, match=f"there is a bus '{name}' already"):
                make(name)
    lin_bus.slave("a")
    with pytest.raises(BadValue, match="there is a node 'a' already"):
        lin_bus.master("a")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda bus: bus.slave(responses={64: b""}), "identifier 0x40"),
        (lambda bus: bus.slave(responses={1: bytes(9)}), "9 bytes"),
        (lambda bus: bus.slave(responses={1: LinFrame(2, b"")}), "has another identifier"),
        (lambda bus: bus.slave(subscribes={1: 9}), "length 9"),
        (lambda bus: bus.slave(events={64: 1}), "identifier 0x40"),
        (lambda bus: bus.slave(response_error=(1, 64)), "response_error bit 64"),
        (lambda bus: bus.master(schedule=[]), "one LinSlot at least"),
        (lambda bus: bus.master(schedule=[99]), "identifier 0x63"),
        (lambda bus: bus.master(schedule=[(1, -1.0)]), "slot -1.0"),
    ],
)
def test_the_impossible(lin_bus: LabLinBus, make: object, message: str) -> None:
    with pytest.raises((BadValue, BadFrame), match=message):
        make(lin_bus)  # type: ignore[operator]


def test_sleep_after_nothing(lab: Lab) -> None:
    with pytest.raises(BadValue, match="sleep_after 0"):
        lab.lin_bus(sleep_after=0)


def test_a_trace_of_levels(lab: Lab, lin_bus: LabLinBus, tmp_path: Path) -> None:
    path = tmp_path / "lin.vcd"
    lin_bus.slave(responses={1: b"\xff"})
    master = lin_bus.master()
    lin_bus.trace_levels(path)
    master.ask(1)
    lab.run_until_idle()
    lin_bus.end_trace()
    text = path.read_text()
    assert "$var wire 1 ! lin0 $end" in text
    changes = text.split("$enddefinitions $end\n")[1].split()
    assert changes[:8] == ["#0", "1!", "#0", "0!", "#650000", "1!", "#700000", "0!"]
    master.ask(1)
    lab.run_until_idle()
    assert path.read_text() == text


@pytest.mark.realtime
def test_in_real_time() -> None:
    with Lab(time="real") as lab:
        bus = lab.lin_bus()
        slave = bus.slave(responses={1: b"\1"})
        master = bus.master(schedule=[(1, 0.01)])
        assert master.receive(timeout=5.0) == LinFrame(1, b"\1")
        slave.respond(1, b"\2")
        assert master.expect(1, within=5.0, data=b"\2").timestamp_ns > 0
        master.schedule.stop()


def test_a_closed_slave_leaves_nothing_behind(lab: Lab) -> None:
    bus = lab.lin_bus("lin9")
    master = bus.master("master")
    for data in (b"\x01", b"\x02"):
        slave = bus.slave("slave", responses={0x10: data})
        master.ask(0x10)
        lab.run_until_idle()
        answer = master.receive()
        assert answer is not None
        assert answer.data == data
        slave.close()
    assert list(bus.nodes) == ["master"]
    assert len(bus.wire.nodes) == 1


@pytest.mark.finding("wire-2 6")
@pytest.mark.parametrize("bitwise", [False, True])
@pytest.mark.parametrize(("expects", "sent"), [(True, False), (False, True)])
def test_a_subscriber_takes_its_checksum_alone(
    lin_bus: LabLinBus, lab: Lab, expects: bool, sent: bool, bitwise: bool
) -> None:
    """The commonest mistake of LIN integration: both sides are set to another model."""
    lin_bus.wire.bitwise = bitwise
    master = lin_bus.master(responses={0x10: LinFrame(0x10, N8, enhanced=sent)})
    slave = lin_bus.slave(subscribes={0x10: 8}, enhanced=expects)
    monitor = lin_bus.slave("monitor")
    slave.events()
    master.ask(0x10)
    lab.run_for(0.1)
    assert [event.error for event in slave.events() if event.error] == [LinErrorKind.CHKSUM]
    assert slave.receive(0) is None
    assert slave.response_error
    (heard,) = [monitor.receive(0)]
    assert heard == LinFrame(
        0x10, N8, enhanced=sent
    )  # who subscribes to nothing takes either, and says which


def test_checksums_are_set_frame_by_frame(lin_bus: LabLinBus, lab: Lab) -> None:
    responses = {id: LinFrame(id, N8, enhanced=id != 0x11) for id in (0x10, 0x11, 0x12)}
    master = lin_bus.master(responses=responses, checksums={0x3D: True})  # a diagnostic frame's stays classic
    slave = lin_bus.slave(subscribes={0x10: 8, 0x11: 8, 0x12: 8}, checksums={0x11: False, 0x12: False})
    slave.respond(0x3D, N8)
    for id in (0x10, 0x11, 0x12, 0x3D):
        master.ask(id)
    lab.run_for(0.1)
    assert [frame.id for frame in slave.receive_many(9)] == [0x10, 0x11]
    assert slave.counters.errors[LinErrorKind.CHKSUM] == 1
    slave.expect_checksum(0x12, None)
    master.ask(0x12)
    assert slave.expect(0x12, within=0.1).enhanced
    assert master.expect(0x3D, within=0.1).data == N8


def test_a_master_takes_what_its_description_says(lin_bus: LabLinBus, lab: Lab) -> None:
    master = lin_bus.master(checksums={0x20: True})
    lin_bus.slave(responses={0x20: LinFrame(0x20, b"\x01", enhanced=False)})
    master.ask(0x20)
    lab.run_for(0.1)
    assert master.receive(0) is None
    assert master.counters.errors[LinErrorKind.CHKSUM] == 1
