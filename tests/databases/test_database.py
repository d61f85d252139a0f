"""Frames by name and back: the same as cantools for any values; what does not fit is named with its range."""

from __future__ import annotations

from pathlib import Path

import cantools
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import BadSignals, BadValue, Database, Frame, load_database
from tests.cases import each
from tests.databases.conftest import DATA, ENGINE
from tests.effort import examples

ENGINE_REFERENCE = cantools.database.load_file(ENGINE)
VEHICLE_REFERENCE = cantools.database.load_file(DATA / "vehicle.dbc")
VEHICLE = load_database(DATA / "vehicle.dbc")
FD = """VERSION ""
BU_: A
BO_ 300 Long: 30 A
 SG_ Last : 232|8@1+ (1,0) [0|0] "" A
BO_ 301 Slow: 3 A
 SG_ One : 0|8@1+ (1,0) [0|0] "" A
BA_DEF_ BO_ "VFrameFormat" ENUM "StandardCAN","ExtendedCAN","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","reserved","StandardCAN_FD","ExtendedCAN_FD";
BA_DEF_ BO_ "CANFD_BRS" ENUM "0","1";
BA_DEF_DEF_ "VFrameFormat" "StandardCAN_FD";
BA_DEF_DEF_ "CANFD_BRS" "1";
BA_ "CANFD_BRS" BO_ 301 0;
"""  # noqa: E501


@pytest.mark.conforms("PF-12")
@given(st.sampled_from(VEHICLE_REFERENCE.messages), st.binary(max_size=8))
@examples(300)
def test_values_are_cantools_own(message: cantools.database.Message, data: bytes) -> None:
    decoded = VEHICLE.decode(Frame(message.frame_id, data, extended=True))
    assert decoded is not None
    assert decoded.numbers == message.decode(data, decode_choices=False, allow_truncated=True)
    texts = {name: str(value) for name, value in message.decode(data, allow_truncated=True).items()}
    assert {name: str(value) for name, value in decoded.signals.items()} == texts


@pytest.mark.conforms("PF-12", "PF-16")
@given(st.sampled_from(VEHICLE_REFERENCE.messages), st.binary(min_size=8, max_size=8))
@examples(200)
def test_what_was_decoded_is_encoded_as_cantools_does(
    message: cantools.database.Message, data: bytes
) -> None:
    told = VEHICLE.message(message.name).signals
    decoded = VEHICLE.decode(Frame(message.frame_id, data, extended=True))
    assert decoded is not None
    values = {
        name: min(max(value, told[name].minimum), told[name].maximum)
        for name, value in decoded.numbers.items()
    }
    assert VEHICLE.pack(message.name, values) == message.encode(values, strict=False)


@given(st.binary(min_size=4, max_size=4))
def test_multiplexed_values(data: bytes) -> None:
    engine = load_database_once()
    message = ENGINE_REFERENCE.get_message_by_name("GearboxStatus")
    decoded = engine.decode(Frame(0x200, data))
    assert decoded is not None
    if data[0] & 15 > 1:
        assert decoded.problem == f"expected multiplexer id 0 or 1, but got {data[0] & 15}"
        assert decoded.signals == {}
    else:
        assert decoded.numbers == message.decode(data, decode_choices=False)


_LOADED: list[Database] = []


def load_database_once() -> Database:
    if not _LOADED:
        _LOADED.append(load_database(ENGINE))
    return _LOADED[0]


@pytest.mark.conforms("PF-16")
def test_signals_that_are_left_out_have_their_start_values(engine: Database) -> None:
    frame = engine.encode("EngineData", {"Ready": 1})
    decoded = engine.decode(frame)
    assert decoded is not None
    assert decoded.signals == {"EngineSpeed": 800, "Temperature": 20, "Ready": "yes", "Alive": 0, "Check": 0}
    assert decoded["Ready"] == "yes"
    assert decoded.text("EngineSpeed") == "800 rpm"


@pytest.mark.conforms("PF-12")
def test_the_multiplexer_follows_from_the_signals(engine: Database) -> None:
    assert engine.encode("GearboxStatus", {"OilPressure": 3.5}).data[0] == 1
    assert engine.encode("GearboxStatus", {"Gear": "reverse"}).data[:2] == b"\x00\x0f"
    assert engine.signals_in("GearboxStatus", {"Page": 1}) == ["Page", "OilPressure", "Torque"]


@each(
    ("name", "values", "told"),
    [
        ("EngineData", {"EngineSpeed": 16001}, "EngineSpeed: 16001 is out of range: 0 to 16000 rpm"),
        ("EngineData", {"EngineSpeed": -1}, "EngineSpeed: -1 is out of range: 0 to 16000 rpm"),
        (
            "EngineData",
            {"EngineSpeed": float("nan")},
            "EngineSpeed: nan is no value; 0 to 16000 rpm is possible",
        ),
        ("EngineData", {"EngineSpeed": "fast"}, "EngineSpeed: 'fast' is no number; 0 to 16000 rpm"),
        ("EngineData", {"EngineSpeed": None}, "EngineSpeed: None is no number"),
        ("EngineData", {"EngineSpeed": [1, 2]}, r"EngineSpeed: \[1, 2\] is no number"),
        ("EngineData", {"Ready": "maybe"}, "Ready: no value 'maybe'; 0 to 3, no, yes, unknown is possible"),
        ("EngineData", {"Enginespeed": 1}, r"Enginespeed: no such signal; did you mean EngineSpeed\?"),
        ("EngineData", {"Q": 1}, "Q: no such signal; there are EngineSpeed, Temperature, Ready"),
        ("GearboxStatus", {"Page": 2}, "Page: 2 chooses no signals; 0, 1 do"),
        (
            "GearboxStatus",
            {"Page": 0, "OilPressure": 1},
            "OilPressure: not in the frame: it needs another Page",
        ),
        ("GearboxStatus", {"Gear": 1, "OilPressure": 1}, "OilPressure: not in the frame"),
    ],
)
def test_values_that_do_not_fit(engine: Database, name: str, values: dict[str, object], told: str) -> None:
    with pytest.raises(BadSignals, match=f"{name}.{told}"):
        engine.encode(name, values)  # type: ignore[arg-type]


