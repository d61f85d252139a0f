"""E2E profiles and containers as cantools knows them, counters and checksums by plug-ins: sent, received, checked."""

from __future__ import annotations

from pathlib import Path

import pytest
from cantools.autosar import end_to_end
from cantools.database import Database as TheirDatabase
from cantools.database.can import Message, Node, Signal
from cantools.database.can.formats.arxml.end_to_end_properties import AutosarEnd2EndProperties
from cantools.database.can.formats.arxml.message_specifics import AutosarMessageSpecifics

from canwire import BadSignals, BadValue, Database, Frame, Lab, MessageCheck, OutgoingMessage, load_database
from canwire.databases import can_file

pytestmark = pytest.mark.conforms("N-58")
IDS = {2: list(range(10, 26)), 5: [0x1234]}
ENGINE = Path(__file__).parents[2] / "examples" / "engine.dbc"


def guarded(name: str, id: int, profile: int) -> Message:
    """A message of eight bytes with one signal behind checksum and counter."""
    e2e = AutosarEnd2EndProperties()
    e2e.data_ids, e2e.payload_length, e2e.category = IDS[profile], 8, f"PROFILE_0{profile}"
    specifics = AutosarMessageSpecifics()
    specifics._e2e = e2e
    signal = Signal("Speed", 24, 16, minimum=0, maximum=60000)
    return Message(id, name, 8, [signal], senders=["Engine"], cycle_time=10, autosar_specifics=specifics)


def container() -> Message:
    parts = [
        Message(number, name, 2, [Signal("Value", 0, 16)], header_id=number)
        for number, name in ((0x000101, "One"), (0x000102, "Two"))
    ]
    return Message(0x300, "Box", 16, [], contained_messages=parts, is_fd=True, senders=["Engine"])


