"""Schedule tables on a line: the grid of slots, each kind of slot, switching, sleep."""

from __future__ import annotations

import pytest

from canwire.boards.catalogue import ideal_lin_line, plug_lin
from canwire.boards.lin.line import LinLine
from canwire.boards.lin.modes import LinMode, LinMonitorMode
from canwire.boards.lin.monitor import LinMonitor
from canwire.boards.lin.schedule import LinScheduler
from canwire.bus.lin.bus import LinBus
from canwire.errors import BadFrame, BadValue
from canwire.timeline import Timeline
from canwire.values.lin.event import LinErrorKind, LinState
from canwire.values.lin.frame import LinFrame, protected_id
from canwire.values.lin.schedule import LinSchedule, LinSlot

MS = 1_000_000
REQUEST = bytes.fromhex("0106b2ff7f010000")
ANSWER = bytes.fromhex("0106f2ff7f012345")


class Network:
    """A master with a schedule, and slaves, at 20 kbit/s."""

    def __init__(self, *slots: LinSlot | int, slaves: int = 2) -> None:
        self.timeline = Timeline()
        self.bus = LinBus(self.timeline)
        self.master, self.monitor = self._line(True)
        self.slaves = [self._line(False)[0] for _ in range(slaves)]
        self.scheduler = LinScheduler(self.master, LinSchedule.of(slots, "main"))

    def _line(self, master: bool) -> tuple[LinLine, LinMonitor]:
        line = ideal_lin_line("m" if master else "s", self.timeline)
        plug_lin(line, self.bus)
        line.initialise(LinMode(master, 20_000, errors=True))
        monitor = line.open(LinMonitor(LinMonitorMode(4096, events=())))
        line.activate(monitor)
        line.start()
        return line, monitor

    def heard(self) -> list[tuple[int, int]]:
        """Identifiers of the frames since the last call, with the millisecond in which their slot began."""
        found = []
        while (message := self.monitor.take()) is not None:
            assert isinstance(message, LinFrame)
            bits = 44 + 10 * message.length
            found.append((message.id, (message.timestamp_ns - bits * 50_000) // MS))
        return found

    def run(self, until_ms: int) -> list[tuple[int, int]]:
        self.timeline.run_until(until_ms * MS - 1)
        return self.heard()

    def respond(self, slave: int, id: int, data: bytes, *, once: bool = False) -> None:
        self.slaves[slave].driver.respond(LinFrame(id, data), once=once)


def slot(id: int, ms: int = 10, length: int = 0) -> LinSlot:
    return LinSlot.frame(id, delay_ns=ms * MS, length=length)


def test_slots_follow_each_other_on_a_grid_that_does_not_drift() -> None:
    network = Network(slot(1, 10), slot(2, 15), slot(3, 5, 1))
    for id in (1, 2, 3):
        network.respond(0, id, b"\1")
    network.scheduler.start()
    assert network.run(65) == [(1, 0), (2, 10), (3, 25), (1, 30), (2, 40), (3, 55), (1, 60)]
    network.run(30_000)
    assert network.run(30_030) == [(1, 30_000), (2, 30_010), (3, 30_025)]
    assert network.scheduler.skipped == 0


def test_a_slot_needs_one_look_when_its_frame_is_over() -> None:
    """And whoever looks only then sees the same frames with the same stamps."""
    looks: dict[str, int] = {}
    heard: dict[str, list[tuple[int, int]]] = {}
    for until in ("next_ns", "wake_ns"):
        network = Network(slot(1), slot(2), slot(3))
        for id, data in ((1, bytes(8)), (2, b"\2"), (3, bytes(4))):
            network.respond(id % 2, id, data)
        network.scheduler.start()
        network.timeline.run_until(0)
        looks[until] = 0
        while (due_ns := getattr(network.timeline, until)()) < 900 * MS:
            network.timeline.run_until(due_ns)
            looks[until] += 1
        heard[until] = network.heard()
    assert heard["wake_ns"] == heard["next_ns"]
    assert len(heard["wake_ns"]) == looks["wake_ns"] == 90
    assert looks["next_ns"] == 3 * 90 - 1  # the first slot had begun


def test_the_end_of_the_last_round_is_not_put_off() -> None:
    network = Network(slot(1))
    network.respond(0, 1, bytes(8))
    network.scheduler.start(rounds=2)
    network.timeline.run_until(0)
    network.timeline.run_until(15 * MS)
    assert network.timeline.wake_ns() == network.timeline.next_ns()
    network.timeline.run_until(20 * MS)
    assert network.scheduler.running is None


def test_the_master_publishes_from_its_own_table() -> None:
    network = Network(slot(1))
    network.master.write(LinFrame(1, b"\7"), send=False)
    network.scheduler.start()
    network.timeline.run_until(6 * MS)
    message = network.monitor.take()
    assert isinstance(message, LinFrame)
    assert (message.data, message.sent) == (b"\7", True)


def test_the_usual_delay_holds_any_frame() -> None:
    network = Network(1, 2)
    network.respond(0, 1, bytes(8))
    network.respond(0, 2, bytes(8))
    network.scheduler.start()
    assert network.run(30) == [(1, 0), (2, 10), (1, 20)]


def test_an_unanswered_slot_is_an_error_and_the_next_one_comes() -> None:
    network = Network(slot(1), slot(2))
    network.respond(0, 2, b"\2")
    network.scheduler.start()
    assert network.run(20) == [(2, 10)]
    assert network.master.status().errors[LinErrorKind.SLNORE] == 1


def test_rounds() -> None:
    network = Network(slot(1), slot(2))
    for id in (1, 2):
        network.respond(0, id, b"\1")
    network.scheduler.start(rounds=2)
    assert network.scheduler.running == "main"
    assert network.run(1000) == [(1, 0), (2, 10), (1, 20), (2, 30)]
    assert network.scheduler.running is None
    network.scheduler.start(rounds=1)
    assert network.run(2000) == [(1, 999), (2, 1009)]


def test_the_first_round_counts_as_work_the_others_are_background() -> None:
    network = Network(slot(1), slot(2))
    for id in (1, 2):
        network.respond(0, id, b"\1")
    network.scheduler.start()
    assert network.timeline.run_until_idle(10**12)
    assert network.heard() == [(1, 0), (2, 10)]
    assert network.timeline.run_until_idle(10**12)
    assert network.heard() == []
    assert network.run(45) == [(1, 20), (2, 30), (1, 40)]


def test_the_resolution_of_a_first_round_s_collision_is_work_too() -> None:
    network = Network(slot(1), LinSlot.event(0x20, [0x11, 0x12], delay_ns=10 * MS))
    for k, id in enumerate((0x11, 0x12)):
        network.slaves[k].driver.associate(0x20, id)
        network.respond(k, id, bytes([0, k]))
    network.scheduler.start()
    assert network.timeline.run_until_idle(10**12)
    assert network.heard() == [(0x11, 20), (0x12, 30)]


def test_stop_and_start_again() -> None:
    network = Network(slot(1))
    network.respond(0, 1, b"\1")
    network.scheduler.start()
    assert network.run(11) == [(1, 0)]
    network.scheduler.stop()
    network.scheduler.stop()
    assert network.run(100) == [(1, 10)]  # it was on the wire
    network.scheduler.start()
    assert network.run(120)[0] == (1, 99)


def test_another_table_takes_over_with_the_next_slot() -> None:
    network = Network(slot(1), slot(2))
    network.scheduler.add(LinSchedule.of([slot(3, 20)], "other"))
    for id in (1, 2, 3):
        network.respond(0, id, b"\1")
    network.scheduler.start("main")
    network.run(5)
    network.scheduler.start("other")
    assert network.scheduler.running == "main"
    assert network.run(50) == [(3, 10), (3, 30)]
    assert network.scheduler.running == "other"


def test_tables_that_there_are_not() -> None:
    network = Network(slot(1))
    with pytest.raises(BadValue, match="no schedule 'x'; there are 'main'"):
        network.scheduler.start("x")
    with pytest.raises(BadValue, match="rounds 0"):
        network.scheduler.start(rounds=0)
    with pytest.raises(BadValue, match="no schedule None; there are none"):
        LinScheduler(network.master, {}).start()


# sporadic


def test_sporadic_slots_send_the_most_urgent_update_or_nothing() -> None:
    network = Network(LinSlot.sporadic([5, 3], delay_ns=10 * MS))
    network.scheduler.start()
    assert network.run(20) == []
    for id in (3, 5):
        network.master.write(LinFrame(id, b"\1"), send=False)
    assert network.run(100) == [(5, 20), (3, 30)]
    network.master.write(LinFrame(5, b"\1"), send=False)  # the same data are no update
    assert network.run(200) == []
    network.master.write(LinFrame(5, b"\2"), send=False)
    assert network.run(300) == [(5, 200)]
    assert network.master.status().errors[LinErrorKind.SLNORE] == 0


# event-triggered


def window_network() -> Network:
    event = LinSlot.event(0x20, [0x11, 0x12], delay_ns=10 * MS)
    network = Network(event, slot(1))
    network.respond(0, 1, b"\1")
    for k, id in enumerate((0x11, 0x12)):
        network.slaves[k].driver.associate(0x20, id)
    network.scheduler.start()
    return network


def test_nobody_has_news() -> None:
    network = window_network()
    assert network.run(40) == [(1, 10), (1, 30)]
    assert network.master.status().errors == (0,) * 9


def test_one_has_news() -> None:
    network = window_network()
    network.respond(1, 0x12, b"\0\7")
    network.timeline.run_until(9 * MS)
    message = network.monitor.take()
    assert isinstance(message, LinFrame)
    assert (message.id, message.data) == (0x20, bytes([protected_id(0x12), 7]))
    assert network.run(40) == [(1, 10), (1, 30)]
    assert network.scheduler.collisions == 0


@pytest.mark.conforms("N-47")
def test_two_have_news_and_each_is_asked_in_turn() -> None:
    network = window_network()
    network.respond(0, 0x11, b"\0\1")
    network.respond(1, 0x12, b"\0\2")
    assert network.run(60) == [(0x11, 10), (0x12, 20), (1, 30), (1, 50)]
    assert network.scheduler.collisions == 1
    network.respond(0, 0x11, b"\0\3")
    assert network.run(80) == [(0x20, 60), (1, 70)]


def test_a_collision_of_equal_bytes_goes_unnoticed() -> None:
    """Two with the same identifier and data answer as one."""
    network = Network(LinSlot.event(0x20, [0x11], delay_ns=10 * MS))
    for k in (0, 1):
        network.slaves[k].driver.associate(0x20, 0x11)
        network.respond(k, 0x11, b"\0\1")
    network.scheduler.start()
    assert network.run(20) == [(0x20, 0)]


# diagnostic


def test_diagnostic_slots_are_silent_without_anything_to_send_or_to_fetch() -> None:
    """PT-CT 83, 84."""
    network = Network(LinSlot.request(delay_ns=10 * MS), LinSlot.response(delay_ns=10 * MS))
    network.scheduler.start()
    assert network.run(100) == []
    assert network.master.status().headers == 0


def test_a_request_and_its_response() -> None:
    network = Network(LinSlot.request(delay_ns=10 * MS), LinSlot.response(delay_ns=10 * MS), slot(1))
    network.respond(0, 1, b"\1")
    network.scheduler.start()
    network.run(30)
    network.scheduler.request(REQUEST)
    network.scheduler.request(b"\x02\x01\xb6", responses=0)
    assert network.scheduler.waiting == 2
    assert network.run(40) == [(0x3C, 30)]
    assert network.run(61) == [(1, 50)]  # the header of 3D went unanswered, which is no error
    assert network.master.status().errors == (0,) * 9
    network.respond(0, 0x3D, ANSWER, once=True)
    network.run(62)
    # the second request goes out first, and its zero responses end the fetching
    assert (0x3C, 60) in network.run(69)
    assert network.run(200) == [(1, 80), (1, 110), (1, 140), (1, 170)]
    assert network.scheduler.waiting == 0


def test_a_response_is_asked_for_until_it_is_ready() -> None:
    network = Network(LinSlot.request(delay_ns=10 * MS), LinSlot.response(delay_ns=10 * MS))
    network.scheduler.start()
    network.scheduler.request(REQUEST)
    network.run(75)
    network.respond(0, 0x3D, ANSWER, once=True)
    assert network.run(200) == [(0x3D, 90)]
    assert network.scheduler.waiting == 0
    assert network.master.status().headers == 1 + 5


def test_a_fixed_request_is_sent_each_time() -> None:
    network = Network(LinSlot.request(REQUEST, delay_ns=10 * MS), LinSlot.response(delay_ns=10 * MS))
    network.respond(0, 0x3D, ANSWER)
    network.scheduler.start(rounds=2)
    assert network.run(100) == [(0x3C, 0), (0x3D, 10), (0x3C, 20), (0x3D, 30)]


def test_short_requests_are_filled_up() -> None:
    network = Network(LinSlot.request(delay_ns=10 * MS))
    network.scheduler.request(b"\1\2\xb6", responses=0)
    network.scheduler.start()
    network.timeline.run_until(9 * MS)
    message = network.monitor.take()
    assert isinstance(message, LinFrame)
    assert message.data == b"\1\2\xb6\xff\xff\xff\xff\xff"


@pytest.mark.parametrize("data", [b"", bytes(9)])
def test_requests_that_cannot_be(data: bytes) -> None:
    network = Network(LinSlot.request())
    with pytest.raises(BadFrame, match="a master request has 1 to 8"):
        network.scheduler.request(data)
    with pytest.raises(BadValue, match="responses -1"):
        network.scheduler.request(b"\1", responses=-1)


# trouble


def test_a_slot_that_is_too_short_skips_the_next() -> None:
    network = Network(slot(1, 5), slot(2, 5))
    network.respond(0, 1, bytes(8))
    network.respond(0, 2, b"\1")
    network.scheduler.start()
    assert network.run(20) == [(1, 0), (1, 10)]
    assert network.scheduler.skipped == 2


def test_a_line_that_was_stopped_skips_its_slots() -> None:
    network = Network(slot(1), LinSlot.request(REQUEST, delay_ns=10 * MS))
    network.scheduler.start()
    network.master.leave()
    network.run(100)
    assert network.scheduler.skipped == 10
    network.master.start()
    network.run(120)
    assert network.scheduler.skipped == 10


def test_the_schedule_rests_while_the_bus_sleeps() -> None:
    network = Network(slot(1), slot(2))
    for id in (1, 2):
        network.respond(0, id, b"\1")
    network.scheduler.start()
    network.run(15)
    network.master.go_to_sleep()
    network.run(1000)
    assert network.master.status().state is LinState.ASLEEP
    assert network.run(2000) == []
    network.slaves[0].wake_up()
    found = network.run(2040)
    assert [id for id, _ in found] == [2, 1, 2, 1]  # the one behind the slot that the command took
    assert found[0][1] == 2000
    assert network.slaves[0].status().errors[LinErrorKind.WAKEUP] == 0
