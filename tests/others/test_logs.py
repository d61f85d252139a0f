"""Every log of python-can's tests, read by us and by python-can itself."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

import pytest

from canwire import BadLog, open_log
from tests.others.packages import unpacked

can = pytest.importorskip("can")
SUFFIXES = {".asc", ".blf", ".trc"}
FD_REMOTE = "CAN FD knows no remote frames: python-can makes one, we read a classic one"
IMPOSSIBLE = "its bytes are a pattern: frames with 11-bit identifiers of 27 bits, or length codes above 15"
ERRORS = "it has an error frame, which python-can leaves out"
TOO_LONG = "its classic frame has 64 bytes: python-can takes the first eight, we say what is wrong with it"
DIFFERENT = {
    "logfile.asc": FD_REMOTE,
    "test_CanFdRemoteMessage.asc": FD_REMOTE,
    "test_CanFdMessage.blf": IMPOSSIBLE,
    "test_CanFdMessage64.blf": IMPOSSIBLE,
    "test_CanMessage.blf": IMPOSSIBLE,
    "test_CanMessage2.blf": IMPOSSIBLE,
    "test_CanMessage_V1_0_BUS1.trc": ERRORS,
    "test_CanMessage_V1_1.trc": ERRORS,
    "test_CanMessage_V1_3.trc": ERRORS,
    "test_CanMessage_V2_0_BUS1.trc": ERRORS,
    "test_CanMessage_V2_1.trc": ERRORS,
    "single_frame.asc": TOO_LONG,
}
"""Why they differ, by file."""


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    root = unpacked(tmp_path_factory.mktemp("others"))
    return [path for path in sorted(root.rglob("*")) if path.suffix.lower() in SUFFIXES]


@pytest.mark.filterwarnings("ignore")
def test_they_say_the_same_as_python_can(files: list[Path], record_property: Any) -> None:
    logging.getLogger("can").addHandler(logging.NullHandler())
    record_property("files", len(files))
    different = {path.name for path in files if _ours(path) != _theirs(path)}
    assert different == {name for name in DIFFERENT if any(path.name == name for path in files)}
    assert len(files) > 15


def _theirs(path: Path) -> list[tuple[Any, ...]]:
    found: list[tuple[Any, ...]] = []
    for one in can.LogReader(path):
        if one.is_error_frame:
            found.append(("error",))
        else:
            found.append(
                (one.arbitration_id, one.is_extended_id, one.is_remote_frame, one.is_fd, bytes(one.data))
            )
    return found


def _ours(path: Path) -> list[tuple[Any, ...]]:
    found: list[tuple[Any, ...]] = []
    try:
        with open_log(path) as log:
            for entry in log:
                if (frame := entry.frame) is not None:
                    found.append((frame.id, frame.extended, frame.remote, frame.fd, frame.data))
                else:
                    found.append(("error",))
    except BadLog as error:
        return [(str(error),)]
    return found
