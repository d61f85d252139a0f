"""Every database of cantools' and canmatrix' tests and of opendbc, decoded by us, one by one and in columns, and by
cantools itself."""

from __future__ import annotations

import random
from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from canwire import BadDescription, Database, Frame, MessageDescription, frames_to_array, load_database
from canwire.values.dlc import FD_LENGTHS
from tests.others.packages import unpacked

cantools = pytest.importorskip("cantools")
SUFFIXES = {".dbc", ".kcd", ".sym", ".arxml"}
_FRAMES = 4  # of each message
SELECTOR = (
    "a selector without signals: a frame of columns is undecoded then, cantools gives what is not multiplexed"
)
DIFFERENT = {
    ("system-4.2.arxml", "MultiplexedMessage", "decode_arrays"): SELECTOR,
    ("tesla_model3_vehicle.dbc", "VCLEFT_switchStatus", "decode_arrays"): SELECTOR,
    (
        "vw_pq.dbc",
        "Motor_2",
        "decode_arrays",
    ): "the file writes m where M is meant: cantools knows no multiplexer, "
    "so none of its signals; columns go by what SG_MUL_VAL_ says",
}
"""Why they differ, by file, message and way."""
BROKEN = {
    "j1939.dbc",
    "issue_63.dbc",
    "message_layout.kcd",
    "bad_message_length.dbc",
    "bad_message_length.kcd",
    "bad_message_length.sym",
    "FORD_CADS_64.dbc",
    "_steering_control_c.dbc",
    "_toyota_2017.dbc",
    "gm_global_a_lowspeed_1818125.dbc",
    "gwm_haval_h6_phev_2024.dbc",
    "hongqi_hs5.dbc",
    "hyundai_i30_2014.dbc",
    "mazda_3_2019.dbc",
    "nissan_xterra_2011.dbc",
    "volvo_v40_2017_pt.dbc",
    "vw_mqb.dbc",
    "vw_pq.dbc",
}
"""Files with messages of which cantools decodes nothing, since a signal does not fit."""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    root = unpacked(tmp_path_factory.mktemp("others"))
    return [path for path in sorted(root.rglob("*")) if path.suffix.lower() in SUFFIXES]


@pytest.mark.filterwarnings("ignore")
def test_they_say_the_same_as_cantools(files: list[Path], record_property: Any) -> None:
    counts: Counter[str] = Counter()
    differences: list[str] = []
    for path in files:
        theirs, ours = _both(path)
        counts["files"] += 1
        if theirs is None or ours is None:
            counts["refused"] += 1
            if (theirs is None) != (ours is None):
                differences.append(f"{path.name}: {'cantools' if theirs is None else 'we'} alone refuse it")
            continue
        for message, their in zip(ours.messages.values(), theirs.messages, strict=True):
            if message.decodable and ours.message_of(_frame(message, b"")) is message:
                counts["messages"] += 1
                differences += _compared(path.name, ours, message, their, counts)
    for name, count in counts.items():
        record_property(name, count)
    assert differences == []
    assert counts["values"] > 1000


def _both(path: Path) -> tuple[Any, Database | None]:
    """Read by both; None for a refusal."""
    try:
        theirs = cantools.database.load_file(path, strict=False)
        theirs = theirs if hasattr(theirs, "messages") else None
    except Exception:  # cantools' many kinds
        theirs = None
    try:
        return theirs, load_database(path, strict=False)
    except BadDescription:
        return theirs, None


def _frame(message: MessageDescription, data: bytes) -> Frame:
    fd = message.fd or message.length > 8
    length = next(size for size in FD_LENGTHS if size >= min(message.length, 64))
    return Frame(message.id, data.ljust(length, b"\0")[:length], extended=message.extended, fd=fd)


def _compared(
    where: str, ours: Database, message: MessageDescription, their: Any, counts: Counter[str]
) -> list[str]:
    """What differs between our two ways and cantools', for a few random frames of one message."""
    chance = random.Random(message.id)
    frames = [_frame(message, chance.randbytes(64)) for _ in range(_FRAMES)]
    columns = ours.decode_arrays(frames_to_array(frames))[message.name]
    wrong = []
    for row, frame in enumerate(frames):
        told = ours.decode(frame)
        assert told is not None
        try:
            expected = their.decode(frame.data, decode_choices=False, allow_truncated=True)
        except cantools.database.DecodeError:
            expected = {}
        in_columns = {
            name: values[row]
            for name, values in columns.signals.items()
            if (here := columns.present[name]) is None or here[row]
        }
        for way, found in (("decode", dict(told.numbers)), ("decode_arrays", in_columns)):
            if (where, message.name, way) in DIFFERENT:
                continue
            if len(their.signals) != len(message.signals):
                counts["messages with signals of one name"] += 1  # which of them counts is anybody's guess
                continue
            if way == "decode_arrays" and not expected and found:
                if where not in BROKEN:
                    wrong.append(f"{where}: {message.name}: cantools decodes nothing")
                counts["broken"] += 1
                continue
            counts["values"] += len(found)
            if found.keys() != expected.keys() or any(
                not _same(found[name], value) for name, value in expected.items()
            ):
                wrong.append(f"{where}: {message.name} by {way}: {found}, not {expected}")
    return wrong


def _same(one: Any, other: Any) -> bool:
    return bool(one == other or (one != one and other != other))  # not a number is not itself
