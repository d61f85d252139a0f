"""Many frames at once: the very values that cantools gives one by one."""

from __future__ import annotations

import random
import sys
from pathlib import Path
from typing import Any

import cantools
import pytest
from hypothesis import given
from hypothesis import strategies as st

from canwire import (
    Database,
    ExtraMissing,
    Frame,
    frames_to_array,
    load_database,
    parse_log_line,
    record_dtype,
)
from tests.databases.conftest import DATA, ROOT
from tests.effort import examples

numpy = pytest.importorskip("numpy")

pytestmark = pytest.mark.conforms("PF-12")
VEHICLE = DATA / "vehicle.dbc"


def one_by_one(reference: Any, frames: list[Frame]) -> dict[str, dict[int, dict[str, object]]]:
    """Numbers by message and place, by cantools; frames whose multiplexer it does not know have none."""
    found: dict[str, dict[int, dict[str, object]]] = {}
    for place, frame in enumerate(frames):
        try:
            message = reference.get_message_by_frame_id(frame.id, force_extended_id=frame.extended)
        except KeyError:
            continue
        if message.is_extended_frame != frame.extended or frame.remote:
            continue
        try:
            values = message.decode(frame.data, decode_choices=False, allow_truncated=True)
        except cantools.database.DecodeError:
            values = {}
        found.setdefault(message.name, {})[place] = values
    return found


def at_once(database: Database, frames: list[Frame]) -> dict[str, dict[int, dict[str, object]]]:
    """The same by columns."""
    found: dict[str, dict[int, dict[str, object]]] = {}
    for name, columns in database.decode_arrays(frames_to_array(frames)).items():
        lists = {signal: values.tolist() for signal, values in columns.signals.items()}
        for number, place in enumerate(columns.rows.tolist()):
            found.setdefault(name, {})[place] = {
                signal: values[number]
                for signal, values in lists.items()
                if (there := columns.present[signal]) is None or there[number]
            }
    return found


def same(one: Any, other: Any) -> bool:
    """Equal, in their types and where they are no numbers as well."""
    return repr(sorted_deep(one)) == repr(sorted_deep(other))


def sorted_deep(found: dict[str, dict[int, dict[str, object]]]) -> object:
    return [
        (name, place, sorted(values.items()))
        for name, places in sorted(found.items())
        for place, values in sorted(places.items())
    ]


def test_a_car_s_log_by_217_messages() -> None:
    """The car's data, under identifiers of the file, which is of another car."""
    reference = cantools.database.load_file(VEHICLE)
    lines = (ROOT / "examples" / "car-candump.log").read_text().splitlines()
    logged = [parse_log_line(line).content for line in lines]
    ids = {id: number for number, id in enumerate(dict.fromkeys(frame.id for frame in logged))}
    frames = [
        Frame(reference.messages[ids[frame.id] % 217].frame_id, frame.data, extended=True) for frame in logged
    ]
    expected = one_by_one(reference, frames)
    assert len(frames) > 10_000
    assert len(expected) > 100
    assert same(at_once(load_database(VEHICLE), frames), expected)


def test_random_frames_of_all_217_messages() -> None:
    reference = cantools.database.load_file(VEHICLE)
    chance = random.Random(18)
    frames = [
        Frame(
            message.frame_id, chance.randbytes(chance.choice([8, 8, 8, chance.randrange(9)])), extended=True
        )
        for message in reference.messages * 20
    ]
    assert same(at_once(load_database(VEHICLE), frames), one_by_one(reference, frames))


LAYOUT = """VERSION ""
BU_: A
BO_ 1 M: {length} A
{signals}
{more}"""


