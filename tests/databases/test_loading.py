"""Files of each kind become the same facts; files that are none are one clear error."""

from __future__ import annotations

import contextlib
import sys
from pathlib import Path

import cantools
import pytest

from canwire import BadDescription, Database, ExtraMissing, Frame, LinFrame, load_database
from tests.databases.conftest import DATA, ENGINE, ROOT

LDF = ROOT / "tests" / "data" / "example.ldf"
SYM = """FormatVersion=6.0 // Do not edit this line!
Title="Gauge"

{ENUMS}
Enum=State(0="off", 1="on")

{SENDRECEIVE}

[Gauge]
ID=123h
Len=4
CycleTime=100
Sig=Level 0
Sig=State 16

{SIGNALS}
Sig=Level unsigned 16 /u:mm /f:0.5
Sig=State unsigned 8 /e:State
"""


@pytest.mark.conforms("PF-12")
def test_what_a_dbc_says(engine: Database) -> None:
    data = engine.message("EngineData")
    assert (data.id, data.extended, data.length, data.cycle_s, data.senders) == (
        0x100,
        False,
        8,
        0.01,
        ("Engine",),
    )
    speed = data.signals["EngineSpeed"]
    assert (speed.unit, speed.minimum, speed.maximum, speed.start) == ("rpm", 0, 16000, 800)
    assert speed.comment == "Crankshaft speed"
    assert data.signals["Ready"].choices == {0: "no", 1: "yes", 3: "unknown"}
    assert data.signals["Alive"].start == 0  # the attribute's default
    gear = engine.message("GearboxStatus").signals["Gear"]
    assert (gear.multiplexer, gear.multiplexer_ids, gear.signed) == ("Page", (0,), True)
    assert (engine.message("EEC1").j1939, engine.message("EEC1").pgn) == (True, 0xF004)
    assert (engine.message("TorqueRequest").pgn, data.pgn) == (0, None)
    assert engine.nodes == ("Engine", "Gearbox", "Tester")
    assert [message.name for message in engine.sent_by("Engine")] == ["EngineData", "EEC1"]


@pytest.mark.conforms("PF-13")
@pytest.mark.parametrize("kind", ["kcd", "sym"])
def test_the_same_network_as_kcd_and_sym(engine: Database, tmp_path: Path, kind: str) -> None:
    """Written by cantools, in the format's own words; what a format cannot say is missing there."""
    path = tmp_path / f"engine.{kind}"
    cantools.database.dump_file(cantools.database.load_file(ENGINE), path)
    other = load_database(path)
    frame = engine.encode("EngineData", {"EngineSpeed": 1500, "Ready": "yes"})
    assert isinstance(frame, Frame)
    decoded = other.decode(frame)
    assert decoded is not None
    assert decoded.signals == {"EngineSpeed": 1500, "Temperature": 20, "Ready": "yes", "Alive": 0, "Check": 0}
    again = other.encode("EngineData", decoded.signals)
    assert again == frame


@pytest.mark.conforms("PF-13")
def test_arxml(engine: Database) -> None:
    other = load_database(DATA / "engine.arxml")
    assert other.nodes == engine.nodes
    assert [message.name for message in other.sent_by("Engine")] == ["FRAME_EngineData", "FRAME_EEC1"]
    frame = engine.encode("EngineData", {"EngineSpeed": 1500, "Ready": "yes"})
    decoded = other.decode(frame)
    assert str(decoded) == (
        "FRAME_EngineData(EngineSpeed: 1500 rpm, Temperature: 20 degC, Ready: yes, Alive: 0, Check: 0)"
    )
    assert decoded is not None
    assert other.encode("FRAME_EngineData", decoded.signals) == frame


@pytest.mark.conforms("PF-12")
def test_j1939_where_the_file_does_not_say_so(engine: Database) -> None:
    frame = engine.encode("EEC1", {"EngSpeed": 1500}, source=0x17, priority=6)
    assert load_database(DATA / "engine.arxml").decode(frame) is None
    told = load_database(DATA / "engine.arxml", j1939=True).decode(frame)
    assert told is not None
    assert (told["EngSpeed"], told.source) == (1500, 0x17)
    never = load_database(ENGINE, j1939=False)
    assert never.decode(frame) is None
    assert never.message("EEC1").pgn is None


@pytest.mark.conforms("PF-13")
def test_sym(tmp_path: Path) -> None:
    path = tmp_path / "gauge.sym"
    path.write_text(SYM)
    gauge = load_database(path)
    assert gauge.messages["Gauge"].cycle_s == 0.1
    decoded = gauge.decode(Frame(0x123, bytes.fromhex("64000100")))
    assert str(decoded) == "Gauge(Level: 50 mm, State: on)"


