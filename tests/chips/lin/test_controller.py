"""The ideal LIN controller by itself, on a bus of its own kind, through its two seams."""

from __future__ import annotations

import pytest

from canwire.bus.lin.bus import LinBus
from canwire.bus.lin.node import LinNode, LinOffer, LinResponse
from canwire.chips.lin.controller import LinController
from canwire.chips.lin.host import LinEar, LinHost
from canwire.chips.lin.responses import ResponseTable
from canwire.timeline import Timeline
from canwire.values.lin.event import LinErrorKind, LinOutcome, LinState
from canwire.values.lin.frame import lin_checksum, protected_id

pytestmark = pytest.mark.core

BIT_PS = 50_000_000


class Recorder(LinHost, LinEar):
    """Everything a controller tells, in order."""

    def __init__(self) -> None:
        self.told: list[tuple[object, ...]] = []

    def deliver(self, response: LinResponse, at_ns: int) -> None:
        self.told.append(("heard", response.id, response.octets[:-1], at_ns))

    def deliver_sent(self, response: LinResponse, at_ns: int) -> None:
        self.told.append(("sent", response.id, response.octets[:-1], at_ns))

    def error(self, kind: int, id: int, transmitting: bool, at_ns: int) -> None:
        self.told.append(("error", LinErrorKind(kind).name, id, transmitting))

    def state_changed(self, at_ns: int) -> None:
        self.told.append(("state", at_ns))

    def woken(self, at_ns: int) -> None:
        self.told.append(("woken", at_ns))

    def finished(self, id: int, outcome: LinOutcome, at_ns: int) -> None:
        self.told.append(("finished", id, outcome.name, at_ns))


def pair() -> tuple[Timeline, LinController, LinController]:
    """A master and a slave at 20 kbit/s, started."""
    timeline = Timeline()
    bus = LinBus(timeline)
    made = []
    for synchronises in (False, True):
        recorder = Recorder()
        controller = LinController(recorder, recorder)
        controller.configure(
            BIT_PS,
            synchronises=synchronises,
            searching=False,
            header=(13, 1, 0),
            response_spaces=(0, 0),
            start_up_ns=0,
        )
        bus.attach(controller)
        controller.start(0)
        recorder.told.clear()
        made.append(controller)
    return timeline, made[0], made[1]


def told(controller: LinController) -> list[tuple[object, ...]]:
    recorder = controller.host
    assert isinstance(recorder, Recorder)
    found, recorder.told = recorder.told, []
    return found


def run(timeline: Timeline) -> None:
    timeline.run_until_idle(timeline.now_ns + 10**9)


def test_a_header_and_its_answer() -> None:
    timeline, master, slave = pair()
    slave.table.put(0x10, b"\1\2", True, False)
    master.ask(0x10, 0, False)
    run(timeline)
    assert told(master) == [("heard", 0x10, b"\1\2", 3_200_000), ("finished", 0x10, "ANSWERED", 3_200_000)]
    assert told(slave) == [("sent", 0x10, b"\1\2", 3_200_000)]
    assert (master.frames_received, slave.frames_sent, slave.headers) == (1, 1, 1)


def test_times_are_right_after_years() -> None:
    """In picoseconds, 106 days need more than 63 bits, and 213 more than 64."""
    timeline, master, slave = pair()
    slave.table.put(0x10, b"\1\2", True, False)
    for days in (100, 110, 220, 10_000):
        timeline.run_until(days * 86_400 * 10**9)
        for controller in (master, slave):  # they slept
            controller.stop(timeline.now_ns)
            controller.start(timeline.now_ns)
            told(controller)
        asked_ns = timeline.now_ns
        master.ask(0x10, 0, False)
        run(timeline)
        ended_ns = asked_ns + 3_200_000
        assert told(master) == [("heard", 0x10, b"\1\2", ended_ns), ("finished", 0x10, "ANSWERED", ended_ns)]


def test_a_frame_of_its_own() -> None:
    timeline, master, slave = pair()
    master.send(0x11, b"\3", False)
    run(timeline)
    assert told(master) == [("sent", 0x11, b"\3", 2_700_000), ("finished", 0x11, "ANSWERED", 2_700_000)]
    assert told(slave) == [("heard", 0x11, b"\3", 2_700_000)]


def test_the_buffer_wins_over_the_table() -> None:
    timeline, master, slave = pair()
    master.table.put(0x11, b"\7", True, False)
    master.send(0x11, b"\3", True)
    run(timeline)
    master.ask(0x11, 0, False)
    run(timeline)
    assert [told_[2] for told_ in told(slave)] == [b"\3", b"\7"]
    assert master.frames_sent == 2


def test_silence() -> None:
    timeline, master, _ = pair()
    master.ask(0x12, 1, False)
    run(timeline)
    assert told(master) == [("error", "SLNORE", 0x12, False), ("finished", 0x12, "SILENT", 3_100_000)]
    master.ask(0x12, 1, True)
    run(timeline)
    assert [entry[0] for entry in told(master)] == ["finished"]
    assert master.errors[LinErrorKind.SLNORE] == 1


def test_what_waits_in_a_stopped_controller_is_given_up() -> None:
    timeline, master, _ = pair()
    master.ask(0x12, 1, False)
    timeline.run_until(1_000_000)
    master.stop(timeline.now_ns)
    assert told(master) == [("state", 1_000_000), ("finished", 0x12, "FAILED", 1_000_000)]
    assert master.offer is None
    master.stop(timeline.now_ns)
    assert told(master) == []
    assert (master.state(0), master.status()) == (LinState.STOPPED, 0x10)


