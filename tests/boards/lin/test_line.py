"""The LIN connector: states, modes, what may be written when, monitors, time stamps."""

from __future__ import annotations

import struct
from dataclasses import dataclass, field

import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from canwire.boards.catalogue import ideal_lin_line, plug_lin, unplug_lin
from canwire.boards.lin.description import USB_TO_CAN_FD_LIN, LinCapabilities, LinFeature
from canwire.boards.lin.line import LinLine
from canwire.boards.lin.modes import LinMode, LinMonitorMode
from canwire.boards.lin.monitor import LinMonitor
from canwire.bus.lin.bus import LinBus
from canwire.errors import BadFrame, BadValue, Busy, CanwireError, NotInitialised, Unsupported, WrongState
from canwire.timeline import Timeline
from canwire.values.event import InfoCode
from canwire.values.lin.event import LinErrorKind, LinEvent, LinEventKind, LinOutcome, LinState
from canwire.values.lin.frame import LinFrame
from canwire.values.lin.record import linmsg_of_record

MASTER = LinMode(True, 20_000)
SLAVE = LinMode(False, 20_000)
BIT_NS = 50_000


class Desk:
    """A bus and the lines on it."""

    def __init__(self) -> None:
        self.timeline = Timeline()
        self.bus = LinBus(self.timeline)

    def line(self, mode: LinMode | None = None, *, started: bool = True) -> LinLine:
        line = ideal_lin_line("LIN-1", self.timeline)
        plug_lin(line, self.bus)
        if mode is not None:
            line.initialise(mode)
            if started:
                line.start()
        return line

    def monitor(self, line: LinLine, size: int = 64, **options: bool) -> LinMonitor:
        monitor = line.open(LinMonitor(LinMonitorMode(size, **options)))
        line.activate(monitor)
        return monitor

    def run(self) -> None:
        self.timeline.run_until_idle(self.timeline.now_ns + 10**9)


@pytest.fixture
def desk() -> Desk:
    return Desk()


def taken(monitor: LinMonitor) -> list[LinFrame | LinEvent]:
    found = []
    while (message := monitor.take()) is not None:
        found.append(message)
    return found


def frames(monitor: LinMonitor) -> list[LinFrame]:
    return [message for message in taken(monitor) if isinstance(message, LinFrame)]


def kinds(monitor: LinMonitor) -> list[str]:
    """Frames by identifier, events by kind and what they say."""
    shown = []
    for message in taken(monitor):
        if isinstance(message, LinFrame):
            shown.append(f"{message.id:02X}")
        elif message.kind is LinEventKind.INFO:
            shown.append(InfoCode(message.code).name)
        elif message.kind is LinEventKind.ERROR:
            shown.append(message.error.name)
        else:
            shown.append(f"{message.kind.name} {message.state.name}")
    return shown


# states


@pytest.mark.conforms("X3-37")
def test_undefined_stopped_running(desk: Desk) -> None:
    line = desk.line()
    assert (line.status().initialised, line.status().state) == (False, LinState.STOPPED)
    with pytest.raises(NotInitialised, match="initialise the line before it is started"):
        line.start()
    line.initialise(MASTER)
    assert (line.status().initialised, line.running) == (True, False)
    line.start()
    line.start()
    assert (line.status().state, line.status().bit_rate) == (LinState.OPERATIONAL, 20_000)
    done: list[int | CanwireError] = []
    line.stop(done.append)
    line.stop(done.append)
    assert (done, line.running, line.status().initialised) == ([0, 0], False, True)
    line.start()
    line.reset()
    assert (line.running, line.status().initialised, line.status().mode) == (False, False, None)
    with pytest.raises(NotInitialised):
        line.start()


@pytest.mark.conforms("X3-37")
@pytest.mark.parametrize("rate", [1000, 2400, 9600, 19200, 20000])
@pytest.mark.parametrize("master", [True, False])
def test_modes_and_rates(desk: Desk, rate: int, master: bool) -> None:
    line = desk.line(LinMode(master, rate))
    assert (line.status().bit_rate, line.status().mode) == (rate, LinMode(master, rate))