@pytest.mark.conforms("PF-13")
def test_ldf() -> None:
    door = load_database(LDF)
    frame = door.encode("LeftState", {"LeftPosition": 50})
    assert frame == LinFrame(0x20, bytes([0x20, 100, 0xFC]))
    decoded = door.decode(frame)
    assert str(decoded) == "LeftState(LeftPosition: 50 %, LeftMoving: 0, LeftError: 0)"
    told = door.decode(LinFrame(0x10, b"\xfd\x00"))
    assert told is not None
    assert (told["Move"], told.numbers["Move"]) == ("up", 1)
    assert [told.agrees({"Move": value}) for value in (1, "up", "down")] == [True, True, False]
    assert door.decode(LinFrame(1, b"\1")) is None
    short = door.decode(LinFrame(0x20, b"\1"))
    assert short is not None
    assert short.problem == "LeftState: 3 bytes, not 1"
    assert door.decode(Frame(0x20)) is None
    assert [message.name for message in door.sent_by("mirror")] == ["MirrorState"]


def test_a_file_with_217_messages() -> None:
    vehicle = load_database(DATA / "vehicle.dbc")
    ours = {name: set(message.signals) for name, message in vehicle.messages.items()}
    theirs = cantools.database.load_file(DATA / "vehicle.dbc").messages
    assert len(ours) == 217
    assert ours == {message.name: {signal.name for signal in message.signals} for message in theirs}


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("car.dbc", "this is no DBC", r"car\.dbc: "),
        ("car.kcd", "<NetworkDefinition", r"car\.kcd: "),
        ("car.arxml", "<AUTOSAR/>", r"car\.arxml: "),
        ("car.sym", "FormatVersion=6.0\n{SEND", r"car\.sym: "),
        ("car.ldf", "LIN_description", r"car\.ldf: "),
        ("car.txt", "", r"car\.txt: no network description by its ending; there are \.dbc, \.arxml"),
        ("car.dbc", 'VERSION ""\nBO_ 1 A: 1 X\n SG_ Wide : 0|16@1+ (1,0) [0|0] "" X\n', r"car\.dbc: .*Wide"),
    ],
)
def test_files_that_describe_nothing(tmp_path: Path, name: str, text: str, message: str) -> None:
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(BadDescription, match=message) as error:
        load_database(path)
    assert "\n" not in str(error.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(BadDescription, match=r"none\.dbc: No such file"):
        load_database(tmp_path / "none.dbc")


def test_signals_that_do_not_fit_where_that_is_wanted(tmp_path: Path) -> None:
    path = tmp_path / "car.dbc"
    path.write_text('VERSION ""\nBO_ 1 A: 1 X\n SG_ Wide : 0|16@1+ (1,0) [0|0] "" X\n')
    assert list(load_database(path, strict=False).messages) == ["A"]


@pytest.mark.parametrize(
    ("missing", "file", "extra"), [("cantools", ENGINE, "databases"), ("ldfparser", LDF, "lin")]
)
def test_without_the_library(monkeypatch: pytest.MonkeyPatch, missing: str, file: Path, extra: str) -> None:
    monkeypatch.setitem(sys.modules, missing, None)
    with pytest.raises(ExtraMissing, match=rf"pip install 'canwire\[{extra}\]'"):
        load_database(file)


def test_texts_in_another_encoding(tmp_path: Path) -> None:
    path = tmp_path / "car.dbc"
    path.write_bytes('VERSION ""\nBO_ 1 A: 1 X\n SG_ T : 0|8@1+ (1,0) [0|0] "°C" X\n'.encode())
    assert load_database(path, encoding="utf-8").message("A").signals["T"].unit == "°C"


@pytest.mark.finding("faults-2 5")
def test_a_file_has_a_size(tmp_path: Path) -> None:
    path = tmp_path / "big.dbc"
    path.write_bytes(b'VERSION ""\n' + b"\n" * 1000)
    load_database(path)
    with pytest.raises(BadDescription, match=r"big.dbc: 1011 bytes, more than most_bytes=1000"):
        load_database(path, most_bytes=1000)


@pytest.mark.finding("faults-2 5")
def test_what_a_description_means_may_be_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: object) -> None:
        raise OverflowError("too many bits")

    path = tmp_path / "a.dbc"
    path.write_text('VERSION ""\n')
    monkeypatch.setattr("canwire.databases.can_file.CanFile", fails)
    with pytest.raises(
        BadDescription, match=r"a.dbc: it means nothing here \(OverflowError: too many bits\)"
    ):
        load_database(path)


@pytest.mark.finding("faults-2 4")
@pytest.mark.skipif(sys.implementation.name != "cpython", reason="CPython's threads hear of it")
def test_a_file_has_a_limit_of_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def reads_for_ever(*_: object) -> None:
        while True:
            with contextlib.suppress(Exception):  # as parsers do that try one form after another
                ([0] * 10).sort()

    path = tmp_path / "a.dbc"
    path.write_text('VERSION ""\n')
    monkeypatch.setattr("canwire.databases.can_file.CanFile", reads_for_ever)
    with pytest.raises(BadDescription, match=r"a.dbc: to read it takes longer than seconds=0.02"):
        load_database(path, seconds=0.02)
    monkeypatch.undo()
    assert not load_database(path, seconds=600).messages
