"""Nodes as classes: what they do on messages, timers and events, many of them in one process."""

from __future__ import annotations

import pytest

from canwire import BadValue, BusEvent, ErrorState, EventKind, Frame, Lab, LabBus, NodeScript

pytestmark = [pytest.mark.core, pytest.mark.conforms("PL-26")]

MS = 1_000_000


class Recorder(NodeScript):
    """Writes down every call with its time."""

    def __init__(self) -> None:
        self.calls: list[tuple[str, int, object]] = []

    def note(self, what: str, about: object = None) -> None:
        self.calls.append((what, self.now_ns, about))

    def on_start(self) -> None:
        self.note("start")

    def on_message(self, frame: Frame) -> None:
        self.note("message", frame)

    def on_event(self, event: BusEvent) -> None:
        self.note("event", event.kind)

    def on_timer(self) -> None:
        self.note("timer")


def test_on_start_runs_once_with_the_node_in_place(lab: Lab, can_bus: LabBus) -> None:
    lab.run_for(0.005)
    script = Recorder()
    node = can_bus.node("a", script)
    assert script.node is node
    assert script.calls == [("start", 5 * MS, None)]
    lab.run_for(1.0)
    assert len(script.calls) == 1


def test_on_message_runs_at_the_end_of_each_frame_in_order(lab: Lab, can_bus: LabBus) -> None:
    script = Recorder()
    can_bus.node("b", script)
    a = can_bus.node("a")
    a.send_many(Frame(k) for k in range(5))
    lab.run_until_idle()
    messages = [(at_ns, frame) for what, at_ns, frame in script.calls if what == "message"]
    assert [frame for _, frame in messages] == [Frame(k) for k in range(5)]
    assert all(isinstance(frame, Frame) and at_ns == frame.timestamp_ns for at_ns, frame in messages)


def test_only_what_passes_the_filters(lab: Lab, can_bus: LabBus) -> None:
    script = Recorder()
    can_bus.node("b", script, filters=[(0x002, 0x7FE)])
    can_bus.node("a").send_many(Frame(k) for k in range(5))
    lab.run_until_idle()
    assert [about for what, _, about in script.calls if what == "message"] == [Frame(2), Frame(3)]


def test_frames_that_waited_before_are_not_forgotten(lab: Lab, can_bus: LabBus) -> None:
    """More frames than one in a single moment of the script's node: none is skipped."""
    script = Recorder()
    node = can_bus.node("b", script)
    a = can_bus.node("a")
    node.stop()
    a.send(Frame(1))
    lab.run_for(0.001)
    node.start()
    a.send(Frame(2))
    lab.run_until_idle()
    assert [about for what, _, about in script.calls if what == "message"] == [Frame(1), Frame(2)]


class Answerer(NodeScript):
    def on_message(self, frame: Frame) -> None:
        if not frame.id & 0x400:
            self.send(Frame(frame.id | 0x400, frame.data[::-1]))


def test_an_answer_goes_out_at_once(lab: Lab, can_bus: LabBus) -> None:
    can_bus.node("ecu", Answerer())
    tester = can_bus.node("tester")
    tester.send(Frame(0x2AA, b"\xaa" * 8))  # 108 bits
    answer = tester.expect(0x6AA, within=0.01)
    assert answer.timestamp_ns < (108 + 3 + 135) * 2000


@pytest.mark.parametrize("period_s", [0.001, 0.0033, 1 / 3, 0.1])
def test_every_has_no_drift(lab: Lab, can_bus: LabBus, period_s: float) -> None:
    class Ticker(Recorder):
        def on_start(self) -> None:
            self.every(period_s)

    script = Ticker()
    can_bus.node("a", script)
    turns = 500
    period_ns = round(period_s * 1e9)
    lab.run_until(turns * period_ns)
    assert [at_ns for _, at_ns, _ in script.calls] == [k * period_ns for k in range(1, turns + 1)]


def test_every_calls_its_own_function_until_cancelled(lab: Lab, can_bus: LabBus) -> None:
    class Counter(Recorder):
        def on_start(self) -> None:
            self.beat = self.every(0.010, self.tick)

        def tick(self) -> None:
            self.note("tick")
            if len(self.calls) == 3:
                self.beat.cancel()
                self.beat.cancel()

    script = Counter()
    can_bus.node("a", script)
    lab.run_for(1.0)
    assert script.calls == [("tick", 10 * MS, None), ("tick", 20 * MS, None), ("tick", 30 * MS, None)]


def test_after_calls_once(lab: Lab, can_bus: LabBus) -> None:
    class Later(Recorder):
        def on_start(self) -> None:
            self.after(0.005)
            self.after(0.002, lambda: self.note("own"))
            self.after(0.003).cancel()

    script = Later()
    can_bus.node("a", script)
    lab.run_until_idle()
    assert script.calls == [("own", 2 * MS, None), ("timer", 5 * MS, None)]
    assert lab.now_ns == 5 * MS


@pytest.mark.parametrize("seconds", [0, -1, 1e-10])
def test_a_period_of_nothing_is_refused(lab: Lab, can_bus: LabBus, seconds: float) -> None:
    class Bad(NodeScript):
        def on_start(self) -> None:
            self.every(seconds)

    with pytest.raises(BadValue, match="every"):
        can_bus.node("a", Bad())


