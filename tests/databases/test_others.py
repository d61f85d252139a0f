"""Databases as other people write them; each of these once gave wrong values, or none."""

from __future__ import annotations

from pathlib import Path

import numpy
import pytest

from canwire import BadValue, Frame, frames_to_array, load_database

HEAD = 'VERSION ""\nNS_ :\nBS_:\nBU_: ECU\n'
TWINS = (
    HEAD
    + """BO_ 256 Position: 2 ECU
 SG_ X : 0|8@1+ (1,0) [0|255] "" Vector__XXX
BO_ 512 Position: 2 ECU
 SG_ Y : 8|8@1+ (1,0) [0|255] "" Vector__XXX
BO_ 768 Speed: 1 ECU
 SG_ V : 0|8@1+ (1,0) [0|255] "" Vector__XXX
"""
)
REPEATED = (
    HEAD
    + """BO_ 256 First: 1 ECU
 SG_ A : 0|8@1+ (1,0) [0|255] "" Vector__XXX
BO_ 256 Last: 1 ECU
 SG_ B : 0|8@1+ (2,0) [0|510] "" Vector__XXX
"""
)
LONG = (
    HEAD
    + """BO_ 256 Long: 24 ECU
 SG_ A : 184|8@1+ (1,0) [0|255] "" Vector__XXX
"""
)
TEXT = (
    HEAD
    + """BO_ 2566834430 Text: 1785 ECU
 SG_ Words : 0|14280@1+ (1,0) [0|0] "" Vector__XXX
"""
)
_SHORT, _FULL = "AVeryLongNameOfAMultiplexerWhich", "AVeryLongNameOfAMultiplexerWhichIsCutInDbc"
MULTIPLEXED = (
    HEAD
    + f"""BO_ 256 Paged: 2 ECU
 SG_ {_SHORT} M : 0|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ A m1 : 8|8@1+ (1,0) [0|255] "" Vector__XXX
BA_DEF_ SG_ "SystemSignalLongSymbol" STRING ;
BA_DEF_DEF_ "SystemSignalLongSymbol" "";
BA_ "SystemSignalLongSymbol" SG_ 256 {_SHORT} "{_FULL}";
"""
)


def written(folder: Path, text: str) -> Path:
    path = folder / "others.dbc"
    path.write_text(text)
    return path


def test_messages_of_one_name_keep_their_own_layouts(tmp_path: Path) -> None:
    database = load_database(written(tmp_path, TWINS))
    assert list(database.messages) == ["Position_100", "Position_200", "Speed"]
    frames = [Frame(0x100, b"\x01\x02"), Frame(0x200, b"\x01\x02")]
    first, second = (database.decode(frame) for frame in frames)
    assert first is not None
    assert second is not None
    assert (dict(first.signals), dict(second.signals)) == ({"X": 1}, {"Y": 2})
    columns = database.decode_arrays(frames_to_array(frames))
    assert {name: list(found.signals) for name, found in columns.items()} == {
        "Position_100": ["X"],
        "Position_200": ["Y"],
    }
    assert database.encode("Position_200", {"Y": 7}) == Frame(0x200, b"\x00\x07")
    with pytest.raises(BadValue, match="Position_100"):
        database.message("Position")


def test_of_messages_with_one_identifier_the_last_counts(tmp_path: Path) -> None:
    """As with cantools' own `decode_message`."""
    database = load_database(written(tmp_path, REPEATED), strict=False)
    frame = Frame(0x100, b"\x05")
    found = database.decode(frame)
    assert found is not None
    assert (found.name, dict(found.signals)) == ("Last", {"B": 10})
    assert list(database.decode_arrays(frames_to_array([frame]))) == ["Last"]


def test_a_message_of_more_than_8_bytes_is_a_frame_of_can_fd(tmp_path: Path) -> None:
    database = load_database(written(tmp_path, LONG))
    frame = database.encode("Long", {"A": 9})
    assert frame == Frame(0x100, bytes(23) + b"\x09", fd=True, bit_rate_switch=True)