@pytest.mark.conforms("X3-37")
@pytest.mark.parametrize(
    ("mode", "error", "message"),
    [
        (LinMode(True, 999), BadValue, "bit_rate 999: LIN runs at 1000 to 20000"),
        (LinMode(False, 20_001), BadValue, "20001"),
        (LinMode(False, 65535), BadValue, "65535"),
        (LinMode(True, 0), BadValue, "only a slave finds the bit rate"),
    ],
)
def test_modes_that_cannot_be(desk: Desk, mode: LinMode, error: type[CanwireError], message: str) -> None:
    line = desk.line(MASTER)
    with pytest.raises(error, match=message):
        line.initialise(mode)
    assert line.running  # a refused one changes nothing


def test_a_board_that_cannot(desk: Desk) -> None:
    poor = LinCapabilities(1, int(LinFeature.SLEEP), USB_TO_CAN_FD_LIN.stamps)
    line = LinLine("poor", desk.timeline, poor)
    for mode, feature in (
        (MASTER, "MASTER"),
        (LinMode(False, 0), "AUTO_RATE"),
        (LinMode(False, 9600, errors=True), "ERROR_FRAMES"),
    ):
        with pytest.raises(Unsupported, match=f"poor has no {feature}"):
            line.initialise(mode)


@pytest.mark.conforms("X4-44")
def test_capabilities() -> None:
    assert USB_TO_CAN_FD_LIN.features == 0x3F
    assert [feature.value for feature in LinFeature] == [1, 2, 4, 8, 16, 32]
    assert USB_TO_CAN_FD_LIN.stamps.tick_ns == 1000


@pytest.mark.conforms("X3-37")
def test_a_slave_that_finds_the_rate(desk: Desk) -> None:
    slave, master = desk.line(LinMode(False, 0)), desk.line(MASTER)
    monitor = desk.monitor(slave)
    assert slave.status().bit_rate == 0
    master.write(LinFrame(1, b"\1"), send=True)
    desk.run()
    assert slave.status().bit_rate == 20_000
    assert frames(monitor) == [LinFrame(1, b"\1")]


