"""Nodes of the lab and channels on shared lines that speak by name."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator

import pytest

import canwire
from canwire import (
    BadSignals,
    BadValue,
    ChannelMode,
    Closed,
    Database,
    FilterMode,
    Frame,
    Lab,
    LinFrame,
    NotReceived,
    WantedMode,
    load_database,
)
from tests.databases.conftest import ROOT


@pytest.fixture
def lab() -> Iterator[Lab]:
    with Lab() as made:
        yield made


@pytest.mark.conforms("PF-12", "PF-16")
def test_messages_go_and_come_by_name(lab: Lab, engine: Database) -> None:
    bus = lab.can_bus("can0", bit_rate=500_000)
    sender, tester = engine.on(bus.node("engine")), engine.on(bus.node("tester"))
    sent = sender.send_message("EngineData", {"Ready": "yes"}, EngineSpeed=1500)
    got = tester.expect_message("EngineData", EngineSpeed=1500, Ready=1, within=0.5)
    assert got.frame == sent
    assert got.timestamp_ns == lab.now_ns
    sender.send_message("GearboxStatus", Gear="reverse")
    sender.node.send(Frame(0x7FF))
    sender.send_message("GearboxStatus", OilPressure=3)
    assert [str(message) for message in tester.decoded(timeout=0.01)] == [
        "GearboxStatus(Page: 0, Torque: 0 Nm, Gear: reverse)",
        "GearboxStatus(Page: 1, Torque: 0 Nm, OilPressure: 3 bar)",
    ]
    assert tester.unknown == 1
    assert tester.receive_message() is None


def test_a_timeout_is_for_messages_not_for_frames_that_nobody_knows(lab: Lab, engine: Database) -> None:
    bus = lab.can_bus("can0", bit_rate=500_000)
    sender, tester = bus.node("engine"), engine.on(bus.node("tester"))
    lab.at(4_000_000, lambda: sender.send(Frame(0x7FF)))
    assert tester.receive_message(0.005) is None
    assert lab.now_ns == 5_000_000
    assert tester.unknown == 1


def test_an_expectation_ends_in_the_bus_s_time_and_says_what_came_instead(lab: Lab, engine: Database) -> None:
    bus = lab.can_bus("can0", bit_rate=500_000)
    sender, tester = engine.on(bus.node("engine")), engine.on(bus.node("tester"))
    for _ in range(3):
        sender.send_message("EEC1", EngSpeed=100)
    sender.send_message("EngineData", Ready="no")
    sender.node.send(Frame(0x7FF))
    lab.at(600_000_000, lambda: sender.send_message("EngineData", Ready="yes") and None)
    with pytest.raises(NotReceived) as failure:
        tester.expect_message("EngineData", Ready=1, within=0.5)
    assert str(failure.value) == (
        "can0/tester: no EngineData with Ready=1 within 0.5 s; seen: EngineData(EngineSpeed: 800 rpm, "
        "Temperature: 20 degC, Ready: no, Alive: 0, Check: 0), others: EEC1 x3, 1 frames that the file does not know"
    )
    assert lab.now_ns == 500_000_000
    tester.expect_message("EngineData", Ready="yes", within=0.2)
    with pytest.raises(NotReceived, match=r"no EEC1 within 0\.1 s; nothing came"):
        tester.expect_message("EEC1", within=0.1)


@pytest.mark.parametrize(
    ("name", "wanted", "told"),
    [
        ("EngineDta", {}, r"did you mean EngineData\?"),
        ("EngineData", {"Redy": 1}, r"no such signal; did you mean Ready\?"),
        ("EngineData", {"Ready": "maybe"}, "no value 'maybe'; 0 to 3, no, yes, unknown is possible"),
        ("EngineData", {"EngineSpeed": 1e6}, "1000000 is out of range: 0 to 16000 rpm"),
    ],
)
def test_what_can_never_come_is_not_waited_for(
    lab: Lab, engine: Database, name: str, wanted: dict[str, float | str], told: str
) -> None:
    tester = engine.on(lab.can_bus("can0").node("tester"))
    with pytest.raises(BadValue, match=told):
        tester.expect_message(name, wanted, within=1)
    assert lab.now_ns == 0


@pytest.mark.conforms("PF-12")
def test_j1939_end_to_end(lab: Lab, engine: Database) -> None:
    """Each end has its address; the receiver knows a message by its PGN, and who sent it."""
    bus = lab.can_bus("can0", bit_rate=250_000)
    first, second = engine.on(bus.node("first"), source=0x00), engine.on(bus.node("second"), source=0x01)
    tester = engine.on(bus.node("tester", filters=engine.acceptance("EEC1")), source=0xF9)
    first.send_message("EEC1", EngSpeed=1000)
    second.send_message("EEC1", EngSpeed=2000)
    second.send_message("EngineData")
    got = list(tester.decoded(timeout=0.01))
    assert [(message.source, message["EngSpeed"]) for message in got] == [(0, 1000), (1, 2000)]
    assert [message.frame.id for message in got] == [0x0CF00400, 0x0CF00401]
    request = engine.encode(
        "TorqueRequest", {"RequestedTorque": 50}, source=0xF9, destination=0x01, priority=2
    )
    assert request.id == 0x080001F9
    tester.node.send(request)
    assert second.expect_message("TorqueRequest", RequestedTorque=50, within=0.1).source == 0xF9


def test_lin(lab: Lab) -> None:
    pytest.importorskip("ldfparser")
    door = load_database(ROOT / "tests" / "data" / "example.ldf")
    bus = lab.lin_bus("lin0", bit_rate=19200)
    master, left = bus.master(), door.on(bus.slave("left"))
    assert isinstance(left.send_message("LeftState", LeftPosition=50), LinFrame)
    master.ask(0x20, 3)
    heard = door.on(master).expect_message("LeftState", LeftPosition=50, within=0.1)
    assert heard["LeftMoving"] == 0


def test_asyncio_in_the_lab(lab: Lab, engine: Database) -> None:
    bus = lab.can_bus("can0", bit_rate=500_000)
    sender, tester = engine.on(bus.node("engine")), engine.on(bus.node("tester"))

    async def send() -> None:
        for speed in (1000, 2000, 3000):
            await asyncio.sleep(0.01)
            sender.send_message("EngineData", EngineSpeed=speed)
        await asyncio.sleep(0.01)
        tester.node.close()

    async def main() -> list[object]:
        sending = asyncio.create_task(send())
        got = [message["EngineSpeed"] async for message in tester.decoded()]
        await sending
        return got

    assert lab.run(main()) == [1000, 2000, 3000]


def channel(hub: canwire.Hub, number: int) -> canwire.HubChannel:
    """On the line of that number, which runs."""
    place = [one for one in canwire.every_line(hub, "CAN") if one.info.bus == "can0"][number]
    made = hub.open_channel(place.board.id, place.line)
    made.set_up(ChannelMode(receive=64, transmit=64))
    canwire.start_line(hub, place, WantedMode().mode(place.info.capabilities))
    made.activate()
    return made


def test_a_shared_line_in_virtual_time(engine: Database) -> None:
    with canwire.connect(time="virtual") as hub:
        sender, tester = engine.on(channel(hub, 0)), engine.on(channel(hub, 1))
        sender.send_message("EngineData", EngineSpeed=1500)
        assert tester.expect_message("EngineData", EngineSpeed=1500, within=0.5)["Ready"] == "no"
        before_ns = hub.now_ns()
        with pytest.raises(NotReceived, match="no EngineData with Ready=yes within 3 s; nothing came"):
            tester.expect_message("EngineData", Ready="yes", within=3)
        assert hub.now_ns() - before_ns == pytest.approx(3e9, rel=1e-3)
        sender.send_message("GearboxStatus")
        assert [message.name for message in tester.decoded(timeout=0.1)] == ["GearboxStatus"]


@pytest.mark.conforms("PL-21")
def test_a_channel_filters_by_name_in_the_hub(engine: Database) -> None:
    """Identifiers and masks go into the channel's own filter, J1939's with priority and source open."""
    with canwire.connect(time="virtual") as hub:
        sender, tester = engine.on(channel(hub, 0)), engine.on(channel(hub, 1))
        tester.node.deactivate()
        for extended in (False, True):
            tester.node.set_filter_mode(FilterMode.INCLUSIVE, extended=extended)
            tester.node.set_acceptance(0, (1 << 30) - 1 if extended else (1 << 12) - 1, extended=extended)
        for id, mask, extended in engine.id_masks("GearboxStatus", "EEC1"):
            tester.node.add_ids(id << 1, mask << 1, extended=extended)
        tester.node.activate()
        sender.send_message("EngineData")
        sender.send_message("GearboxStatus")
        sender.node.send(engine.encode("EEC1", {}, source=0x55, priority=7))
        sender.send_message("TorqueRequest")
        assert [message.name for message in tester.decoded(timeout=0.1)] == ["GearboxStatus", "EEC1"]
        assert tester.node.status().lost == 0


def test_asyncio_on_a_shared_line(engine: Database) -> None:
    async def main() -> list[object]:
        with canwire.connect(time="virtual") as hub:
            sender, tester = engine.on(channel(hub, 0)), engine.on(channel(hub, 1))
            for speed in (1000, 2000):
                sender.send_message("EngineData", EngineSpeed=speed)
            got: list[object] = []
            async for message in tester.decoded():
                got.append(message["EngineSpeed"])
                if len(got) == 2:
                    tester.node.close()
            return got

    assert asyncio.run(main()) == [1000, 2000]


def test_what_is_neither_node_nor_channel(engine: Database) -> None:
    with pytest.raises(TypeError, match="a node of the lab or a channel on a shared line is needed"):
        engine.on("can0")


def test_a_closed_node_says_so(lab: Lab, engine: Database) -> None:
    node = lab.can_bus("can0").node("engine")
    port = engine.on(node)
    node.close()
    with pytest.raises(Closed):
        port.send_message("EngineData")
    with pytest.raises(BadSignals):
        port.send_message("EngineData", EngineSpeed=-1)
    assert repr(port).startswith("<can0/engine by ")