def test_texts_of_many_bytes(tmp_path: Path) -> None:
    database = load_database(written(tmp_path, TEXT))
    assert database.message("Text").signals["Words"].maximum == float("inf")


def test_a_multiplexer_with_a_long_name(tmp_path: Path) -> None:
    database = load_database(written(tmp_path, MULTIPLEXED))
    message = database.message("Paged")
    assert message.signals["A"].multiplexer == _FULL
    columns = database.decode_arrays(frames_to_array([Frame(0x100, b"\x01\x07"), Frame(0x100, b"\x01\x08")]))
    assert columns["Paged"].signals["A"].tolist() == [7, 8]
    assert columns["Paged"].present["A"] is None or numpy.all(columns["Paged"].present["A"])


OVERLAPPING = (
    HEAD
    + """BO_ 256 Overlapping: 8 ECU
 SG_ A : 7|64@0+ (1,0) [0|0] "" Vector__XXX
 SG_ B : 15|8@0- (0.5,0) [0|0] "" Vector__XXX
 SG_ C : 24|16@1+ (1,0) [0|0] "" Vector__XXX
"""
)
TOO_LONG = (
    HEAD
    + """BO_ 256 Outside: 2 ECU
 SG_ A : 0|8@1+ (1,0) [0|0] "" Vector__XXX
 SG_ B : 8|16@1+ (1,0) [0|0] "" Vector__XXX
"""
)
NAMED_PAGE = (
    HEAD
    + """BO_ 256 Paged: 2 ECU
 SG_ Page M : 0|8@1+ (1,0) [0|255] "" Vector__XXX
 SG_ A m1 : 8|8@1+ (1,0) [0|255] "" Vector__XXX
VAL_ 256 Page 1 "one" 2 "empty" ;
"""
)


@pytest.mark.parametrize(
    ("text", "data", "expected", "problem"),
    [
        (OVERLAPPING, "0102030405060708", {"A": 0x0102030405060708, "B": 1.0, "C": 0x0504}, ""),
        (OVERLAPPING, "01FE030405060708", {"A": 0x01FE030405060708, "B": -1.0, "C": 0x0504}, ""),
        (OVERLAPPING, "01FE03", {"B": -1.0}, ""),
        (TOO_LONG, "0102", {"A": 1}, "not in 2 bytes: B"),
        (TOO_LONG, "010203", {"A": 1}, "not in 2 bytes: B"),
        (NAMED_PAGE, "0203", {"Page": 2}, ""),
        (NAMED_PAGE, "0103", {"Page": 1, "A": 3}, ""),
        (NAMED_PAGE, "0303", {}, "expected multiplexer id 1 or 2, but got 3"),
        (MULTIPLEXED, "0103", {_FULL: 1, "A": 3}, ""),
        (MULTIPLEXED, "0203", {}, f"{_FULL}: 2 chooses no signals"),
    ],
)
def test_what_cantools_does_not_read(
    text: str, data: str, expected: dict[str, float], problem: str, tmp_path: Path
) -> None:
    """One by one and in columns the same: signals that overlap, or do not fit; pages without signals; long names."""
    database = load_database(written(tmp_path, text), strict=False)
    frame = Frame(0x100, bytes.fromhex(data))
    found = database.decode(frame)
    assert found is not None
    assert (dict(found.numbers), found.problem) == (expected, problem)
    (columns,) = database.decode_arrays(frames_to_array([frame])).values()
    assert {
        name: values[0]
        for name, values in columns.signals.items()
        if (here := columns.present[name]) is None or here[0]
    } == expected


def test_a_page_without_signals_can_be_sent(tmp_path: Path) -> None:
    database = load_database(written(tmp_path, NAMED_PAGE))
    assert database.encode("Paged", {"Page": "empty"}) == Frame(0x100, b"\x02\x00")