def test_on_event_hears_of_errors_and_states(lab: Lab, can_bus: LabBus) -> None:
    class Careful(Recorder):
        def on_event(self, event: BusEvent) -> None:
            super().on_event(event)
            if event.kind is EventKind.STATE and event.state is ErrorState.BUS_OFF:
                self.node.restart()

    script = Careful()
    a, b = can_bus.node("a", script), can_bus.node("b")
    can_bus.faults.flip(bit="dlc", times=32, seen_by="sender")
    a.send(Frame(0x123))
    lab.run_until_idle()
    kinds = [about for what, _, about in script.calls if what == "event"]
    assert kinds.count(EventKind.ERROR) == 32
    assert kinds.count(EventKind.STATE) == 4  # warning, passive, bus-off, and active again
    assert (a.state, b.receive()) == (ErrorState.ERROR_ACTIVE, Frame(0x123))


def test_on_event_hears_of_lost_arbitration(lab: Lab, can_bus: LabBus) -> None:
    script = Recorder()
    a, b = can_bus.node("a", script), can_bus.node("b")
    a.send(Frame(0x200))
    b.send(Frame(0x100))
    lab.run_until_idle()
    assert EventKind.ARBITRATION_LOST in [about for what, _, about in script.calls if what == "event"]


def test_an_error_in_a_script_surfaces_where_time_passes(lab: Lab, can_bus: LabBus) -> None:
    class Broken(NodeScript):
        def on_message(self, frame: Frame) -> None:
            raise RuntimeError(f"no idea what {frame.id:#x} means")

    can_bus.node("b", Broken())
    can_bus.node("a").send(Frame(0x55))
    with pytest.raises(RuntimeError, match="no idea what 0x55 means"):
        lab.run_until_idle()


def test_a_script_goes_on_after_its_error(lab: Lab, can_bus: LabBus) -> None:
    class Moody(Recorder):
        def on_message(self, frame: Frame) -> None:
            if frame.id == 1:
                raise RuntimeError("not this one")
            super().on_message(frame)

    script = Moody()
    can_bus.node("b", script)
    a = can_bus.node("a")
    a.send_many([Frame(1), Frame(2), Frame(3)])
    with pytest.raises(RuntimeError):
        lab.run_until_idle()
    lab.run_until_idle()
    a.send(Frame(4))
    lab.run_until_idle()
    assert [about for what, _, about in script.calls if what == "message"] == [Frame(2), Frame(3), Frame(4)]


def test_a_waiting_caller_and_a_script_do_not_take_each_other_s_frames(lab: Lab, can_bus: LabBus) -> None:
    script = Recorder()
    can_bus.node("ecu", script)
    tester, source = can_bus.node("tester"), can_bus.node("source")
    source.send_many([Frame(1), Frame(2)])
    assert tester.receive(timeout=0.1) == Frame(1)
    assert tester.receive(timeout=0.1) == Frame(2)
    lab.run_for(0)  # the caller was woken first, in the middle of this moment
    assert [about for what, _, about in script.calls if what == "message"] == [Frame(1), Frame(2)]


class Sensor(NodeScript):
    """Reports its number with a period of its own."""

    def __init__(self, number: int) -> None:
        self.number = number
        self.turn = 0

    def on_start(self) -> None:
        self.every(0.010 + 0.001 * self.number, self.report)

    def report(self) -> None:
        self.turn += 1
        self.send(Frame(0x100 + self.number, self.turn.to_bytes(4, "big")))


class Display(NodeScript):
    def __init__(self) -> None:
        self.shown: dict[int, int] = {}
        self.missed = 0

    def on_message(self, frame: Frame) -> None:
        turn = int.from_bytes(frame.data, "big")
        self.missed += turn != self.shown.get(frame.id, 0) + 1
        self.shown[frame.id] = turn


def network(seconds: float) -> tuple[object, ...]:
    with Lab() as lab:
        bus = lab.can_bus()
        display = Display()
        bus.node("display", display)
        for number in range(40):
            bus.node(f"sensor {number}", Sensor(number))
        lab.run_for(seconds)
        return display.shown, display.missed, bus.load, bus.frames, lab.now_ns


@pytest.mark.conforms("PL-26", "G-17")
def test_forty_nodes_in_one_process() -> None:
    shown, missed, _, _, now_ns = first = network(2.0)
    assert isinstance(shown, dict)
    assert len(shown) == 40
    assert missed == 0
    assert now_ns == 2_000_000_000
    for number in range(40):
        expected = 2000 // (10 + number)
        assert expected - 1 <= shown[0x100 + number] <= expected
    assert network(2.0) == first


def test_scripts_on_several_buses_make_a_gateway(lab: Lab) -> None:
    fast, slow = lab.can_bus("fast", bit_rate=1_000_000), lab.can_bus("slow", bit_rate=125_000)

    class Forward(NodeScript):
        def on_message(self, frame: Frame) -> None:
            exit_.send(frame)

    exit_ = slow.node("gateway")
    fast.node("gateway", Forward())
    source, sink = fast.node("source"), slow.node("sink")
    source.send_many(Frame(k, bytes([k])) for k in range(20))
    lab.run_until_idle()
    assert sink.receive_many(99) == [Frame(k, bytes([k])) for k in range(20)]
