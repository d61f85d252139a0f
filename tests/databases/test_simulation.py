"""A node's messages at their cycle times."""

from __future__ import annotations

import itertools

import pytest

from canwire import BadSignals, BadValue, Database, Lab, OutgoingMessage
from tests.cases import each

pytestmark = pytest.mark.conforms("PF-15")


def alive(message: OutgoingMessage) -> None:
    """A counter of four bits, and the sum of the other bytes."""
    if message.name == "EngineData":
        message.signals["Alive"] = message.count % 16
        message.signals["Check"] = 0
        message.signals["Check"] = sum(message.encoded()[:7]) & 0xFF


def test_on_the_bench(engine: Database) -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        tester = engine.on(bus.node("tester"))
        simulation = engine.simulated("Engine", signals={"EngineSpeed": 1500}, plugins=[alive])
        bus.node("engine", simulation)
        lab.run_for(0.201)
        got = list(tester.decoded())
        data = [message for message in got if message.name == "EngineData"]
        times = [message.timestamp_ns for message in data]
        between = [later - before for before, later in itertools.pairwise(times)]
        assert all(
            abs(each - 10_000_000) <= 20_000 for each in between
        )  # stuff bits: they are ends of frames
        assert [message["Alive"] for message in data] == [count % 16 for count in range(21)]
        assert all(sum(message.frame.data[:7]) & 0xFF == message["Check"] for message in data)
        assert {message["EngineSpeed"] for message in data} == {1500}
        assert len(got) - len(data) == 11
        assert repr(simulation) == "<simulation of Engine: EngineData 21, EEC1 11>"
        assert (simulation.missed, simulation.refused) == (0, 0)
        simulation.set("EngineData.Ready", "yes")
        tester.expect_message("EngineData", Ready="yes", within=0.011)


def test_a_full_queue_is_counted(engine: Database) -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        simulation = engine.simulated("Engine")
        node = bus.node("engine", simulation, transmit_queue=4)
        node.stop()
        lab.run_for(0.1)
        assert simulation.refused > 0
        assert simulation.sent.total() - simulation.refused == node.sent


def test_cycles_that_came_too_late_are_counted_not_made_up_for(engine: Database) -> None:
    simulation = engine.simulated("Engine")
    assert simulation.next_ns() == 0
    assert len(simulation.due(0)) == 2
    assert simulation.due(9_999_999) == []
    assert simulation.next_ns() == 10_000_000
    assert len(simulation.due(55_000_000)) == 2
    assert (
        simulation.missed == 4 + 1
    )  # EngineData's of 20, 30, 40 and 50 ms became one, EEC1's of 20 and 40 ms too
    assert simulation.next_ns() == 60_000_000


def test_messages_without_a_cycle_are_named(engine: Database) -> None:
    with pytest.raises(
        BadValue, match=r"Tester has no message with a cycle time \(messages: TorqueRequest\)"
    ):
        engine.simulated("Tester")


@each(
    ("signals", "told"),
    [
        ({"EngineSped": 1}, r"Engine sends no signal 'EngineSped' in cycles; did you mean EngineSpeed"),
        ({"EEC1.EngineSpeed": 1}, "sends no signal"),
        ({"EngineSpeed": 17000}, "17000 is out of range: 0 to 16000 rpm"),
    ],
)
def test_values_that_do_not_fit(engine: Database, signals: dict[str, float], told: str) -> None:
    with pytest.raises(BadValue, match=told):
        engine.simulated("Engine", signals=signals)


def test_a_plug_in_s_values_are_checked(engine: Database) -> None:
    def wrong(message: OutgoingMessage) -> None:
        message.signals["Alive"] = message.count + 16

    with pytest.raises(BadSignals, match=r"\.Alive: "):
        engine.simulated("Engine", plugins=[wrong]).due(0)


def test_a_value_that_does_not_fit_changes_nothing(engine: Database) -> None:
    simulation = engine.simulated("Engine", signals={"EngineSpeed": 900})
    with pytest.raises(BadSignals):
        simulation.set("EngineSpeed", -1)
    decoded = [engine.decode(frame) for frame in simulation.due(0)]
    assert decoded[0] is not None
    assert decoded[0]["EngineSpeed"] == 900


def test_a_plug_in_sees_all_values_and_may_turn_a_multiplexer(engine: Database) -> None:
    seen: list[dict[str, object]] = []

    def turn(message: OutgoingMessage) -> None:
        seen.append(dict(message.signals))
        message.signals["Page"] = message.count % 2

    simulation = engine.simulated("Gearbox", signals={"Torque": 100}, plugins=[turn])
    told = [engine.decode(frame) for now_ns in (0, 100_000_000) for frame in simulation.due(now_ns)]
    assert seen[0] == {"Page": 0, "Gear": 0, "Torque": 100}
    assert [str(message) for message in told] == [
        "GearboxStatus(Page: 0, Torque: 100 Nm, Gear: neutral)",
        "GearboxStatus(Page: 1, Torque: 100 Nm, OilPressure: 0 bar)",
    ]


def test_a_plug_in_s_misspelt_signal_is_an_error(engine: Database) -> None:
    def wrong(message: OutgoingMessage) -> None:
        message.signals["Alvie"] = 1

    with pytest.raises(BadSignals, match=r"Alvie: no such signal; did you mean Alive"):
        engine.simulated("Engine", plugins=[wrong]).due(0)
