"""LIN description files: a network of the file runs on the bench, and what is heard is decoded by it."""

from __future__ import annotations

import importlib
import sys
from pathlib import Path

import pytest

from canwire import (
    BadDescription,
    BadFrame,
    BadValue,
    ExtraMissing,
    Lab,
    LabLinNode,
    LinFrame,
    LinSlot,
    SlotKind,
)
from tests.cases import each

pytest.importorskip("ldfparser")

from canwire import ldf
from canwire.commands.lin.slots import described
from canwire.ldf import parsing

EXAMPLE = Path(__file__).parent / "data" / "example.ldf"


@pytest.fixture(scope="module")
def door() -> ldf.LinDescription:
    return ldf.load(EXAMPLE)


def test_the_grammar_is_compiled_once_for_all_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What files say is the same with ldfparser's own function, which compiles it for each of them."""
    ldfparser = importlib.import_module("ldfparser")
    compiled, lark = [], ldfparser.parser.Lark

    def counted(*given: object, **options: object) -> object:
        compiled.append(options)
        return lark(*given, **options)

    monkeypatch.setattr(ldfparser.parser, "Lark", counted)
    parsing._with_one_grammar.cache_clear()
    (tmp_path / "other.ldf").write_text("// by another hand\n" + EXAMPLE.read_text().replace("19.2", "9.6"))
    rates = [ldf.load(path).bit_rate for path in (EXAMPLE, tmp_path / "other.ldf", EXAMPLE)]
    assert (rates, len(compiled)) == ([19200, 9600, 19200], 1)
    parsed = parsing.parse_ldf()(str(EXAMPLE))
    assert parsed._source == ldfparser.parse_ldf(str(EXAMPLE))._source
    assert len(compiled) == 2
    parsing._with_one_grammar.cache_clear()


@pytest.mark.conforms("PF-14")
def test_what_the_file_says(door: ldf.LinDescription) -> None:
    assert (door.protocol, door.bit_rate, door.master) == ("2.1", 19200, "door")
    assert door.slaves == ("left", "right", "mirror")
    assert door.frames["LeftState"] == ldf.FrameDescription(
        "LeftState", 0x20, 3, "left", True, ("LeftPosition", "LeftMoving", "LeftError")
    )
    assert not door.frames["MirrorState"].enhanced  # a node of LIN 1.3
    assert (door.name_of(0x20), door.name_of(40), door.name_of(1)) == ("LeftState", "Windows", None)


@pytest.mark.conforms("PF-14")
def test_schedules(door: ldf.LinDescription) -> None:
    assert list(door.schedules) == ["Normal", "Resolve", "Setup"]
    commands, windows, mirror = door.schedules["Normal"].slots
    assert (commands.kind, commands.ids, commands.delay_ns) == (SlotKind.SPORADIC, (0x10, 0x11), 10_000_000)
    assert (windows.kind, windows.ids, windows.members) == (SlotKind.EVENT, (40,), (0x20, 0x21))
    assert windows.resolving == tuple(LinSlot.frame(id, delay_ns=10_000_000, length=3) for id in (0x20, 0x21))
    assert mirror == LinSlot.frame(0x30, delay_ns=15_000_000, length=6)


@pytest.mark.conforms("PF-14")
def test_configuration_commands(door: ldf.LinDescription) -> None:
    slots = door.schedules["Setup"].slots
    sent = [slot.data.hex(" ") if slot.data is not None else slot.kind.value for slot in slots]
    assert sent == [
        "11 06 b0 34 12 78 56 01",
        "response",
        "01 06 b7 00 50 20 ff ff",
        "7f 06 b3 01 03 01 ff 04",
        "02 06 b4 01 02 03 04 05",
        "02 01 b6 ff ff ff ff ff",
        "3c b2 00 00 ff 7f ff ff",
        "request",
        "response",
    ]


