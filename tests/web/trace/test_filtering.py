"""The language of filters, colours and searches, over rows of CAN and LIN."""

from __future__ import annotations

from pathlib import Path

import numpy
import pytest

from canwire import BusEvent, ErrorKind, EventKind, Frame, load_database, record_dtype
from canwire.values.frame import record_of_frame
from canwire.values.record import SELF_RECEPTION
from canwire.web.database import Database
from canwire.web.trace.store.described import Described, DescribedLines
from canwire.web.trace.store.filtering import BadFilter, Language, directed
from canwire.web.trace.store.history import History
from canwire.web.trace.store.rows import LOST, mark_row, rows_of
from canwire.web.trace.store.selection import Selection
from tests.cases import each

pytestmark = pytest.mark.conforms("PG-02", "PG-12")

DBC = """VERSION ""
BU_: ECU
BO_ 256 Engine: 8 ECU
 SG_ Speed : 0|16@1+ (0.25,0) [0|16000] "rpm" ECU
 SG_ Running : 24|1@1+ (1,0) [0|1] "" ECU
BO_ 700 ADE: 2 ECU
 SG_ Gear : 0|4@1+ (1,0) [0|8] "" ECU
VAL_ 256 Running 1 "yes" 0 "no" ;
"""
FRAMES = [
    Frame(0x100, (4000).to_bytes(2, "little") + bytes([50, 1, 0, 0, 0, 0])),  # 1000 rpm, running
    Frame(0x100, (8000).to_bytes(2, "little") + bytes(6)),
    Frame(0x123, b"\xde\xad\xbe\xef"),
    Frame(0x12345678, b"\x11", extended=True),
    Frame(0x7FF, remote=True, dlc=4),
    Frame(0x55, bytes(12), fd=True),
]
EVENT = len(FRAMES)


@pytest.fixture(scope="module")
def language(tmp_path_factory: pytest.TempPathFactory) -> Language:
    path = tmp_path_factory.mktemp("dbc") / "car.dbc"
    Path(path).write_text(DBC)
    described = Described([DescribedLines(Database([load_database(path)]), [0, 1])])
    return Language(described, {"can0": [0], "hw000001:0": [0], "can1": [1]})


@pytest.fixture(scope="module")
def rows() -> numpy.ndarray:
    """The frames, an error; every second one on line 1, the third one sent."""
    block = (
        b"".join(map(record_of_frame, FRAMES)) + BusEvent(EventKind.ERROR, error=ErrorKind.ACK).to_record()
    )
    made = rows_of(numpy.frombuffer(block, record_dtype()), 0)
    made["line"] = numpy.arange(len(made)) % 2
    made["record"]["info"][2] |= SELF_RECEPTION
    return made


@pytest.mark.finding("page B3")
@each(
    ("text", "passed"),
    [
        ("100", [0, 1]),
        ("0x100-0x123", [0, 1, 2]),
        ("!100", [2, 3, 4, 5, 6]),
        ("100-1FF, !123", [0, 1]),
        ("error", [6]),
        ("event; rtr", [4, 6]),
        ("std & !rtr & !100", [2, 5]),
        ("ext", [3]),
        ("fd", [5]),
        ("tx", [2]),
        ("rx & 100", [0, 1]),
        ("Engine", [0, 1]),
        ("name:eng", [0, 1]),
        ("can1", [1, 3, 5]),
        ("HW000001:0 & frame", [0, 2, 4]),
        ("bus: can1 & 100", [1]),
        ("data: AD BE", [2]),
        ("data: DE ?? BE", [2]),
        ("Speed > 1500", [1]),
        ("Speed <= 1000", [0]),
        ("Running = yes", [0]),
        ("Engine & Running = no, data:DEAD", [1, 2]),
        ("id:12345678", [3]),
        ("lin", []),
        ("can & !frame", [6]),
    ],
)  # fmt: skip
def test_what_passes(language: Language, rows: numpy.ndarray, text: str, passed: list[int]) -> None:
    test = language.compile(text)
    assert test is not None
    assert numpy.flatnonzero(test(rows)).tolist() == passed


@pytest.mark.finding("page 15")
@each(("text", "passes"), [("ADE", False), ("id:ADE", False), ("name:ADE", True)])
def test_a_name_of_hexadecimal_digits_is_meant_by_its_prefix(
    language: Language, text: str, passes: bool
) -> None:
    """ADE is an identifier and a message's name."""
    test = language.compile(text)
    assert test is not None
    rows = rows_of(numpy.frombuffer(record_of_frame(Frame(0x2BC)), record_dtype()), 0)
    assert test(rows).tolist() == [passes]


@each(
    "text", ["zzz", "200-100", "data: D", "data: xx", "name:", "bus:can9", "Speed > fast", "100 & zzz", "!"]
)
def test_a_part_that_means_nothing_is_named(language: Language, text: str) -> None:
    with pytest.raises(BadFilter):
        language.compile(text)


def test_an_empty_filter_is_none(language: Language) -> None:
    assert language.compile(" , ") is None


@each(
    ("text", "found"), [("de ad", [2]), ("engine", [0, 1]), ("234567", [3]), ("error", [6]), ("12", [2, 3])]
)
def test_searches(language: Language, rows: numpy.ndarray, text: str, found: list[int]) -> None:
    assert numpy.flatnonzero(language.search(text)(rows)).tolist() == found


def test_one_direction_leaves_what_has_none(rows: numpy.ndarray) -> None:
    assert numpy.flatnonzero(directed(None, sent=True)(rows)).tolist() == [2, 6]


def test_a_selection_grows_stops_and_is_searched_both_ways(language: Language, rows: numpy.ndarray) -> None:
    history = History()
    selection = Selection(history, (0, 1), language.compile("frame"))
    history.append(rows.copy())
    history.append(mark_row(LOST, 0, 3, 0))
    history.append(rows.copy())
    assert not selection.extend()
    assert selection.rows(0, 100)["number"].tolist() == [
        *range(6),
        7,
        *range(8, 14),
    ]  # the mark passes every filter
    test = language.search("dead")
    assert selection.find(test, -1, 1) == 2
    assert selection.find(test, 2, 1) == 9
    assert selection.find(test, 9, 1) == 2
    assert selection.find(test, 2, -1) == 9
    assert selection.find(language.search("7777"), 0, 1) is None
    assert selection.place_of(9) == 8
    selection.stop(8)
    assert (selection.count, selection.cursor, selection.extend()) == (7, 8, False)
    selection.stop(None)
    selection.extend()
    assert selection.count == 13