@st.composite
def signal_lines(draw: st.DrawFn, length: int) -> list[str]:
    """Signals of any place, size, order, sign and scale that do not overlap: cantools reads no others."""
    lines = []
    taken: set[int] = set()
    for number in range(draw(st.integers(1, 6))):
        bits = draw(st.integers(1, 64))
        start = draw(st.integers(0, 8 * length - 1))
        order = draw(st.sampled_from("01"))
        network = start if order == "1" else 8 * (start // 8) + 7 - start % 8
        bits = min(bits, 8 * length - network)
        places = range(network, network + bits)
        own = {place if order == "1" else 8 * (place // 8) + 7 - place % 8 for place in places}
        if own & taken:
            continue
        taken |= own
        sign = draw(st.sampled_from("+-"))
        scale = draw(st.sampled_from(["1", "2", "0.25", "-1", "0.1", "1e-9", "3000000000", "2.0", "1.5"]))
        offset = draw(st.sampled_from(["0", "-40", "0.5", "1000000000000", "-273.15"]))
        lines.append(f' SG_ S{number} : {start}|{bits}@{order}{sign} ({scale},{offset}) [0|0] "" A')
    return lines


@given(st.data())
@examples(100)
def test_any_layout(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    length = data.draw(st.sampled_from([1, 3, 8, 8, 8, 20, 64]))
    text = LAYOUT.format(length=length, signals="\n".join(data.draw(signal_lines(length))), more="")
    path = tmp_path_factory.mktemp("layout") / "m.dbc"
    path.write_text(text)
    reference = cantools.database.load_file(path, strict=False)
    contents = data.draw(st.lists(st.binary(max_size=8), min_size=1, max_size=5))
    contents += [(content * 64)[:64] for content in contents if content and length > 8]
    frames = [Frame(1, content, fd=len(content) > 8) for content in contents]
    assert same(at_once(load_database(path, strict=False), frames), one_by_one(reference, frames))


FLOATS = """ SG_ Single : 0|32@1- (1,0) [0|0] "" A
 SG_ Scaled : 39|32@0- (0.5,1) [0|0] "" A"""


@given(st.lists(st.binary(min_size=8, max_size=8), min_size=1, max_size=5))
@examples(50)
def test_floats(tmp_path_factory: pytest.TempPathFactory, contents: list[bytes]) -> None:
    path = tmp_path_factory.mktemp("floats") / "m.dbc"
    more = "SIG_VALTYPE_ 1 Single : 1;\nSIG_VALTYPE_ 1 Scaled : 1;\n"
    path.write_text(LAYOUT.format(length=8, signals=FLOATS, more=more))
    frames = [Frame(1, content) for content in contents]
    with numpy.errstate(invalid="ignore"):
        assert same(
            at_once(load_database(path), frames), one_by_one(cantools.database.load_file(path), frames)
        )


def test_doubles_and_halves(tmp_path: Path) -> None:
    path = tmp_path / "m.dbc"
    path.write_text(
        LAYOUT.format(length=8, signals=' SG_ D : 7|64@0- (1,0) [0|0] "" A', more="SIG_VALTYPE_ 1 D : 2;\n")
    )
    frames = [Frame(1, bytes.fromhex("400921fb54442d18"))]
    assert at_once(load_database(path), frames) == {"M": {0: {"D": 3.141592653589793}}}


MULTIPLEXED = """ SG_ Page M : 0|3@1+ (1,0) [0|0] "" A
 SG_ Zero m0 : 8|16@1- (1,0) [0|0] "" A
 SG_ Inner m1M : 8|2@1+ (1,0) [0|0] "" A
 SG_ Deep m2 : 16|8@1+ (0.5,0) [0|0] "" A
 SG_ Always : 24|8@1+ (1,0) [0|0] "" A"""


@given(st.lists(st.binary(max_size=4), min_size=1, max_size=20))
@examples(60)
def test_multiplexers_in_multiplexers_and_short_data(
    tmp_path_factory: pytest.TempPathFactory, contents: list[bytes]
) -> None:
    path = tmp_path_factory.mktemp("multiplexed") / "m.dbc"
    more = "SG_MUL_VAL_ 1 Deep Inner 2-3;\nSG_MUL_VAL_ 1 Inner Page 1-1;\nSG_MUL_VAL_ 1 Zero Page 0-0;\n"
    path.write_text(LAYOUT.format(length=4, signals=MULTIPLEXED, more=more))
    frames = [Frame(1, content) for content in contents]
    database, reference = load_database(path), cantools.database.load_file(path)
    expected = one_by_one(reference, frames)
    assert same(at_once(database, frames), expected)
    (columns,) = database.decode_arrays(frames_to_array(frames)).values()
    unknown = sum(1 for frame in frames if (told := database.decode(frame)) is not None and told.problem)
    assert columns.undecoded == unknown


def test_what_is_left_out_and_what_is_told(engine: Database) -> None:
    frames = [
        Frame(0x100, b"\x70\x17\x3c\x01\0\0\0\0"),
        Frame(0x101, bytes(8)),
        Frame(0x100, remote=True, dlc=8),
        Frame(0x100, extended=True, data=bytes(8)),
        Frame(0x18F00433, bytes(8), extended=True),
        Frame(0x100, b"\x00\x00\x00\x02\0\0\0\0"),
    ]
    records = frames_to_array(frames)
    records["time_ns"] = range(6)
    event = numpy.zeros(1, record_dtype())
    event["id"], event["info"] = 0x100, 1
    found = engine.decode_arrays(numpy.concatenate([records, event]))
    assert {name: columns.rows.tolist() for name, columns in found.items()} == {
        "EngineData": [0, 5],
        "TorqueRequest": [3],
        "EEC1": [4],
    }
    data = found["EngineData"]
    assert data.time_ns.tolist() == [0, 5]
    assert data.texts("Ready").tolist() == ["yes", ""]
    assert data.texts("EngineSpeed").tolist() == ["", ""]
    assert data.signals["EngineSpeed"].tolist() == [1500.0, 0.0]
    assert repr(data).startswith("<columns of EngineData: 2 frames, EngineSpeed, ")


def test_no_frames_at_all(engine: Database) -> None:
    assert engine.decode_arrays(numpy.zeros(0, record_dtype())) == {}
    with pytest.raises(TypeError, match="record_dtype"):
        engine.decode_arrays(numpy.zeros(3))


def test_j1939_arrays_and_frames_agree(engine: Database) -> None:
    chance = random.Random(4)
    frames = [
        Frame(base | chance.randrange(256) | chance.randrange(8) << 26, bytes(8), extended=True)
        for base in (0x00F00400, 0x00F00500, 0x00000000, 0x0000FF00, 0x01000000) * 50
    ]
    found = engine.decode_arrays(frames_to_array(frames))
    names = {place: name for name, columns in found.items() for place in columns.rows.tolist()}
    told = [engine.message_of(frame) for frame in frames]
    assert [names.get(place) for place in range(len(frames))] == [one and one.name for one in told]
    assert set(names.values()) == {"EEC1", "TorqueRequest"}


def test_without_numpy(engine: Database, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "numpy", None)
    with pytest.raises(ExtraMissing, match=r"canwire\[arrays\]"):
        engine.decode_arrays(None)  # type: ignore[arg-type]