def test_every_fault_is_told_at_once(engine: Database) -> None:
    with pytest.raises(BadSignals) as bad:
        engine.encode("EngineData", {"EngineSpeed": 1e9, "Ready": "maybe", "Redy": 1})
    assert set(bad.value.faults) == {"EngineSpeed", "Ready", "Redy"}
    assert bad.value.message == "EngineData"


@each(
    ("use", "told"),
    [
        (lambda db: db.message("EngineDta"), r"no message 'EngineDta'; did you mean EngineData\?"),
        (
            lambda db: db.encode("Brakes", {}),
            "no message 'Brakes'; there are EngineData, GearboxStatus, EEC1",
        ),
        (lambda db: db.sent_by("engin"), r"no node 'engin'; did you mean Engine\?"),
        (lambda db: db.acceptance("EEC2"), r"did you mean EEC1\?"),
        (
            lambda db: db.encode("EngineData", {}, source=1),
            "EngineData is no J1939 message: it has no source",
        ),
        (lambda db: db.encode("EEC1", {}, source=256), "source 256: 0 to 255"),
        (lambda db: db.encode("EEC1", {}, destination=1), "parameter group 0xf004 is for everybody"),
    ],
)
def test_names_that_are_wrong(engine: Database, use: object, told: str) -> None:
    with pytest.raises(BadValue, match=told):
        use(engine)  # type: ignore[operator]


def test_signals_without_a_start_value_must_be_given_or_filled(tmp_path: Path) -> None:
    path = tmp_path / "car.dbc"
    path.write_text(
        'VERSION ""\nBO_ 1 A: 2 X\n SG_ One : 0|8@1+ (1,0) [0|9] "" X\n SG_ Two : 8|8@1+ (1,0) [5|9] "V" X\n'
    )
    database = load_database(path)
    with pytest.raises(
        BadSignals, match=r"A\.Two: no value given, and the file has no start value; 5 to 9 V"
    ):
        database.encode("A", {"One": 1})
    assert database.encode("A", {"One": 1}, fill=0).data == b"\1\5"  # the nearest in range


@pytest.mark.conforms("PF-12")
def test_fd_lengths_and_rates(tmp_path: Path) -> None:
    path = tmp_path / "fd.dbc"
    path.write_text(FD)
    database = load_database(path)
    long = database.encode("Long", {"Last": 7})
    assert isinstance(long, Frame)
    assert (len(long.data), long.data[29], long.fd, long.bit_rate_switch) == (32, 7, True, True)
    slow = database.encode("Slow", {"One": 1})
    assert isinstance(slow, Frame)
    assert (slow.fd, slow.bit_rate_switch, len(slow.data)) == (True, False, 3)
    decoded = database.decode(long)
    assert decoded is not None
    assert decoded["Last"] == 7


def test_messages_longer_than_a_frame(tmp_path: Path) -> None:
    path = tmp_path / "long.dbc"
    path.write_text('VERSION ""\nBO_ 1 A: 70 X\n SG_ Far : 552|8@1+ (1,0) [0|0] "" X\n')
    database = load_database(path)
    with pytest.raises(BadValue, match="A: 70 bytes need several frames"):
        database.encode("A", {"Far": 1})
    assert database.pack("A", {"Far": 1}) == bytes(69) + b"\1"


def test_frames_that_are_no_message(engine: Database) -> None:
    assert engine.decode(Frame(0x101)) is None
    assert engine.decode(Frame(0x1F000100, extended=True)) is None
    assert engine.decode(Frame(0x100, remote=True, dlc=8)) is None
    cut = engine.decode(Frame(0x100, b"\x70\x17"))
    assert cut is not None
    assert cut.signals == {"EngineSpeed": 1500.0}


@pytest.mark.conforms("PL-21")
def test_filters_by_name(engine: Database) -> None:
    wanted = engine.acceptance("EngineData", "EEC1")
    accepted = [
        wanted.accepts(frame)
        for frame in (
            Frame(0x100),
            Frame(0x101),
            Frame(0x200),
            Frame(0x0CF00400, extended=True),
            Frame(0x18F00433, extended=True),  # another priority and source
            Frame(0x0CF00500, extended=True),
        )
    ]
    assert accepted == [True, False, False, True, True, False]
    assert engine.id_masks("EngineData", "TorqueRequest") == [
        (0x100, 0x7FF, False),
        (0x0C0000FE, 0x03FF0000, True),
    ]


def test_parsing_what_people_type(engine: Database) -> None:
    ready = engine.message("EngineData").signals["Ready"]
    assert [ready.parse(text) for text in ("yes", " 1", "0x3", "1.5", "nope")] == ["yes", 1, 3, 1.5, "nope"]