@pytest.mark.conforms("PF-14")
def test_signals_both_ways(door: ldf.LinDescription) -> None:
    frame = door.encode("LeftState", {"LeftPosition": 50.0, "LeftMoving": 1})
    assert frame == LinFrame(0x20, bytes([0x20, 100, 0xFD]))  # unused bits are 1
    assert door.decode(frame) == {"LeftPosition": 50.0, "LeftMoving": 1, "LeftError": 0}
    assert door.encode("Command", {"Move": "down"}) == LinFrame(0x10, b"\xfe\x0a")
    assert door.decode(LinFrame(0x10, b"\xfd\x00")) == {"Move": "up", "Speed": 0}
    assert door.decode(LinFrame(0x21, b"\x61\xff\x00"))["RightPosition"] == "unknown"


def test_an_event_triggered_frame_is_decoded_by_its_first_byte(door: ldf.LinDescription) -> None:
    heard = LinFrame(40, door.encode("RightState", {"RightPosition": 10.0}).data)
    assert door.decode(heard)["RightPosition"] == 10.0


def test_a_value_without_an_encoding_that_fits(door: ldf.LinDescription) -> None:
    assert door.decode(LinFrame(0x20, bytes([0x20, 220, 0])))["LeftPosition"] == 220
    assert door.decode(LinFrame(0x10, b"\xff\x00"))["Move"] == 3


def test_arrays(door: ldf.LinDescription) -> None:
    frame = door.encode("MirrorState", {"MirrorAngle": 0.0})
    assert not frame.enhanced
    decoded = door.decode(frame)
    assert decoded["MirrorAngle"] == pytest.approx(0.0)
    assert decoded["MirrorName"] == [77, 105, 114]


@each(
    ("use", "message"),
    [
        (lambda door: door.encode("Nothing", {}), "no frame 'Nothing'; there are Command"),
        (
            lambda door: door.encode("Command", {"Colour": 1}),
            "Command has no signal 'Colour'; it has Move, Speed",
        ),
        (lambda door: door.encode("Command", {"Move": "sideways"}), "Command: .*sideways"),
        (lambda door: door.encode("Command", {"Speed": 256}), "Command: .*256"),
        (lambda door: door.encode("LeftState", {"LeftPosition": 150.0}), "LeftState: .*150"),
        (lambda door: door.responses("roof"), "no node 'roof'; there are door, left, right, mirror"),
        (lambda door: door.lengths("roof"), "no node"),
        (lambda door: door.events("roof"), "no node"),
        (lambda door: door.response_error("roof"), "no node"),
    ],
)
def test_what_does_not_fit(door: ldf.LinDescription, use: object, message: str) -> None:
    with pytest.raises(BadValue, match=message):
        use(door)  # type: ignore[operator]


@each(
    ("frame", "message"),
    [
        (LinFrame(1, b"\1"), "no frame with identifier 0x01"),
        (LinFrame(0x20, b"\1"), "LeftState: 3 bytes, not 1"),
        (LinFrame(40, b"\1\2\3"), "no frame with identifier 0x01"),
    ],
)
def test_frames_that_the_file_does_not_know(door: ldf.LinDescription, frame: LinFrame, message: str) -> None:
    with pytest.raises(BadFrame, match=message):
        door.decode(frame)