def test_stop_waits_for_the_frame_on_the_wire(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line(SLAVE)
    monitor = desk.monitor(slave)
    slave.write(LinFrame(1, b"\1" * 8), send=False)
    done: list[int] = []
    master.write(LinFrame(1, header_only=True), send=True)
    desk.timeline.run_until(50 * BIT_NS)
    master.stop(lambda result: done.append(desk.timeline.now_ns))
    slave.stop(lambda result: done.append(desk.timeline.now_ns))
    assert done == []
    with pytest.raises(Busy):
        master.write(LinFrame(2, b"\2"), send=True)
    desk.run()
    assert len(done) == 2
    assert all(124 * BIT_NS <= at_ns <= 124 * BIT_NS + 200_000 for at_ns in done)
    assert frames(monitor) == [LinFrame(1, b"\1" * 8)]
    assert not master.running


def test_reset_breaks_a_frame_off(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line(LinMode(False, 20_000, errors=True))
    monitor = desk.monitor(slave)
    master.write(LinFrame(1, b"\1" * 8), send=True)
    desk.timeline.run_until(60 * BIT_NS)
    master.reset()
    desk.run()
    assert kinds(monitor) == ["OTHER"]


def test_a_line_that_is_reset_while_it_stops(desk: Desk) -> None:
    master = desk.line(MASTER)
    master.write(LinFrame(1, b"\1"), send=True)
    desk.timeline.run_until(10 * BIT_NS)
    done: list[int | CanwireError] = []
    master.stop(done.append)
    master.close()
    assert done == [0]
    desk.run()


# writing


@pytest.mark.conforms("X3-38")
def test_the_response_table(desk: Desk) -> None:
    """Filled before the start, updated at any time, answered from in both modes, emptied by reset alone."""
    master, slave = desk.line(MASTER), desk.line(SLAVE, started=False)
    monitor = desk.monitor(master)
    slave.write(LinFrame(0x10, b"\1"), send=False)
    slave.write(LinFrame(0x3F, b"\2"), send=False)
    master.write(LinFrame(0x11, b"\3"), send=False)
    slave.start()
    for id in (0x10, 0x3F, 0x11):
        master.write(LinFrame(id, header_only=True), send=True)
        desk.run()
    slave.write(LinFrame(0x10, b"\4\5", enhanced=False), send=False)
    master.write(LinFrame(0x10, header_only=True), send=True)
    desk.run()
    slave.stop(lambda result: None)
    slave.start()
    master.write(LinFrame(0x10, header_only=True), send=True)
    desk.run()
    found = frames(monitor)
    assert [(frame.id, frame.data) for frame in found] == [
        (0x10, b"\1"),
        (0x3F, b"\2"),
        (0x11, b"\3"),
        (0x10, b"\4\5"),
        (0x10, b"\4\5"),
    ]
    assert [frame.sent for frame in found] == [False, False, True, False, False]
    slave.reset()
    slave.initialise(SLAVE)
    slave.start()
    outcomes: list[LinOutcome] = []
    master.write(LinFrame(0x10, header_only=True), send=True, finished=outcomes.append)
    desk.run()
    assert outcomes == [LinOutcome.SILENT]


@pytest.mark.conforms("X3-38")
def test_what_no_response_can_be(desk: Desk) -> None:
    line = desk.line()
    with pytest.raises(NotInitialised, match="initialise the line before it is given responses"):
        line.write(LinFrame(1, b"\1"), send=False)
    line.initialise(SLAVE)
    with pytest.raises(BadFrame, match="a response has data"):
        line.write(LinFrame(1, header_only=True), send=False)


@pytest.mark.conforms("X3-39")
def test_a_master_sends_data_sleep_and_wake_up(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line(SLAVE)
    monitor = desk.monitor(slave)
    master.write(LinFrame(1, b"\1"), send=True)
    desk.run()
    master.go_to_sleep()
    desk.run()
    assert slave.status().state is LinState.ASLEEP
    master.wake_up()
    desk.run()
    assert slave.status().state is LinState.OPERATIONAL
    assert kinds(monitor) == [
        "01",
        "3C",
        "STATE ASLEEP",
        "SLEEP ASLEEP",
        "WAKEUP OPERATIONAL",
        "STATE OPERATIONAL",
    ]


@pytest.mark.conforms("X3-39")
def test_a_slave_sends_wake_up_alone(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line(SLAVE)
    for frame in (LinFrame(1, b"\1"), LinFrame(1, header_only=True)):
        with pytest.raises(WrongState, match="a slave sends nothing but wake-up pulses"):
            slave.write(frame, send=True)
    with pytest.raises(WrongState, match="a slave sends nothing"):
        slave.go_to_sleep()
    master.go_to_sleep()
    desk.run()
    slave.wake_up()
    desk.run()
    assert master.status().state is LinState.OPERATIONAL


@pytest.mark.conforms("X3-40")
def test_id_only_sends_the_header_alone(desk: Desk) -> None:
    """Any slave answers; the length says until when an answer must be over."""
    master = desk.line(LinMode(True, 20_000, errors=True))
    one, other = desk.line(SLAVE), desk.line(SLAVE)
    monitor = desk.monitor(master)
    other.write(LinFrame(7, b"\1\2"), send=False)
    master.write(LinFrame(7, header_only=True, length=2), send=True)
    desk.run()
    (frame,) = frames(monitor)
    assert (frame, frame.timestamp_ns) == (LinFrame(7, b"\1\2"), 64 * BIT_NS)
    assert one.status().headers == 1
    master.write(LinFrame(8, header_only=True, length=2), send=True)
    desk.run()
    (event,) = taken(monitor)
    assert isinstance(event, LinEvent)
    assert (event.error, event.id) == (LinErrorKind.SLNORE, 8)
    assert event.timestamp_ns == (64 + 34 + 42) * BIT_NS


@pytest.mark.conforms("X3-41")
def test_write_returns_at_once_and_a_second_one_is_refused_until_the_first_is_over(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line(SLAVE)
    monitor = desk.monitor(slave)
    master.write(LinFrame(1, b"\1"), send=True)
    assert (desk.timeline.now_ns, master.status().transmitting) == (0, True)
    for at_bit in (0, 1, 33, 53):
        desk.timeline.run_until(at_bit * BIT_NS)
        with pytest.raises(Busy, match="what was sent before is not over"):
            master.write(LinFrame(2, b"\2"), send=True)
        with pytest.raises(Busy):
            master.wake_up()
    master.write(LinFrame(3, b"\3"), send=False)  # the table is free at any time
    desk.timeline.run_until(54 * BIT_NS)
    assert not master.status().transmitting
    master.write(LinFrame(2, b"\2"), send=True)
    desk.run()
    assert [frame.id for frame in frames(monitor)] == [1, 2]


@pytest.mark.conforms("X3-41")
def test_an_unanswered_header_is_over_with_its_time(desk: Desk) -> None:
    master = desk.line(MASTER)
    master.write(LinFrame(1, header_only=True, length=1), send=True)
    desk.timeline.run_until((34 + 28) * BIT_NS - 1)
    assert master.busy
    desk.timeline.run_until((34 + 28) * BIT_NS)
    assert not master.busy


def test_a_line_that_is_not_started_sends_nothing(desk: Desk) -> None:
    line = desk.line()
    with pytest.raises(NotInitialised, match="before it is told to send"):
        line.write(LinFrame(1, b"\1"), send=True)
    line.initialise(MASTER)
    for send in (lambda: line.write(LinFrame(1, b"\1"), send=True), line.go_to_sleep, line.wake_up):
        with pytest.raises(WrongState, match="start the line before something is sent"):
            send()


# monitors


def test_every_active_monitor_gets_every_message(desk: Desk) -> None:
    master = desk.line(MASTER)
    first, second = desk.monitor(master), desk.monitor(master)
    idle = master.open(LinMonitor(LinMonitorMode(8)))
    slave = desk.line(SLAVE)
    slave.write(LinFrame(1, b"\1"), send=False)
    master.write(LinFrame(1, header_only=True), send=True)
    desk.run()
    assert frames(first) == frames(second) == [LinFrame(1, b"\1")]
    assert idle.take() is None
    master.activate(first, False)
    master.dismiss(second)
    master.dismiss(second)
    master.write(LinFrame(1, header_only=True), send=True)
    desk.run()
    assert (first.take(), second.take()) == (None, None)


@pytest.mark.conforms("X4-46")
def test_own_responses_are_marked(desk: Desk) -> None:
    master = desk.line(MASTER)
    with_own, without = desk.monitor(master), desk.monitor(master, own=False)
    master.write(LinFrame(1, b"\1"), send=True)
    desk.run()
    (frame,) = frames(with_own)
    assert (frame, frame.sent) == (LinFrame(1, b"\1"), True)
    assert frames(without) == []


@pytest.mark.conforms("X3-43")
def test_queues_survive_stop_and_reset(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line(SLAVE)
    monitor = desk.monitor(slave)
    master.write(LinFrame(1, b"\1"), send=True)
    desk.run()
    slave.stop(lambda result: None)
    slave.reset()
    assert kinds(monitor) == ["01", "STATE STOPPED", "STOPPED", "RESET"]


def test_start_stop_and_reset_are_told(desk: Desk) -> None:
    line = desk.line()
    monitor = desk.monitor(line, ticks=True)
    desk.timeline.run_until(5_000_000)
    line.initialise(SLAVE)
    line.start()
    desk.timeline.run_until(6_000_000)
    line.stop(lambda result: None)
    line.reset()
    told = [
        (InfoCode(event.code).name, event.timestamp_ns)
        for event in taken(monitor)
        if isinstance(event, LinEvent) and event.kind is LinEventKind.INFO
    ]
    assert told == [("STARTED", 0), ("STOPPED", 0), ("RESET", 0)]


def test_errors_are_told_only_in_the_error_mode(desk: Desk) -> None:
    quiet, loud = desk.line(MASTER), desk.line(LinMode(False, 20_000, errors=True))
    monitors = [desk.monitor(quiet), desk.monitor(loud)]
    quiet.controller.host.error(LinErrorKind.BIT, 1, True, 0)
    loud.controller.host.error(LinErrorKind.BIT, 1, True, 0)
    assert [kinds(monitor) for monitor in monitors] == [[], ["BIT"]]


@pytest.mark.conforms("X4-47")
def test_a_full_queue_counts_what_it_loses(desk: Desk) -> None:
    """The message that fills it says so (ruling 7)."""
    master, slave = desk.line(MASTER), desk.line(SLAVE)
    monitor = slave.open(LinMonitor(LinMonitorMode(3, exact=True)))
    slave.activate(monitor)
    for number in range(5):
        master.write(LinFrame(number, b"\1"), send=True)
        desk.run()
    status = monitor.status()
    assert (status.active, status.accepted, status.lost, status.fill_percent) == (True, 5, 2, 100)
    assert slave.status().status == 0x01  # overrun
    found = frames(monitor)
    assert [(frame.id, frame.overrun) for frame in found] == [(0, False), (1, False), (2, True)]
    master.write(LinFrame(9, b"\1"), send=True)
    desk.run()
    (frame,) = frames(monitor)
    assert (frame.id, frame.overrun) == (9, False)
    assert monitor.status().fill_percent == 0


def test_an_event_may_fill_a_queue_too(desk: Desk) -> None:
    line = desk.line()
    monitor = line.open(LinMonitor(LinMonitorMode(1, exact=True)))
    line.activate(monitor)
    line.reset()
    record = monitor.ring.take_bytes()
    assert record is not None
    assert struct.unpack_from("<I", record, 12)[0] & 1 << 26


@pytest.mark.conforms("X4-47")
def test_status_of_a_line(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line(SLAVE)
    assert desk.line().status().status == 0x10  # stopped
    master.write(LinFrame(1, b"\1"), send=True)
    desk.timeline.run_until(10 * BIT_NS)
    status = master.status()
    assert (status.transmitting, status.running, status.time_ns) == (True, True, 10 * BIT_NS)
    assert status.load == pytest.approx(100.0)
    desk.run()
    assert not master.status().transmitting
    assert (master.status().frames_sent, slave.status().frames_received) == (1, 1)
    assert slave.status().headers == 1


def test_ticks_count_from_the_first_start(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line()
    monitor = desk.monitor(slave, ticks=True)
    desk.timeline.run_until(10_000_000)
    slave.initialise(SLAVE)
    slave.start()
    master.write(LinFrame(1, b"\1"), send=True)
    desk.run()
    stamps = [message.timestamp_ns for message in taken(monitor)]
    assert stamps == [0, 0, 54 * BIT_NS // 1000]
    late = desk.monitor(slave, ticks=True)
    slave.stop(lambda result: None)
    slave.start()
    master.write(LinFrame(1, b"\1"), send=True)
    desk.run()
    assert frames(late)[0].timestamp_ns == 2 * 54 * BIT_NS // 1000


def test_the_counter_runs_over(desk: Desk) -> None:
    slave = desk.line(SLAVE)
    monitor = desk.monitor(slave, ticks=True)
    taken(monitor)
    desk.timeline.run_until(2 * (1 << 32) * 1000 + 5)
    messages = [message for message in taken(monitor) if isinstance(message, LinEvent)]
    overruns = [event for event in messages if event.kind is LinEventKind.TIME_OVERRUN]
    assert [(event.timestamp_ns, event.code) for event in overruns] == [(0, 1), (0, 1)]
    slave.reset()
    desk.timeline.run_until(4 * (1 << 32) * 1000)
    assert [kind for kind in kinds(monitor) if "TIME" in kind] == []


@pytest.mark.conforms("X4-46")
def test_a_message_as_vci_sees_it(desk: Desk) -> None:
    master, slave = desk.line(MASTER), desk.line(SLAVE)
    monitor = desk.monitor(master, ticks=True)
    slave.write(LinFrame(0x10, b"\1\2"), send=False)
    master.write(LinFrame(0x10, header_only=True, length=2), send=True)
    desk.run()
    record = monitor.ring.take_bytes()
    assert record is not None
    time, info, data = struct.unpack("<II8s", linmsg_of_record(record))
    assert (time, data) == (64 * 50, b"\1\2".ljust(8, b"\0"))
    assert (info & 0xFF, info >> 8 & 0xFF, info >> 16 & 0xFF, info >> 24) == (0x50, 0, 2, 1)


def test_a_line_that_is_unplugged(desk: Desk) -> None:
    line = desk.line(MASTER)
    unplug_lin(line)
    unplug_lin(line)
    assert line.status().load == 0.0
    line.write(LinFrame(1, b"\1"), send=True)
    desk.run()
    assert line.busy


class Lines(RuleBasedStateMachine):
    """Whatever is asked in whatever order: states as they should be, clear errors, and nothing is lost silently."""

    @initialize()
    def begin(self) -> None:
        self.desk = Desk()
        self.books = [Book(self.desk.line()) for _ in range(3)]
        for book in self.books:
            book.monitor = self.desk.monitor(book.line, 4)

    @rule(k=st.integers(0, 2), master=st.booleans(), rate=st.sampled_from([0, 9600, 20_000, 30_000]))
    def initialise(self, k: int, master: bool, rate: int) -> None:
        book = self.books[k]
        mode = LinMode(master, rate, errors=True)
        if rate > 20_000 or (rate == 0 and master):
            with pytest.raises(BadValue):
                book.line.initialise(mode)
        else:
            book.line.initialise(mode)
            book.mode, book.running = mode, False

    @rule(k=st.integers(0, 2))
    def start(self, k: int) -> None:
        book = self.books[k]
        if book.mode is None:
            with pytest.raises(NotInitialised):
                book.line.start()
        else:
            book.line.start()
            book.running = True

    @rule(k=st.integers(0, 2))
    def stop(self, k: int) -> None:
        done: list[object] = []
        self.books[k].line.stop(done.append)
        self.desk.timeline.run_until(self.desk.timeline.now_ns + 300_000_000)
        assert done == [0]
        self.books[k].running = False

    @rule(k=st.integers(0, 2))
    def reset(self, k: int) -> None:
        self.books[k].line.reset()
        self.books[k].mode, self.books[k].running = None, False

    @rule(k=st.integers(0, 2), id=st.integers(0, 63), data=st.binary(max_size=8), header=st.booleans())
    def send(self, k: int, id: int, data: bytes, header: bool) -> None:
        book = self.books[k]
        frame = LinFrame(id, header_only=True) if header else LinFrame(id, data)
        if book.mode is None:
            expected: type[CanwireError] | None = NotInitialised
        elif not book.running or not book.mode.master:
            expected = WrongState
        else:
            expected = Busy if book.line.busy else None
        if expected is None:
            book.line.write(frame, send=True)
        else:
            with pytest.raises(expected):
                book.line.write(frame, send=True)

    @rule(k=st.integers(0, 2), id=st.integers(0, 63), data=st.binary(max_size=8))
    def respond(self, k: int, id: int, data: bytes) -> None:
        if self.books[k].mode is not None:
            self.books[k].line.write(LinFrame(id, data), send=False)

    @rule(k=st.integers(0, 2))
    def wake(self, k: int) -> None:
        book = self.books[k]
        if book.running and not book.line.busy:
            book.line.wake_up()

    @rule(span_ns=st.integers(0, 20_000_000) | st.sampled_from([0, 50_000, 5_000_000_000]))
    def pass_time(self, span_ns: int) -> None:
        self.desk.timeline.run_until(self.desk.timeline.now_ns + span_ns)

    @rule(k=st.integers(0, 2))
    def read(self, k: int) -> None:
        self.books[k].read += len(taken(self.books[k].monitor))

    @invariant()
    def the_books_balance(self) -> None:
        for book in getattr(self, "books", []):
            monitor = book.monitor
            assert monitor.accepted == book.read + monitor.ring.fill() + monitor.lost
            assert book.line.running == book.running
            assert (book.line.mode is None) == (book.mode is None)


@dataclass
class Book:
    """What the machine above expects of one line."""

    line: LinLine
    mode: LinMode | None = None
    running: bool = False
    read: int = 0
    monitor: LinMonitor = field(default_factory=lambda: LinMonitor(LinMonitorMode(1)))


TestLines = Lines.TestCase
TestLines.settings = settings(max_examples=40, stateful_step_count=30, deadline=None)
