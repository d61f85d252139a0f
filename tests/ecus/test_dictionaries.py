"""EDS files under limits: canopen's dictionary, or one error that names the file."""

from __future__ import annotations

from pathlib import Path

import pytest

import canwire
from canwire import BadDescription

pytest.importorskip("canopen")
pytestmark = pytest.mark.finding("faults-2 4", "faults-2 5")

DEVICE = "[DeviceInfo]\nProductName=small\n"
OBJECT = "[2000]\nParameterName=A\nObjectType=0x8\nDataType=0x0005\nAccessType=rw\n"


def written(folder: Path, text: str | bytes, name: str = "a.eds") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def test_it_is_canopens_dictionary(tmp_path: Path) -> None:
    small = canwire.ecus.load_eds(canwire.ecus.CanopenEcu.EDS, node_id=5)
    assert small[0x1018][0].index == 0x1018
    latin = canwire.ecus.load_eds(
        written(tmp_path, (DEVICE + OBJECT.replace("=A", "=T in °C")).encode("latin-1"))
    )
    assert latin[0x2000].name == "T in °C"


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (OBJECT + "CompactSubObj=0x10000000\n", "at most 254 entries"),
        (
            OBJECT + "CompactSubObj=2\n[2000Name]\nnrofentries = 100000000\n",
            "at most 254 entries|NrOfEntries",
        ),
        ("[1000]\nParameterName=A\n", "no object dictionary"),
        ("no section", "MissingSectionHeaderError"),
        ("[Comments]\nLines=99999999999\n", "Line1"),
        (OBJECT + OBJECT, "DuplicateSectionError"),
        (b"\xff\x00[", "no object dictionary"),
    ],
)
def test_what_it_refuses(tmp_path: Path, text: str | bytes, why: str) -> None:
    path = written(tmp_path, text)
    with pytest.raises(BadDescription, match=why) as caught:
        canwire.ecus.load_eds(path)
    assert str(path) in str(caught.value)
    with pytest.raises(BadDescription, match=why):
        canwire.ecus.CanopenEcu(5, path)


def test_limits_are_settable(tmp_path: Path) -> None:
    path = written(tmp_path, OBJECT)
    with pytest.raises(BadDescription, match="more than most_bytes=10"):
        canwire.ecus.load_eds(path, most_bytes=10)
    with pytest.raises(BadDescription, match=r"no object dictionary by its ending; there are .eds, .dcf"):
        canwire.ecus.load_eds(tmp_path / "a.txt")
    with pytest.raises(BadDescription, match="No such file"):
        canwire.ecus.load_eds(tmp_path / "none.eds")