@pytest.mark.conforms("PF-14")
def test_the_network_runs(door: ldf.LinDescription) -> None:
    with Lab() as lab:
        bus = lab.lin_bus("lin0", bit_rate=door.bit_rate)
        master = bus.master("door", schedule=door.schedules, responses=door.responses("door"))
        slaves: dict[str, LabLinNode] = {
            name: bus.slave(name, **door.slave_options(name)) for name in door.slaves
        }
        master.events()
        lab.run_for(0.2)
        heard = [(door.name_of(frame.id), door.decode(frame)) for frame in master.receive_many(99)]
        assert {name for name, _ in heard} == {"Windows", "MirrorState"}
        assert dict(heard)["MirrorState"]["MirrorAngle"] == pytest.approx(-154.4)
        # both windows had news; the left one's identifier prevailed on the wire, the right one came next
        told = [signals for name, signals in heard if name == "Windows"]
        assert [next(iter(signals)) for signals in told] == ["LeftPosition", "RightPosition"]
        assert slaves["left"].receive() == door.encode("Command", {})
        moved = door.encode("LeftState", {"LeftPosition": 25.0})
        slaves["left"].respond(moved.id, moved)
        event = master.expect(40, within=0.1)
        assert door.decode(event)["LeftPosition"] == 25.0
        command = door.encode("Command", {"Move": "up", "Speed": 20})
        master.respond(command.id, command)
        assert door.decode(slaves["right"].expect(0x10, within=0.1, data=command.data)) == {
            "Move": "up",
            "Speed": 20,
        }


def test_a_slave_s_error_bit_comes_from_the_file(door: ldf.LinDescription) -> None:
    assert door.response_error("left") == (0x20, 17)
    assert door.response_error("door") is None
    with Lab() as lab:
        bus = lab.lin_bus("lin0", bit_rate=door.bit_rate)
        bus.slave("left", **door.slave_options("left"))
        master = bus.master()
        bus.faults.checksum(0x10)
        master.send(door.encode("Command", {}))
        master.ask(0x20, 3)
        assert door.decode(master.expect(0x20, within=0.1))["LeftError"] == 1


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(BadDescription, match=r"missing\.ldf: No such file"):
        ldf.load(tmp_path / "missing.ldf")
    latin = tmp_path / "latin.ldf"
    latin.write_bytes(EXAMPLE.read_bytes().replace(b"A door", b"T\xfcr"))
    with pytest.raises(BadDescription, match="byte 4 is no utf-8; give its encoding"):
        ldf.load(latin)
    assert ldf.load(latin, encoding="latin-1").bit_rate == 19200


def test_a_schedule_that_cannot_be_run_leaves_the_others(tmp_path: Path) -> None:
    """LIN 2.0's AssignFrameId for a frame that has no message identifier in the file."""
    text = EXAMPLE.read_text(encoding="utf-8")
    old = "AssignNAD { left } delay 15 ms;"
    path = tmp_path / "assign.ldf"
    path.write_text(
        text.replace(old, f"{old}\nAssignFrameId {{ left, Command }} delay 15 ms;"), encoding="utf-8"
    )
    network = ldf.load(path)
    assert network.unusable == {
        "Setup": "AssignFrameId: left has no message identifier for Command in the file"
    }
    assert {*network.schedules, "Setup"} == {*ldf.load(EXAMPLE).schedules}
    with pytest.raises(BadValue, match="schedule 'Setup' cannot be run: AssignFrameId: left has no"):
        described(network, "Setup")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("LIN_description_file;", "This is no LDF"),
        ("LIN_speed = 19.2 kbps;", ""),
        ("Move: 2, 0, door, left, right;", "Move: 2, 0, nobody, left;"),
        ("Speed, 8;", "Speed, 12;"),
        ("MirrorState delay 15 ms;", "Unknown delay 15 ms;"),
        ("Command: 16, door, 2 {", "Command: 99, door, 2 {"),
        ("Windows: Resolve, 40,", "Windows: Nowhere, 40,"),
        ("}\n\nSporadic_frames", "\n\nSporadic_frames"),
    ],
)
def test_files_that_describe_no_network(tmp_path: Path, old: str, new: str) -> None:
    text = EXAMPLE.read_text(encoding="utf-8")
    assert old in text
    broken = tmp_path / "broken.ldf"
    broken.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(BadDescription, match=r"broken\.ldf: .+"):
        ldf.load(broken)


def test_without_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ldfparser", None)
    with pytest.raises(ExtraMissing, match=r"ldfparser is not installed; run: pip install 'canwire\[lin\]'"):
        ldf.load(EXAMPLE)