def test_without_a_bus_nothing_happens() -> None:
    recorder = Recorder()
    lonely = LinController(recorder, recorder)
    lonely.start(0)
    lonely.ask(1, 0, False)
    lonely.wake_up()
    lonely.sleep(5)
    lonely.clear()
    lonely.stop(6)
    assert recorder.told[-1] == ("finished", -1, "FAILED", 6)


def test_only_responses_of_the_right_shape_are_whole() -> None:
    heard = LinResponse.heard(0x10, b"\1\2" + bytes([lin_checksum(b"\1\2")]))
    assert heard.enhanced is False
    heard = LinResponse.heard(0x10, b"\1\2" + bytes([lin_checksum(b"\1\2", protected_id(0x10))]))
    assert heard.enhanced is True
    assert LinResponse.heard(0x10, b"\1\2\0").enhanced is None
    diagnostic = bytes(7) + b"\1"
    wrong = diagnostic + bytes([lin_checksum(diagnostic, protected_id(0x3D))])
    assert LinResponse.heard(0x3D, wrong).enhanced is None  # classic always


def test_spaces_count() -> None:
    response = LinResponse.to_send(1, b"\1\2", True, space_bits=5, gap_bits=3)
    assert (response.bits, response.length) == (5 + 30 + 2 * 3, 2)


# the table


@pytest.fixture
def table() -> ResponseTable:
    return ResponseTable()


def payload(table: ResponseTable, id: int) -> bytes | None:
    response = table.responses[id]
    return None if response is None else response.octets[:-1]


@pytest.mark.conforms("X3-38")
@pytest.mark.parametrize("id", range(64))
def test_every_identifier_has_a_place(table: ResponseTable, id: int) -> None:
    table.put(id, b"\1", id < 0x3C, False)
    assert [number for number in range(64) if payload(table, number) is not None] == [id]
    table.put(id, b"\2", id < 0x3C, False)
    assert payload(table, id) == b"\2"
    table.remove(id)
    assert payload(table, id) is None


@pytest.mark.conforms("X3-38")
def test_clear_empties_the_table(table: ResponseTable) -> None:
    before = table.responses
    table.put(1, b"\1", True, False)
    table.associate(2, 1)
    table.clear()
    assert table.responses is before  # the bus looks at this very list
    assert table.responses == [None] * 64
    assert not table.is_event(2)
    assert table.updated == set()


def test_once_is_once(table: ResponseTable) -> None:
    table.put(0x3D, b"\1", False, True)
    table.sent(0x3D)
    assert payload(table, 0x3D) is None
    table.put(0x3D, b"\1", False, True)
    assert payload(table, 0x3D) == b"\1"


def test_updated_until_sent(table: ResponseTable) -> None:
    table.put(1, b"\1", True, False)
    assert table.updated == {1}
    table.sent(1)
    table.put(1, b"\1", True, False)
    assert table.updated == set()  # the same data are no news
    table.put(1, b"\2", True, False)
    assert table.updated == {1}


def test_event_triggered_responses(table: ResponseTable) -> None:
    """Data byte 1 is the frame's own protected identifier; only changed data are answered with."""
    table.associate(0x20, 0x11)
    assert payload(table, 0x20) is None
    table.put(0x11, b"\0\7", True, False)
    own = bytes([protected_id(0x11), 7])
    assert (payload(table, 0x20), payload(table, 0x11)) == (own, own)
    event = table.responses[0x20]
    assert event is not None
    assert event.octets[-1] == lin_checksum(own, protected_id(0x20))
    table.sent(0x20)
    assert (payload(table, 0x20), payload(table, 0x11)) == (None, own)
    table.put(0x11, b"\0\7", True, False)
    assert payload(table, 0x20) is None
    table.put(0x11, b"\0\x08", True, False)
    table.sent(0x11)  # told as an unconditional frame meanwhile
    assert payload(table, 0x20) is None
    table.put(0x11, b"\0\x09", True, False)
    table.remove(0x11)
    assert (payload(table, 0x20), payload(table, 0x11)) == (None, None)


def test_the_status_bit(table: ResponseTable) -> None:
    table.put(1, b"\xff\x00", True, False)
    table.put_status_bit(1, 0)
    assert payload(table, 1) == b"\xfe\x00"
    table.set_response_error(True)
    assert payload(table, 1) == b"\xff\x00"
    table.put_status_bit(1, 12)
    assert payload(table, 1) == b"\xff\x10"
    table.sent(1)
    assert payload(table, 1) == b"\xff\x00"
    assert not table.response_error
    table.put_status_bit(1, 63)  # beyond the data: nowhere
    table.set_response_error(True)
    assert payload(table, 1) == b"\xff\x00"


def test_new_spaces_reach_every_entry(table: ResponseTable) -> None:
    table.put(1, b"\1", True, False)
    table.spaces = (4, 2)
    table.refill()
    response = table.responses[1]
    assert response is not None
    assert response.bits == 4 + 20 + 2


def test_the_seams_are_abstract() -> None:
    node, host, ear = LinNode(), LinHost(), LinEar()
    response, offer = LinResponse.to_send(1, b"", True), LinOffer(1)
    calls = [
        lambda: node.received(response, 0),
        lambda: node.transmitted(response, 0),
        lambda: node.unanswered(1, 0, 0),
        lambda: node.error(1, 1, False, 0),
        lambda: node.finished(offer, 0),
        lambda: node.woken(0),
        lambda: node.quiet(0),
        lambda: node.rate_found(1, 0),
        lambda: host.error(1, 1, False, 0),
        lambda: host.state_changed(0),
        lambda: host.woken(0),
        lambda: host.finished(1, LinOutcome.SILENT, 0),
        lambda: ear.deliver(response, 0),
        lambda: ear.deliver_sent(response, 0),
    ]
    for call in calls:
        with pytest.raises(NotImplementedError):
            call()