@pytest.fixture
def database(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Database:
    theirs = TheirDatabase(
        [guarded("Two", 0x102, 2), guarded("Five", 0x105, 5), container()], nodes=[Node("Engine", None)]
    )
    monkeypatch.setattr(can_file, "_loaded", lambda *_: theirs)
    path = tmp_path / "car.arxml"
    path.touch()
    return load_database(path)


@pytest.mark.parametrize(("name", "profile"), [("Two", 2), ("Five", 5)])
def test_a_simulated_node_protects_its_messages(database: Database, name: str, profile: int) -> None:
    """Through 300 cycles counters go round, and cantools finds every checksum right."""
    assert database.message(name).protection == f"E2E profile {profile}"
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        listener = bus.node("listener", receive_queue=2000)
        bus.node("engine", database.simulated("Engine", signals={"Speed": 1500}))
        lab.run_for(3.0)
        frames = [frame for frame in listener.receive_many(2000) if frame.id == database.message(name).id]
    their = guarded(name, 0x100, profile)
    right = getattr(end_to_end, f"check_profile{profile}_crc")
    assert len(frames) >= 300
    assert all(right(frame.data, their) for frame in frames)
    values = 16 if profile == 2 else 256
    counters = [frame.data[1 if profile == 2 else 2] for frame in frames]
    assert counters == [number % values for number in range(len(frames))]
    check = database.check()
    assert {check.fault_of(frame) for frame in frames} == {""}
    assert {database.decode(frame)["Speed"] for frame in frames} == {1500}  # type: ignore[index]


def test_the_rest_of_the_counter_s_byte_stays(database: Database) -> None:
    frame = database.protect(Frame(0x102, bytes((0, 0xA0, 0, 1, 2, 3, 4, 5))), 17)
    assert frame.data[1] == 0xA1
    assert database.protection_of(frame) == ("", (1, 16))
    for other in (Frame(0x7FF, bytes(8)), Frame(0x102, remote=True)):
        assert database.protect(other, 3) is other
        assert database.protection_of(other) == ("", None)


def test_what_is_wrong_is_told(database: Database) -> None:
    check = database.check()
    frames = [database.protect(Frame(0x105, bytes(8)), count) for count in (254, 255, 0, 0, 3)]
    assert [check.fault_of(frame) for frame in frames] == ["", "", "", "counter 0 again", "counter 3, not 1"]
    wrong = Frame(0x105, frames[0].data[:7] + b"\x01")
    assert check.fault_of(wrong) == "wrong checksum (E2E profile 5)"
    assert check.fault_of(Frame(0x105, b"\1")) == "too short for E2E profile 5"
    assert check.faults == 4


def test_messages_in_containers_are_protected(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Each by its own profile, beside one without; cantools finds the checksums right."""
    inside = [guarded("Two", 0, 2), guarded("Five", 0, 5), Message(0, "None", 2, [Signal("Value", 0, 16)])]
    for number, message in enumerate(inside, 1):
        message._header_id = number
    box = Message(0x300, "Box", 48, [], contained_messages=inside, is_fd=True, senders=["Engine"])
    monkeypatch.setattr(can_file, "_loaded", lambda *_: TheirDatabase([box], nodes=[Node("Engine", None)]))
    (tmp_path / "car.arxml").touch()
    database = load_database(tmp_path / "car.arxml")
    parts = {"None": {"Value": 9}, "Five": {"Speed": 7}, "Two": {"Speed": 8}}
    plain = database.encode_container("Box", parts, fill=0)
    frames = [database.protect(plain, count) for count in (0, 1, 1, 2)]
    found = database.decode(frames[1])
    assert found is not None
    assert [(one.name, dict(one.numbers)) for one in found.contained] == list(parts.items())
    five, two = (box.unpack_container(frames[1].data)[number][1] for number in (1, 2))
    assert end_to_end.check_profile5_crc(bytes(five), inside[1])
    assert end_to_end.check_profile2_crc(bytes(two), inside[0])
    check = database.check()
    assert [check.fault_of(frame) for frame in frames] == [
        "",
        "",
        "Five: counter 1 again, Two: counter 1 again",
        "",
    ]
    wrong = frames[3].data[:15] + b"\x55" + frames[3].data[16:]
    told, _ = database.protection_of(Frame(0x300, wrong, fd=True))
    assert told == "Five: wrong checksum (E2E profile 5)"
    assert database.protection_of(frames[0]) == ("", None)


def test_a_port_counts_what_it_sends(database: Database) -> None:
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        sender, heard = database.on(bus.node("sender")), bus.node("heard")
        sent = [sender.send_message("Two", Speed=number) for number in range(3)]
        lab.run_for(0.1)
        assert [frame.data for frame in heard.receive_many(9)] == [frame.data for frame in sent]  # type: ignore[union-attr]
    assert [database.protection_of(frame)[1] for frame in sent] == [(0, 16), (1, 16), (2, 16)]  # type: ignore[arg-type]


def test_containers_hold_messages(database: Database) -> None:
    frame = database.encode_container("Box", {"Two": {"Value": 7}, "One": {"Value": 9}})
    assert frame.data.hex() == "00010202" + "0700" + "00010102" + "0900"
    found = database.decode(frame)
    assert found is not None
    assert [(one.name, one["Value"]) for one in found.contained] == [("Two", 7), ("One", 9)]
    assert str(found) == "Box(Two(Value: 7), One(Value: 9))"
    assert [one.name for one in database.message("Box").contained] == ["One", "Two"]


@pytest.mark.parametrize(
    ("data", "shown"),
    [
        ("0001010209000000000000000000000000000000", "Box(One(Value: 9))"),  # filled with zeros
        ("00010102090000077701FF00", "Box(unknown messages in it: 000777)"),
        ("000101080900", "Box(Malformed container"),
    ],
)
def test_containers_that_say_something_else(database: Database, data: str, shown: str) -> None:
    content = bytes.fromhex(data)[:16]
    found = database.decode(Frame(0x300, content.ljust(12 if len(content) < 12 else 16, b"\0"), fd=True))
    if "Malformed" in shown:
        found = database.decode(Frame(0x300, bytes.fromhex(data), fd=True))
    assert str(found).startswith(shown)


def test_what_does_not_fit_into_a_container(database: Database) -> None:
    for name, parts, why in (
        ("Two", {}, "no container"),
        ("Box", {"Three": {}}, "it holds no message 'Three'"),
    ):
        with pytest.raises(BadValue, match=why):
            database.encode_container(name, parts)
    with pytest.raises(BadSignals, match="Value"):
        database.encode_container("Box", {"One": {"Value": 70000}})
    with pytest.raises(BadValue, match="encode_container"):
        database.encode("Box", {})


def alive(message: OutgoingMessage) -> None:
    if message.name == "EngineData":
        message.signals["Alive"] = message.count % 16
        message.signals["Check"] = 0
        message.signals["Check"] = sum(message.encoded()) & 0xFF


def test_a_plug_in_of_a_few_lines_checks_what_it_makes() -> None:
    engine = load_database(ENGINE)
    with Lab() as lab:
        bus = lab.can_bus("can0", bit_rate=500_000)
        listener = bus.node("listener", receive_queue=500)
        bus.node("engine", engine.simulated("Engine", plugins=[alive]))
        lab.run_for(0.5)
        frames = listener.receive_many(500)
    check = engine.check([alive])
    assert isinstance(check, MessageCheck)
    assert {check.fault_of(frame) for frame in frames} == {""}
    own = [frame for frame in frames if frame.id == engine.message("EngineData").id]
    check = engine.check([alive])
    assert check.fault_of(own[3]) == ""  # it may begin anywhere
    assert check.fault_of(own[4]) == ""
    assert check.fault_of(own[7]) == "counter 7, not 5"
    assert (
        check.fault_of(Frame(own[8].id, bytes((own[8].data[0] ^ 1,)) + own[8].data[1:])) == "wrong checksum"
    )
    assert check.fault_of(own[8]) == ""
    assert check.faults == 2
