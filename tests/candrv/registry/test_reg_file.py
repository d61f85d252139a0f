""".reg files of existing installations: what they have is stored, what has no place is named, what is wrong refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from canwire import BadConfig, BadValue
from canwire.candrv.registry import reg_file
from canwire.candrv.registry.registry import RegistryStore

pytestmark = pytest.mark.finding("candrv B16")

HEAD = "Windows Registry Editor Version 5.00\n\n"
CID1 = r"[HKEY_LOCAL_MACHINE\Drivers\BuiltIn\CID1]" + "\n"
BOARD = (
    HEAD
    + CID1
    + r"""; the sensor's board
"Dll"="candrv.dll"
"FriendlyName"="a \"fast\" one, C:\\can"
"Prefix"="CID"
"Index"=dword:00000001
"baudrate"=dword:0007a120
"AcceptanceMask"=dword:FFFFFFFF
"Flags"=dword:00000008
"IClass"=hex(7):7b,00,\
  7d,00

[HKEY_LOCAL_MACHINE\Drivers\BuiltIn\Serial1]
"Dll"="serial.dll"
"Baudrate"=dword:00000001

[hklm\drivers\builtin\CID2]
"Index"=dword:2
"DeviceArrayIndex"=dword:1
"""
)


def written(tmp_path: Path, text: str, encoding: str = "utf-16") -> Path:
    path = tmp_path / "board.reg"
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8", "utf-8-sig"])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_a_board_s_entries(tmp_path: Path, encoding: str, newline: str) -> None:
    found = reg_file.load(written(tmp_path, BOARD.replace("\n", newline), encoding))
    assert found.devices == {
        "CID1": {
            "Dll": "candrv.dll",
            "FriendlyName": 'a "fast" one, C:\\can',
            "Prefix": "CID",
            "Index": 1,
            "Baudrate": 500_000,
            "AcceptanceMask": 0xFFFFFFFF,
        },
        "CID2": {"Index": 2, "DeviceArrayIndex": 1},
    }
    assert [skipped.split("=")[0] for skipped in found.skipped] == [
        "CID1 Flags",
        "CID1 IClass",
        r"[HKEY_LOCAL_MACHINE\Drivers\BuiltIn\Serial1]",
    ]


def test_it_is_merged(tmp_path: Path) -> None:
    """What the file does not name stays; `-` lets a default count, a key with - in front takes a device away."""
    store = RegistryStore(tmp_path / "canwire.toml")
    store.path.write_text(
        '# mine\n[candrv.CID1]\nBoard = "netdcu"\nbaudrate = 125000 # slow\n[candrv.CID3]\n'
    )
    store.merge(reg_file.load(written(tmp_path, BOARD)).devices)
    assert store.devices() == ["CID1", "CID2", "CID3"]
    settings = store.settings("CID1")
    assert (settings.board, settings.baudrate, settings.acceptance_mask) == ("netdcu", 500_000, 0xFFFFFFFF)
    assert store.settings("CID2").device_array_index == 1
    assert store.path.read_text().startswith("# mine\n")
    text = HEAD + CID1 + '"Baudrate"=-\n[-HKEY_LOCAL_MACHINE\\Drivers\\BuiltIn\\CID3]\n'
    store.merge(reg_file.load(written(tmp_path, text, "cp1252")).devices)
    assert store.devices() == ["CID1", "CID2"]
    assert store.settings("CID1").baudrate == 1_000_000


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "board.reg:1: a .reg file begins with"),
        ("[candrv.CID1]\n", "board.reg:1: a .reg file begins with"),
        (HEAD + CID1 + '"Baudrate"=dword:00200000\n', "board.reg:4: Baudrate = 2097152"),
        (HEAD + CID1 + '"Baudrate"="fast"\n', "board.reg:4: Baudrate = 'fast'"),
        (HEAD + CID1 + '"Baudrate"=hex:20,a1,07,00\n', "board.reg:4: 'hex:20,a1,07,00'"),
        (HEAD + CID1 + "Baudrate: 5\n", "board.reg:4: 'Baudrate: 5' is neither"),
    ],
)
def test_what_is_wrong(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(BadConfig) as raised:
        reg_file.load(written(tmp_path, text))
    assert message in str(raised.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(BadConfig, match="No such file"):
        reg_file.load(tmp_path / "none.reg")


def test_two_devices_of_one_name_are_not_stored(tmp_path: Path) -> None:
    store = RegistryStore(tmp_path / "canwire.toml")
    text = (
        HEAD
        + CID1
        + "[HKLM\\Drivers\\BuiltIn\\OTHER]\n"
        + '"Dll"="candrv.dll"\n"Index"=dword:1\n"Prefix"="CID"\n'
    )
    with pytest.raises(BadValue, match="CID1: is the name of"):
        store.merge(reg_file.load(written(tmp_path, text)).devices)
    assert not store.path.exists()
